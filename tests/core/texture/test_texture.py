"""Filtered look-ups against what the picture is known to be: constants, ramps, islands, gutters, alpha, footprints."""

import numpy as np
import pytest
from dualcolor.core.errors import TextureError
from dualcolor.core.model import TriangleMesh
from dualcolor.core.texture.charts import uv_charts
from dualcolor.core.texture.islands import NO_ISLAND
from dualcolor.core.texture.lookup import tone_at
from dualcolor.core.texture.pyramid import build_pyramids
from dualcolor.tests.core.texture.textured_plates import image, look_up, plates, points_on

BOTH = ["trilinear", "lanczos"]
FOOTPRINTS = [0.1, 0.5, 0.8, 2.0, 5.0, 300.0]


@pytest.mark.parametrize("size", [(64, 64), (71, 60), (1, 1), (1, 7), (100, 33)])
def test_a_constant_texture_is_constant_at_every_level(size):
    mesh = plates((0, 0, 1, 1))
    levels = build_pyramids(mesh, (image(np.full(size, 0.3)),), 0.5, "trilinear").pictures[0].levels
    assert (levels[-1].height, levels[-1].width) == (1, 1) and len(levels) == 1 + int(np.ceil(np.log2(max(size))))
    for level in levels:
        assert (level.island != NO_ISLAND).all()
        covered = 1.0 if level.coverage is None else level.coverage
        assert level.paint == pytest.approx(0.3 * covered, abs=1e-6) and level.alpha is None
    for kind in BOTH:
        for footprint in FOOTPRINTS:
            tone = look_up(mesh, [image(np.full(size, 0.3))], *points_on(mesh, [0, 1]), footprint, kind)
            assert tone == pytest.approx(0.3, abs=1e-6)


@pytest.mark.parametrize("size", [(64, 64), (71, 60), (37, 200)])
def test_the_mean_is_the_same_at_every_level(size):
    tone = np.random.default_rng(1).random(size)
    alpha = np.random.default_rng(2).random(size)
    levels = build_pyramids(plates((0, 0, 1, 1)), (image(tone, alpha),), 0.5, "trilinear").pictures[0].levels
    for level in levels[1:]:
        assert level.paint.sum() / level.coverage.sum() == pytest.approx((tone * alpha).mean(), rel=1e-5)
        assert level.alpha.sum() / level.coverage.sum() == pytest.approx(alpha.mean(), rel=1e-5)


def test_the_mean_inside_a_chart_is_kept_too():
    tone = np.random.default_rng(1).random((71, 60))
    chart = (0.21, 0.13, 0.77, 0.9)
    levels = build_pyramids(plates(chart), (image(tone),), 0.5, "trilinear").pictures[0].levels
    inside = levels[0].island != NO_ISLAND
    assert 0 < inside.sum() < inside.size
    for level in levels[1:]:
        assert level.paint.sum() / level.coverage.sum() == pytest.approx(tone.ravel()[inside].mean(), rel=1e-5)


