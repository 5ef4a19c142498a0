"""Picture plates, cylinders and lamp shades: closed, the right size, texels on layer pairs."""

import numpy as np
import pytest
from dualcolor.core.errors import MeshError
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.model import ToneImage
from dualcolor.core.pictures.shapes import fitted, picture_plate, picture_tube, surface_of
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.slices import slices
from dualcolor.core.texture.lookup import tone_at
from dualcolor.core.texture.pyramid import build_pyramids

SETTINGS = PrintSettings(texture_filter="lanczos")
TALL_FIRST = SETTINGS.changed({"first_layer_height": 0.4})


def shapes():
    yield "plate", picture_plate(30, 35.5, 2, SETTINGS)
    yield "framed plate", picture_plate(10, 8, 2, SETTINGS, frame=1.5)
    yield "plate on a tall first layer", picture_plate(10, 8, 2, TALL_FIRST)
    yield "cylinder", picture_tube(20, 20, 15, SETTINGS)
    yield "lamp shade", picture_tube(50, 30, 40, SETTINGS, wall=2.4)
    yield "lamp shade on a tall first layer", picture_tube(30, 40, 20, TALL_FIRST, wall=2)


SHAPES = dict(shapes())


def edges_of(shape):
    """(E, 2) directed edges of all polygons."""
    start, corner = shape.polygon_start, shape.corner_vertex
    ahead = np.arange(1, len(corner) + 1)
    ahead[start[1:] - 1] = start[:-1]
    return np.stack([corner, corner[ahead]], axis=1)


def volume_of(mesh):
    a, b, c = np.swapaxes(mesh.vertices[mesh.faces], 0, 1)
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6


def numbered(shape, seed=0):
    """A picture whose texels all differ."""
    rows, columns = shape.rows, shape.columns
    tone = np.random.default_rng(seed).permutation(rows * columns).reshape(rows, columns) / (rows * columns)
    return ToneImage(tone.astype(np.float32), np.ones((rows, columns), dtype=np.float32))


@pytest.mark.parametrize("name", SHAPES)
def test_each_edge_is_shared_by_two_polygons_that_run_it_opposite_ways(name):
    edges = edges_of(SHAPES[name])
    forth = np.unique(edges, axis=0)
    assert len(forth) == len(edges)
    back = np.unique(edges[:, ::-1], axis=0)
    np.testing.assert_array_equal(forth, back)


def test_sizes_and_volumes():
    plate = SHAPES["plate"]
    assert (plate.columns, plate.rows) == (60, 71)
    np.testing.assert_allclose(np.ptp(plate.vertices, axis=0), [30, 2, 35.5])
    for name, expected in {
        "plate": 30 * 35.5 * 2,
        "framed plate": 13 * 11 * 2,
        "plate on a tall first layer": 10 * 8.15 * 2,
        "cylinder": np.pi * 10**2 * 15,
        "lamp shade": np.pi * 40 / 3 * ((25**2 + 25 * 15 + 15**2) - (22.6**2 + 22.6 * 12.6 + 12.6**2)),
    }.items():
        mesh = triangulate(surface_of(SHAPES[name], numbered(SHAPES[name]), 0.5, name), SETTINGS)
        assert volume_of(mesh) == pytest.approx(expected, rel=2e-3), name


def test_a_frame_is_around_the_picture():
    plate = SHAPES["framed plate"]
    assert (plate.columns, plate.rows, plate.frame) == (26, 22, 3)
    picture = fitted(
        ToneImage(np.full((40, 50), 0.25, np.float32), np.ones((40, 50), np.float32)), plate, frame_tone=0.9
    )
    assert picture.tone.shape == (22, 26)
    np.testing.assert_allclose(picture.tone[3:-3, 3:-3], 0.25, atol=1e-6)
    border = np.ones((22, 26), dtype=bool)
    border[3:-3, 3:-3] = False
    np.testing.assert_allclose(picture.tone[border], 0.9, atol=1e-6)


