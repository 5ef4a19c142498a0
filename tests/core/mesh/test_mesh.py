"""Triangulation, welding, placing and the sentences about meshes that cannot be printed."""

import numpy as np
import pytest
from dualcolor.core.errors import MeshError, TextureError
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.model import SurfaceModel, ToneImage
from dualcolor.core.settings import PrintSettings
from hypothesis import given, settings
from hypothesis import strategies as st

BOX_QUADS = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
SETTINGS = PrintSettings()
FREE = PrintSettings(center_on_bed=False)


def box(low=(0, 0, 0), high=(10, 20, 30)):
    (x0, y0, z0), (x1, y1, z1) = low, high
    ring = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
    return np.array([[*p, z0] for p in ring] + [[*p, z1] for p in ring], dtype=float)


def model(vertices, polygons, uv=None, tone=None, texture=None, textures=(), name="Thing"):
    start = np.concatenate([[0], np.cumsum([len(p) for p in polygons])]).astype(np.int64)
    corner = np.array([v for p in polygons for v in p], dtype=np.int64)
    texture = np.full(len(polygons), -1) if texture is None else np.asarray(texture)
    return SurfaceModel(np.asarray(vertices, float), start, corner, uv, tone, texture, textures, name)


def prism(outline, height=10.0):
    """A closed prism over a plane outline, with n-gons as its top and bottom."""
    outline = np.asarray(outline, float)
    n = len(outline)
    vertices = np.concatenate([np.c_[outline, np.zeros(n)], np.c_[outline, np.full(n, height)]])
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    return vertices, [list(range(n))[::-1], list(range(n, 2 * n)), *sides]


def face_vectors(mesh):
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    return np.cross(b - a, c - a) / 2


def volume(mesh):
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6


def is_closed(mesh):
    """Every directed edge has exactly one partner the other way round."""
    edges = np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]])
    return sorted(map(tuple, edges)) == sorted(map(tuple, edges[:, ::-1]))


def test_a_box_of_quads_is_closed_and_keeps_its_volume():
    mesh = triangulate(model(box(), BOX_QUADS), SETTINGS)
    assert len(mesh.faces) == 12 and is_closed(mesh)
    assert volume(mesh) == pytest.approx(6000)
    assert mesh.bounds == pytest.approx(np.array([[-5, -10, 0], [5, 10, 30]]))


def test_without_centering_the_object_stays():
    vertices = box((20, -30, 1), (40, 10, 5))
    mesh = triangulate(model(vertices, BOX_QUADS), FREE)
    assert np.array_equal(mesh.bounds, [[20, -30, 1], [40, 10, 5]])


@pytest.mark.parametrize(
    ("arrow", "area"),
    [
        ([[0, 0], [10, 10], [0, 30], [2, 10]], 120),  # the diagonal from the notch is the shorter one
        ([[0, 0], [40, 5], [0, 10], [5, 5]], 175),  # it is the longer one
    ],
)
@pytest.mark.parametrize("turn", range(4))
def test_a_concave_quad_is_cut_inside(arrow, area, turn):
    mesh = triangulate(model(*prism(np.roll(arrow, turn, axis=0))), SETTINGS)
    assert is_closed(mesh)
    top = face_vectors(mesh)[:, 2]
    assert top[top > 1e-9].sum() == pytest.approx(area)
    assert top[top < -1e-9].sum() == pytest.approx(-area)


def test_a_flat_quad_is_cut_by_its_shorter_diagonal():
    kite = [[0, 0], [1, -1], [10, 0], [1, 1]]
    mesh = triangulate(model(*prism(kite)), SETTINGS)
    level = mesh.vertices[mesh.faces][:, :, 2].std(axis=1) == 0
    spans = np.ptp(mesh.vertices[mesh.faces[level]][:, :, 1], axis=1)
    assert spans == pytest.approx(np.full(4, 2.0))  # all four halves hold both corners 1 and 3


def test_a_concave_polygon_keeps_its_area_and_every_corner():
    comb = [
        [0, 0],
        [50, 0],
        [50, 20],
        [40, 20],
        [40, 5],
        [30, 5],
        [30, 20],
        [20, 20],
        [20, 5],
        [10, 5],
        [10, 20],
        [0, 20],
    ]
    comb.insert(1, [25, 0])  # lies on a straight edge, where a neighbor may meet it
    mesh = triangulate(model(*prism(comb)), SETTINGS)
    assert is_closed(mesh)
    assert volume(mesh) == pytest.approx(10 * (50 * 5 + 3 * 10 * 15))
    up = face_vectors(mesh)[:, 2]
    assert up[up > 1e-9].sum() == pytest.approx(700)
    assert len(mesh.faces) == 2 * (len(comb) - 2) + 2 * len(comb)