@pytest.mark.parametrize("kind", BOTH)
@pytest.mark.parametrize("footprint", FOOTPRINTS)
def test_a_white_chart_in_a_black_gutter_stays_white(footprint, kind):
    chart = (0.207, 0.313, 0.613, 0.791)
    height, width = 117, 90
    u, v = (np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height
    painted = ((u > chart[0]) & (u < chart[2]))[None] & ((v > chart[1]) & (v < chart[3]))[:, None]
    mesh = plates(chart)
    face, uv = points_on(mesh, [0, 1])
    for alpha in (1.0, painted):
        if kind == "lanczos" and footprint < 1:  # nearest texel: the border's own texels may be the gutter's
            uv = (uv - [0.41, 0.552]) * 0.95 + [0.41, 0.552]
        tone = look_up(mesh, [image(painted, alpha)], face, uv, footprint, kind)
        assert tone == pytest.approx(1, abs=1e-6)


@pytest.mark.parametrize("footprint", FOOTPRINTS)
@pytest.mark.parametrize("border", [0.5, 0.503, 0.29])
def test_adjacent_islands_do_not_mix(border, footprint):
    height, width = 90, 117
    tone = np.broadcast_to((np.arange(width) + 0.5) / width < border, (height, width))
    mesh = plates((0, 0, border, 1), (border, 0, 1, 1))
    assert list(build_pyramids(mesh, (image(tone),), footprint, "trilinear").face_island) == [0, 0, 1, 1]
    for faces, expected in (([0, 1], 1.0), ([2, 3], 0.0)):
        found = look_up(mesh, [image(tone)], *points_on(mesh, faces), footprint)
        assert found == pytest.approx(expected, abs=1e-6)


def test_a_continuous_surface_is_one_island_and_does_mix():
    mesh = plates((0, 0, 0.5, 1), (0.5, 0, 1, 1))
    joined = np.where(np.arange(8)[mesh.faces] == 4, 1, mesh.faces)
    joined = np.where(joined == 7, 2, joined)
    mesh = TriangleMesh(mesh.vertices, joined, mesh.face_uv, mesh.face_tone, mesh.face_texture)
    tone = np.broadcast_to(np.arange(64) < 32, (64, 64))
    assert len(set(build_pyramids(mesh, (image(tone),), 0.4, "trilinear").face_island)) == 1
    found = look_up(mesh, [image(tone)], np.array([0]), np.array([[0.5, 0.25]]), 0.4)
    assert found == pytest.approx(0.5, abs=1e-6)


def test_texels_count_by_how_much_of_them_the_chart_covers():
    """Five of eight columns painted: halved, the third is half covered and says half as much as the second."""
    tone = np.broadcast_to(np.arange(8) == 4, (8, 8))
    mesh = plates((0, 0, 5 / 8, 1))
    found = look_up(mesh, [image(tone)], np.array([0]), np.array([[0.5, 0.3]]), 10.0)
    assert found == pytest.approx(1 / 3, abs=1e-6)


@pytest.mark.parametrize("size", [(64, 64), (71, 60), (100, 512)])
@pytest.mark.parametrize("footprint", [0.1, 1.0, 1.7, 4.0])
def test_a_linear_ramp_is_reproduced(footprint, size):
    height, width = size
    u, v = (np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height
    tone = 0.1 + 0.5 * u[None, :] + 0.3 * v[:, None]
    mesh = plates((0, 0, 1, 1))
    face, uv = points_on(mesh, [0, 1])
    uv = 0.25 + 0.5 * uv  # away from the border, which has no neighbors
    found = look_up(mesh, [image(tone)], face, uv, footprint)
    assert found == pytest.approx(0.1 + 0.5 * uv[:, 0] + 0.3 * uv[:, 1], abs=2e-6)


@pytest.mark.parametrize("kind", BOTH)
@pytest.mark.parametrize("chart", [(0, 0, 1, 1), (0.207, 0.313, 0.613, 0.791)])  # whose border cuts texels
def test_alpha_blends_towards_the_background(kind, chart):
    mesh = plates(chart)
    face, uv = points_on(mesh, [0, 1])
    for alpha, expected in ((0.0, 0.4), (0.25, 0.25 * 0.9 + 0.75 * 0.4), (1.0, 0.9)):
        for footprint in FOOTPRINTS:
            found = look_up(mesh, [image(np.full((64, 64), 0.9), alpha)], face, uv, footprint, kind, 0.4)
            assert found == pytest.approx(expected, abs=1e-6)


def test_the_color_behind_alpha_zero_has_no_say():
    """Half of each texel pair is clear: the average is half paint, half background, whatever the clear ones hold."""
    alpha = np.broadcast_to(np.arange(64) % 2, (64, 64))
    mesh = plates((0, 0, 1, 1))
    face, uv = points_on(mesh, [0, 1])
    for hidden in (0.0, 1.0):
        tone = np.where(alpha == 1, 0.2, hidden)
        found = look_up(mesh, [image(tone, alpha)], face, uv, 5.0, background=1.0)
        assert found == pytest.approx(0.5 * 0.2 + 0.5, abs=1e-6)


def test_the_footprint_is_measured_on_the_object():
    """A checkerboard of single texels, 0.5 mm each: sharp for a footprint of a texel, gray from two texels on."""
    board = np.indices((80, 80)).sum(axis=0) % 2
    mesh = plates((0, 0, 1, 1))
    rows, columns = np.indices((80, 80)).reshape(2, -1)
    uv = np.stack([columns + 0.5, rows + 0.5], axis=1) / 80
    face = np.zeros(len(uv), dtype=np.int64)
    assert look_up(mesh, [image(board)], face, uv, 0.5) == pytest.approx(board.ravel(), abs=1e-6)
    assert look_up(mesh, [image(board)], face, uv, 1.0) == pytest.approx(0.5, abs=1e-6)
    half = look_up(mesh, [image(board)], face, uv, 0.5 * 2**0.5)
    assert half == pytest.approx(0.25 + 0.5 * board.ravel(), abs=1e-6)
    larger = plates((0, 0, 1, 1), mm_per_uv=80.0)
    assert look_up(larger, [image(board)], face, uv, 1.0) == pytest.approx(board.ravel(), abs=1e-6)


def test_islands_on_one_another_share_their_texels():
    board = np.indices((64, 64)).sum(axis=0) % 2
    mesh = plates((0, 0, 1, 1), (0, 0, 1, 1), (1, 0, 0, 1))
    pyramids = build_pyramids(mesh, (image(board),), 2.5, "trilinear")
    assert len(set(pyramids.face_island)) == 1
    face, uv = points_on(mesh, range(6))
    assert look_up(mesh, [image(board)], face, uv, 2.5) == pytest.approx(0.5, abs=1e-6)


def test_a_repeating_pattern_wraps_and_averages():
    tone = np.random.default_rng(4).random((32, 32))
    mesh = plates((-3, -2, 9, 7), mm_per_uv=4.0)
    face, uv = points_on(mesh, [0, 1])
    assert look_up(mesh, [image(tone)], face, uv, 4.0) == pytest.approx(tone.mean(), abs=1e-5)
    fine = look_up(mesh, [image(tone)], face, uv, 0.01)
    assert look_up(mesh, [image(tone)], face, uv + np.array([5, -3]), 0.01) == pytest.approx(fine, abs=1e-5)
    corner = look_up(mesh, [image(tone)], np.array([0]), np.array([[1.0, 1.0]]), 0.01)
    assert corner == pytest.approx(tone[[0, 0, -1, -1], [0, -1, 0, -1]].mean(), abs=1e-6)


def test_a_picture_that_does_not_repeat_does_not_wrap():
    tone = np.broadcast_to(np.linspace(0, 1, 64)[:, None] > 0.5, (64, 64))
    mesh = plates((0, 0, 1, 1))
    uv = np.array([[0.3, 0.0], [0.3, 1.0]])
    for footprint in (0.1, 2.5, 10.0):
        assert look_up(mesh, [image(tone)], np.zeros(2, int), uv, footprint) == pytest.approx([0, 1])


def test_an_island_smaller_than_a_texel_takes_the_pictures_value():
    tone = np.random.default_rng(5).random((16, 16))
    swatch = (5.9 / 16, 7.9 / 16, 6.1 / 16, 8.1 / 16)
    mesh = plates(swatch, (0.7, 0.7, 0.9, 0.9), mm_per_uv=4000)
    face = np.array([0])
    found = look_up(mesh, [image(tone)], face, np.array([[6 / 16, 8 / 16]]), 0.5)
    assert found == pytest.approx(tone[7:9, 5:7].mean(), abs=1e-6)
    collapsed = TriangleMesh(
        mesh.vertices, mesh.faces, mesh.face_uv * 0 + [0.22, 0.53], mesh.face_tone, mesh.face_texture
    )
    for kind in BOTH:
        found = look_up(collapsed, [image(np.full((16, 16), 0.7))], face, np.array([[0.22, 0.53]]), 0.5, kind)
        assert found == pytest.approx(0.7, abs=1e-6)


def test_points_without_a_texture_take_the_vertex_tone_or_the_background():
    mesh = plates((0, 0, 1, 1), (0, 0, 1, 1), texture=[0, -1])
    face, uv = np.array([0, 2, 3, 3]), np.full((4, 2), 0.5)
    found = look_up(mesh, [image(np.full((4, 4), 0.2))], face, uv, 0.5, vertex_tone=np.array([0.9, 0.9, np.nan, 0.0]))
    assert found == pytest.approx([0.2, 0.9, 0.5, 0.0])
    bare = plates((0, 0, 1, 1), texture=-1)
    assert look_up(bare, [], np.array([0, 1]), uv[:2], 0.5, vertex_tone=np.array([np.inf, 0.1])) == pytest.approx(
        [0.5, 0.1]
    )


def test_every_face_looks_into_its_own_texture():
    mesh = plates((0, 0, 1, 1), (0, 0, 1, 1), (0, 0, 1, 1), texture=[2, 0, 2])
    textures = [image(np.full((8, 8), tone)) for tone in (0.1, 0.5, 0.9)]
    for kind in BOTH:
        found = look_up(mesh, textures, np.array([0, 2, 4]), np.full((3, 2), 0.4), 0.5, kind)
        assert found == pytest.approx([0.9, 0.1, 0.9])
    with pytest.raises(TextureError, match="not there"):
        build_pyramids(mesh, tuple(textures[:2]), 0.5, "trilinear")


def test_an_empty_question_and_a_second_background():
    mesh = plates((0, 0, 1, 1))
    pyramids = build_pyramids(mesh, (image(np.full((8, 8), 0.9), 0.5),), 0.5, "trilinear")
    none = np.zeros(0, np.int64)
    assert tone_at(pyramids, none, np.zeros((0, 2)), np.zeros(0), 0.5).shape == (0,)
    ask = (pyramids, np.zeros(1, int), np.full((1, 2), 0.5), np.full(1, np.nan))
    assert tone_at(*ask, 0.0) == pytest.approx(0.45) and tone_at(*ask, 1.0) == pytest.approx(0.95)


def read_obj(path):
    """Vertices, faces and face UVs of a triangulated OBJ."""
    words = [line.split() for line in path.read_text().splitlines()]
    vertices = np.array([w[1:4] for w in words if w[:1] == ["v"]], float)
    uv = np.array([w[1:3] for w in words if w[:1] == ["vt"]], float)
    corners = np.array([[c.split("/")[:2] for c in w[1:4]] for w in words if w[:1] == ["f"]], int) - 1
    return vertices, corners[..., 0], uv[corners[..., 1]]


def test_a_real_atlas_does_not_let_its_gutter_in(data):
    """Spot's charts painted white in a black picture: white everywhere on her, however wide the footprint."""
    vertices, faces, uv = read_obj(data / "meshes/spot/spot.obj")
    count = len(faces)
    mesh = TriangleMesh(vertices * 35, faces, uv, np.full((count, 3), np.nan), np.zeros(count, np.int64))
    charts = uv_charts(mesh, ((512, 512),)).labels[0] != NO_ISLAND
    assert 0.3 < charts.mean() < 0.7
    rng = np.random.default_rng(0)
    face = rng.integers(0, count, 20000)
    at = np.einsum("nk,nkd->nd", rng.dirichlet([1, 1, 1], 20000), uv[face])
    for footprint in (0.5, 2.0, 20.0):
        found = look_up(mesh, [image(charts)], face, at, footprint)
        assert np.count_nonzero(found < 1 - 1e-6) < 20  # slivers at the tips of charts that cover no texel's center