@pytest.mark.parametrize("settings", [SETTINGS, TALL_FIRST], ids=["even", "tall first layer"])
def test_the_rows_of_texels_lie_on_pairs_of_layers(settings):
    """Layers 2n and 2n + 1 show row n from one side to the other, and nothing of the others."""
    plate = picture_plate(10, 8, 2, settings)
    picture = numbered(plate)
    mesh = triangulate(surface_of(plate, picture, 0.5, "plate"), settings)
    cut = slices(mesh, settings)
    assert len(cut.layers) == 2 * plate.rows
    pyramids = build_pyramids(mesh, (picture,), 2 * settings.layer_height, "lanczos")
    outlines = cut.outlines
    layer = np.repeat(outlines.layer, np.diff(outlines.start))
    front = (np.abs(outlines.points[:, 1] + 1) < 1e-6) & (np.abs(outlines.ends[:, 1] + 1) < 1e-6)
    for n in np.flatnonzero(front):
        share = (np.arange(-5, 5) + 0.5) / 10 + 0.5
        x = outlines.points[n, 0] + share * (outlines.ends[n, 0] - outlines.points[n, 0])
        uv = outlines.carried[n, 0, :2] + share[:, None] * (outlines.carried[n, 1, :2] - outlines.carried[n, 0, :2])
        tone = tone_at(pyramids, np.full(10, outlines.face[n]), uv, np.full(10, np.nan), 0.5)
        column = np.floor((x + 5) / 0.5 + 1e-9).astype(int).clip(0, 19)
        inside = np.abs((x + 5) / 0.5 - np.round((x + 5) / 0.5)) > 1e-3
        np.testing.assert_allclose(tone[inside], picture.tone[layer[n] // 2, column[inside]], atol=1e-6)
    assert set(layer[front].tolist()) == set(range(2 * plate.rows))


def test_a_picture_around_a_tube_has_no_jump_and_its_middle_in_front():
    shape = SHAPES["lamp shade"]
    polygon = np.repeat(np.arange(len(shape.has_picture)), np.diff(shape.polygon_start))
    shown = shape.has_picture[polygon]
    points, uv = shape.vertices[shape.corner_vertex[shown]], shape.corner_uv[shown]
    angle = np.arctan2(points[:, 0], -points[:, 1])  # 0 in front, growing to the right
    expected = 0.5 + angle / (2 * np.pi)
    apart = np.abs(uv[:, 0] - expected)
    assert (np.minimum(apart, 1 - apart) < 1e-9).all() and (apart < 1e-9).mean() > 0.99  # one column of seam
    np.testing.assert_allclose(uv[:, 1], points[:, 2] / 40, atol=1e-9)
    radius = np.hypot(points[:, 0], points[:, 1])
    assert radius.min() > 14.9  # the outside alone
    u = uv[:, 0].reshape(-1, 4)
    np.testing.assert_allclose(np.ptp(u, axis=1), 1 / len(np.unique(np.round(angle, 9))), rtol=0.05)


def test_pictures_are_cut_about_their_middle():
    """A wide picture loses its sides, a tall one its top and bottom, in equal parts."""
    plate = picture_plate(10, 10, 2, SETTINGS)
    ramp = np.tile(np.linspace(0, 1, 400, dtype=np.float32), (100, 1))
    tone = fitted(ToneImage(ramp, np.ones_like(ramp)), plate).tone
    np.testing.assert_allclose(tone.mean(axis=0), 0.375 + 0.25 * (np.arange(20) + 0.5) / 20, atol=4e-3)
    tone = fitted(ToneImage(ramp.T.copy(), np.ones_like(ramp.T)), plate).tone
    np.testing.assert_allclose(tone.mean(axis=1), 0.375 + 0.25 * (np.arange(20) + 0.5) / 20, atol=4e-3)


def test_transparent_parts_stay_unpainted_and_bleed_no_tone():
    plate = picture_plate(10, 10, 2, SETTINGS)
    alpha = np.ones((200, 200), dtype=np.float32)
    alpha[:, :100] = 0
    tone = np.where(alpha > 0, np.float32(0.8), np.float32(0.0))
    made = fitted(ToneImage(tone, alpha), plate)
    assert made.alpha[:, :8].max() < 0.02 and made.alpha[:, 12:].min() > 0.98
    np.testing.assert_allclose(made.tone[made.alpha > 0.1], 0.8, atol=0.05)


def test_auto_contrast_stretches_the_painted_tones_alone():
    plate = picture_plate(10, 10, 2, SETTINGS, frame=1)
    ramp = np.tile(np.linspace(0.4, 0.6, 400, dtype=np.float32), (400, 1))
    alpha = np.ones_like(ramp)
    alpha[:100], ramp[:100] = 0, 0
    made = fitted(ToneImage(ramp, alpha), plate, auto_contrast=True, frame_tone=0.7)
    tone = made.tone[10:-2, 2:-2].mean(axis=0)
    assert tone[0] < 0.03 and tone[-1] > 0.97 and tone[9:11].mean() == pytest.approx(0.5, abs=0.02)
    assert made.tone[0, 0] == pytest.approx(0.7)
    even = ToneImage(np.full((50, 50), 0.3, np.float32), np.ones((50, 50), np.float32))
    np.testing.assert_allclose(fitted(even, plate, auto_contrast=True).tone[2:-2, 2:-2], 0.3, atol=1e-6)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: picture_plate(0, 10, 2, SETTINGS), "width is 0 mm"),
        (lambda: picture_plate(10, float("nan"), 2, SETTINGS), "height is nan mm"),
        (lambda: picture_tube(20, -1, 10, SETTINGS), "top diameter is -1 mm"),
        (lambda: picture_tube(20, 10, 10, SETTINGS, wall=5), "leaves no room"),
    ],
)
def test_impossible_lengths_are_refused(make, message):
    with pytest.raises(MeshError, match=message):
        make()


@pytest.mark.parametrize("size", [(451, 300), (300, 451), (449, 299), (7, 5)])
def test_pictures_of_any_size_are_fitted_to_plates_of_their_proportions(size):
    wide, high = size
    image = ToneImage(np.full((high, wide), 0.5, dtype=np.float32), np.ones((high, wide), dtype=np.float32))
    for height in np.arange(10, 60, 1.3):
        shape = picture_plate(height * wide / high, height, 2, SETTINGS)
        assert fitted(image, shape).tone.shape == (shape.rows, shape.columns)