def test_a_polygon_around_a_hole_keeps_its_area():
    keyhole = [[0, 0], [40, 0], [40, 40], [0, 40], [0, 0], [10, 10], [10, 30], [30, 30], [30, 10], [10, 10]]
    mesh = triangulate(model(*prism(keyhole)), SETTINGS)
    up = face_vectors(mesh)[:, 2]
    assert up[up > 1e-9].sum() == pytest.approx(1200)


def test_a_collapsed_polygon_does_no_harm():
    vertices, polygons = box(), [*BOX_QUADS, [0, 1, 0, 1, 0], [0, 1, 2, 1, 0], [4, 5]]
    mesh = triangulate(model(vertices, polygons), SETTINGS)
    assert volume(mesh) == pytest.approx(6000)
    assert (np.diff(np.sort(mesh.faces, axis=1), axis=1) > 0).all()


@settings(deadline=None)
@given(st.lists(st.floats(3, 30), min_size=5, max_size=12), st.integers(0, 2), st.booleans())
def test_any_star_polygon_keeps_its_area_and_winding(radii, axis, mirrored):
    angle = np.linspace(0, 2 * np.pi, len(radii), endpoint=False)
    outline = np.c_[radii * np.cos(angle), radii * np.sin(angle)]
    vertices, polygons = prism(outline)
    vertices = np.roll(vertices, axis, axis=1) + np.array([0, 0, 50])
    if mirrored:
        polygons = [p[::-1] for p in polygons]
    mesh = triangulate(model(vertices, polygons), SETTINGS)
    following = np.roll(outline, -1, axis=0)
    area = np.sum(outline[:, 0] * following[:, 1] - outline[:, 1] * following[:, 0]) / 2
    assert is_closed(mesh)
    assert volume(mesh) == pytest.approx((-10 if mirrored else 10) * area, rel=1e-6)


def test_corners_keep_their_uv_tone_and_texture():
    vertices, polygons = prism([[0, 0], [20, 0], [30, 10], [20, 20], [5, 12], [0, 20]])
    corner = np.array([v for p in polygons for v in p])
    uv = vertices[corner][:, :2] / 40 + vertices[corner][:, 2:] / 100
    texture = np.arange(len(polygons)) % 3 - 1
    gray = ToneImage(np.zeros((2, 2), np.float32), np.ones((2, 2), np.float32))
    shape = model(vertices, polygons, uv, uv.sum(axis=1), texture, (gray, gray))
    mesh = triangulate(shape, FREE)
    expected = mesh.vertices[mesh.faces]
    expected = expected[..., :2] / 40 + expected[..., 2:] / 100
    assert mesh.face_uv == pytest.approx(expected)
    assert mesh.face_tone == pytest.approx(expected.sum(axis=2))
    assert np.bincount(mesh.face_texture + 1).sum() == len(mesh.faces)
    level = np.ptp(expected[:, :, 0], axis=1) >= 0
    bottom = (mesh.vertices[mesh.faces][:, :, 2] == 0).all(axis=1) & level
    assert (mesh.face_texture[bottom] == -1).all() and bottom.sum() == 4


def test_duplicate_vertices_are_welded():
    corners = box()[np.array([v for p in BOX_QUADS for v in p])]
    polygons = np.arange(24).reshape(6, 4).tolist()
    mesh = triangulate(model(corners, polygons), SETTINGS)
    assert len(mesh.vertices) == 8 and is_closed(mesh)


def test_vertices_apart_by_float_noise_are_welded_wherever_they_lie():
    rng = np.random.default_rng(3)
    for _ in range(20):
        corners = box(rng.uniform(-30, 0, 3), rng.uniform(10, 40, 3))[np.array([v for p in BOX_QUADS for v in p])]
        noisy = (corners + rng.uniform(-2e-6, 2e-6, corners.shape)).astype(np.float32)
        mesh = triangulate(model(noisy, np.arange(24).reshape(6, 4).tolist()), SETTINGS)
        assert len(mesh.vertices) == 8 and is_closed(mesh)


def test_distinct_vertices_stay_distinct():
    vertices, polygons = prism([[0, 0], [50, 0], [50, 50], [25.001, 50], [25, 50], [0, 50]])
    assert len(triangulate(model(vertices, polygons), SETTINGS).vertices) == 12


def test_faces_that_collapse_in_the_weld_go():
    vertices = np.concatenate([box(), box()[:1]])
    mesh = triangulate(model(vertices, [*BOX_QUADS, [0, 8, 1]]), SETTINGS)
    assert len(mesh.faces) == 12


def test_vertices_without_a_face_do_not_count():
    vertices = np.concatenate([[[np.nan] * 3, [1e9, 0, 0]], box()])
    mesh = triangulate(model(vertices, [[v + 2 for v in p] for p in BOX_QUADS]), SETTINGS)
    assert len(mesh.vertices) == 8 and volume(mesh) == pytest.approx(6000)


def test_uvs_that_are_not_finite_lose_the_texture():
    uv = np.zeros((24, 2))
    uv[4, 1] = np.nan
    gray = ToneImage(np.zeros((2, 2), np.float32), np.ones((2, 2), np.float32))
    mesh = triangulate(model(box(), BOX_QUADS, uv, None, np.zeros(6, int), (gray,)), SETTINGS)
    assert np.isfinite(mesh.face_uv).all()
    assert 1 <= np.count_nonzero(mesh.face_texture == -1) <= 2
    assert np.isnan(mesh.face_tone).all()


def nan_box():
    vertices = box()
    vertices[3, 1] = np.nan
    return model(vertices, BOX_QUADS)


@pytest.mark.parametrize(
    ("shape", "settings", "words"),
    [
        (model(np.zeros((0, 3)), []), SETTINGS, ["Thing has no faces"]),
        (model(box(), []), SETTINGS, ["Thing has no faces"]),
        (model(box(), [[0, 1]]), SETTINGS, ["Thing has no faces"]),
        (nan_box(), SETTINGS, ["a vertex whose coordinates are not finite"]),
        (model(box((0, 0, 0), (np.inf, 1, 1)), BOX_QUADS), SETTINGS, ["not finite"]),
        (model(box(), [[0, 1, 8]]), SETTINGS, ["vertices it does not have"]),
        (model(box(), [[0, 1, -1]]), SETTINGS, ["vertices it does not have"]),
        (model(box(), BOX_QUADS, texture=[2] * 6), SETTINGS, ["textures it does not have"]),
        (model(box() * 1e200, BOX_QUADS), SETTINGS, ["3e+201 mm from the origin", "unit"]),
        (model(box() * 25, BOX_QUADS), SETTINGS, ["250 × 500 × 750 mm", "larger than the 210 × 146 × 150 mm", "unit"]),
        (model(box() * [1, 8, 1], BOX_QUADS), SETTINGS, ["10 × 160 × 30 mm", "turn it by 90°"]),
        # As high as the printer's reach, but for rounding.
        (model(box() * [1, 8, 5.00001], BOX_QUADS), SETTINGS, ["10 × 160 × 150 mm", "turn it by 90°"]),
        (model(box() * 0.03, BOX_QUADS), SETTINGS, ["0.3 × 0.6 × 0.9 mm", "unit"]),
        (model(box() * [1, 1, 0], BOX_QUADS), SETTINGS, ["0 mm high"]),
        (model(box() - [0, 0, 2], BOX_QUADS), FREE, ["2 mm below the bed"]),
        (model(box((100, 0, 0), (110, 20, 30)), BOX_QUADS), FREE, ["beyond the 210 × 146 × 150 mm"]),
        (model(box(), [[0, 0, 1], [2, 2, 6]]), SETTINGS, ["no face with an area"]),
    ],
)
def test_what_cannot_be_printed_is_said_in_one_sentence(shape, settings, words):
    with pytest.raises(MeshError) as error:
        triangulate(shape, settings)
    for word in words:
        assert word in str(error.value)
    assert error.value.hint and not str(error.value).endswith(".") and "\n" not in str(error.value)


def test_a_texture_needs_a_uv_map():
    gray = ToneImage(np.zeros((2, 2), np.float32), np.ones((2, 2), np.float32))
    with pytest.raises(TextureError, match="no UV map"):
        triangulate(model(box(), BOX_QUADS, texture=[0] * 6, textures=(gray,)), SETTINGS)
