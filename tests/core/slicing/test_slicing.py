"""Slicing against analytic truths: areas, closed loops, degenerate positions, overlapping shells."""

import numpy as np
import pytest
import shapely
from dualcolor.core.errors import MeshError
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.planes import layer_stack
from dualcolor.core.slicing.regions import straightened
from dualcolor.core.slicing.slices import REGION_TOLERANCE, slices
from dualcolor.tests.solids import box, cylinder, joined, lathe, picture, surface

KEEP = PrintSettings(center_on_bed=False)


def cut(model, settings=KEEP):
    return slices(triangulate(model, settings), settings)


def areas(result):
    return shapely.area(result.regions)


def outlined(result):
    """Areas by the outlines, which are exact."""
    return np.bincount(result.outlines.layer, result.outlines.signed_area, len(result.layers))


def test_planes_lie_at_half_heights():
    stack = layer_stack(10.0, PrintSettings(layer_height=0.2, first_layer_height=0.3))
    assert stack.top[:3] == pytest.approx([0.3, 0.5, 0.7])
    assert stack.plane[:3] == pytest.approx([0.15, 0.4, 0.6])
    assert stack.plane[-1] < 10.0 <= stack.top[-1] + 0.1


def test_a_layer_is_printed_where_the_object_reaches_its_middle():
    assert len(layer_stack(1.13, PrintSettings())) == 5
    assert len(layer_stack(1.12, PrintSettings())) == 4
    assert len(layer_stack(102.0, PrintSettings())) == 408


def test_box_has_its_cross_section_on_every_layer():
    result = cut(box((-5, -10, 0), (5, 10, 7)))
    assert len(result.layers) == 28
    assert areas(result) == pytest.approx(200.0)
    assert (result.outlines.signed_area > 0).all()


def test_cone_areas_follow_its_slope():
    result = cut(lathe([[10, 0], [2, 16]], sides=400))
    radius = 10 - result.layers.plane / 2
    assert outlined(result) == pytest.approx(np.pi * radius**2, rel=2e-4)


@pytest.mark.parametrize("height", [0.125, 0.375, 1.125])
def test_faces_exactly_on_a_plane_open_no_loop(height):
    """A step whose shelf lies on a slicing plane: the vertices on the plane count as above it."""
    model = lathe([[10, 0], [10, height], [6, height], [6, 3]], sides=32)
    result = cut(model)
    polygon = 32 / 2 * np.sin(2 * np.pi / 32)
    below = result.layers.plane <= height
    assert areas(result)[below] == pytest.approx(polygon * 100)
    assert areas(result)[~below] == pytest.approx(polygon * 36)


def test_vertices_and_edges_on_every_plane_lose_no_layer():
    heights = np.arange(25) * 0.125
    result = cut(lathe(np.column_stack([8 + np.sin(heights * 9), heights]), sides=24))
    radius = 8 + np.sin(result.layers.plane * 9)
    assert areas(result) == pytest.approx(12 * np.sin(2 * np.pi / 24) * radius**2)


def test_duplicate_vertices_open_no_loop():
    whole = cylinder(sides=30)
    corners = whole.vertices[whole.corner_vertex]
    soup = surface(corners, np.arange(len(corners)).reshape(-1, 3))
    assert areas(cut(soup)) == pytest.approx(areas(cut(whole)))


def test_holes_run_clockwise_and_cavities_are_empty():
    ball = joined(box((-10, -10, 0), (10, 10, 20)), box((-4, -4, 5), (4, 4, 15), inward=True))
    result = cut(ball)
    inside = (result.layers.plane > 5) & (result.layers.plane < 15)
    assert areas(result)[inside] == pytest.approx(400 - 64)
    assert areas(result)[~inside] == pytest.approx(400)
    assert sorted(set(np.sign(result.outlines.signed_area))) == [-1, 1]


def test_overlapping_shells_are_united():
    result = cut(joined(box((0, 0, 0), (10, 10, 4)), box((5, 5, 0), (15, 15, 4))))
    assert areas(result) == pytest.approx(175.0)
    assert result.united_layers == len(result.layers)
    assert len(result.polygons) == len(result.layers)


def test_a_shell_inside_another_one_changes_nothing():
    result = cut(joined(box((0, 0, 0), (10, 10, 4)), box((3, 3, 0), (6, 6, 4))))
    assert areas(result) == pytest.approx(100.0)
    assert len(result.outlines.layer) == len(result.layers)


def test_the_same_shell_twice_is_printed_once():
    result = cut(joined(box((0, 0, 0), (10, 10, 4)), box((0, 0, 0), (10, 10, 4))))
    assert areas(result) == pytest.approx(100.0)


def test_inside_out_mesh_is_sliced_like_the_right_one():
    result = cut(box((0, 0, 0), (10, 10, 4), inward=True))
    assert areas(result) == pytest.approx(100.0)
    assert (result.outlines.signed_area > 0).all()


def test_open_mesh_is_refused_with_its_height():
    closed = box((0, 0, 0), (10, 10, 4))
    lidless = surface(closed.vertices, closed.corner_vertex.reshape(-1, 3)[:-2])
    with pytest.raises(MeshError, match=r"open: no outline closes from 0\.00 to 4\.00 mm"):
        cut(lidless)


@pytest.mark.parametrize("turned", [[0], [3, 4, 7], [0, 1, 2, 3, 4, 5]])
def test_faces_turned_the_wrong_way_change_nothing(turned):
    closed = box((0, 0, 0), (10, 10, 4))
    faces = closed.corner_vertex.reshape(-1, 3).copy()
    faces[turned] = faces[turned, ::-1]
    result = cut(surface(closed.vertices, faces))
    assert areas(result) == pytest.approx(100.0)
    assert len(result.open_layers) == 0


def test_an_outline_that_does_not_close_is_left_out_and_its_layers_named():
    whole, holed = box((0, 0, 0), (10, 10, 4)), box((20, 0, 0), (30, 10, 4))
    both = joined(whole, surface(holed.vertices, holed.corner_vertex.reshape(-1, 3)[:-2]))
    result = cut(both)
    assert areas(result) == pytest.approx(100.0)
    assert result.open_layers.tolist() == list(range(len(result.layers)))


def test_a_gap_is_closed_by_its_width_and_not_beyond():
    closed = box((0, 0, 0), (10, 10, 4))
    corners = closed.vertices[closed.corner_vertex].reshape(-1, 3, 3)
    corners[-2:] -= [0.5, 0, 0]
    cracked = surface(corners.reshape(-1, 3), np.arange(36).reshape(-1, 3))
    assert len(cut(cracked, KEEP.changed({"gap_closing_radius": 0.3})).open_layers) == 0
    with pytest.raises(MeshError, match="open"):
        cut(cracked, KEEP.changed({"gap_closing_radius": 0.2}))


def test_soup_of_chains_closes_the_same_way_in_any_order():
    rng = np.random.default_rng(5)
    closed = box((0, 0, 0), (10, 10, 4))
    corners = closed.vertices[closed.corner_vertex].reshape(-1, 3, 3)
    for _ in range(5):
        order = rng.permutation(12)
        flip = rng.random(12) < 0.5
        loose = corners[order].copy()
        loose[flip] = loose[flip, ::-1]
        loose += rng.uniform(-0.01, 0.01, (12, 1, 3)) * [1, 1, 0]
        result = cut(surface(loose.reshape(-1, 3), np.arange(36).reshape(-1, 3)))
        assert areas(result) == pytest.approx(100.0, abs=0.5)


def test_small_gaps_are_closed():
    closed = box((0, 0, 0), (10, 10, 4))
    corners = closed.vertices[closed.corner_vertex].reshape(-1, 3, 3)
    corners[-2:] -= [0.04, 0, 0]
    result = cut(surface(corners.reshape(-1, 3), np.arange(36).reshape(-1, 3)))
    assert areas(result) == pytest.approx(100.0, abs=0.5)


def test_specks_that_hold_no_strand_are_left_out_and_counted():
    result = cut(joined(box((0, 0, 0), (10, 10, 4)), box((12, 0, 0), (12.2, 0.2, 4)), box((14, 0, 0), (14.4, 0.4, 4))))
    assert areas(result) == pytest.approx(100.16)
    assert len(result.specks.layer) == len(result.layers)


def test_a_sheet_has_no_inside():
    sheet = surface([[0, 0, 0], [10, 0, 0], [10, 0, 5], [0, 0, 5]], [[0, 1, 2], [0, 2, 3], [2, 1, 0], [3, 2, 0]])
    with pytest.raises(MeshError, match="no inside"):
        cut(sheet)


def test_uvs_are_those_of_the_surface():
    """On a cylinder u is the angle and v the height, everywhere and across the seam."""
    result = cut(cylinder(sides=60, textures=[picture(np.zeros((4, 4)))]))
    tail, head = result.outlines.points, result.outlines.ends
    for end, point in enumerate((tail, head)):
        u, v = result.outlines.carried[:, end, 0], result.outlines.carried[:, end, 1]
        turn = np.exp(2j * np.pi * u)
        at = (point[:, 0] + 1j * point[:, 1]) / np.hypot(point[:, 0], point[:, 1])
        # Between its corners a facet's UV is linear along the chord, the angle is not: 60 sides differ by < 0.001.
        assert np.abs(turn - at).max() < 1e-3
        assert v == pytest.approx(result.layers.plane[result.outlines.layer[result.outlines.loop]] / 10)
    assert (np.abs(np.diff(result.outlines.carried[:, :, 0], axis=1)) < 0.02).all()


def test_united_layers_keep_the_uvs():
    parts = [cylinder(radius=6, height=3, sides=48, x=x, textures=[picture(np.zeros((2, 2)))]) for x in (0.0, 7.0)]
    faces = np.concatenate([parts[0].corner_vertex, parts[1].corner_vertex + len(parts[0].vertices)]).reshape(-1, 3)
    uv = np.concatenate([part.corner_uv for part in parts])
    model = surface(np.concatenate([part.vertices for part in parts]), faces, uv, parts[0].textures)
    result = cut(model)
    assert result.united_layers
    lines = result.outlines
    center = np.where(lines.face < len(faces) // 2, 0.0, 7.0)
    for end, point in enumerate((lines.points, lines.ends)):
        angle = np.arctan2(point[:, 1], point[:, 0] - center) / (2 * np.pi)
        off = np.abs((angle - lines.carried[:, end, 0] + 0.5) % 1 - 0.5)
        assert off.max() < 1e-3


@pytest.mark.parametrize(
    ("name", "height"), [("spot/spot.obj", 60), ("gutenberg/Gutenberg.obj", 60), ("nc/kitten.obj", 54)]
)
def test_real_models_have_the_volume_of_their_mesh(data, name, height):
    from dualcolor.tests.real_models import obj_model

    model = obj_model(data / "meshes" / name, height)
    mesh = triangulate(model, PrintSettings())
    result = slices(mesh, PrintSettings())
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->i", np.cross(a, b), c).sum() / 6
    assert areas(result) @ result.layers.height == pytest.approx(volume, rel=2e-3)
    assert shapely.is_valid(result.regions).all()


def test_a_mesh_of_which_few_faces_are_cut_is_sliced_like_those_faces_alone():
    """Rings of faces between the planes are left out before anything else is asked about them."""
    heights = np.concatenate([[0.0], np.linspace(0.13, 0.37, 40), np.linspace(0.38, 0.62, 40), [1.0]])
    fine, coarse = (cut(lathe(np.column_stack([np.full(len(z), 9.0), z]))) for z in (heights, heights[[0, -1]]))
    assert outlined(fine) == pytest.approx(outlined(coarse))
    assert np.array_equal(fine.outlines.start, coarse.outlines.start)


def test_regions_are_their_outlines_with_fewer_points():
    result = cut(lathe([[10, 0], [2, 16]], sides=1500))
    loops = shapely.linearrings(result.outlines.points, indices=result.outlines.loop)
    away = shapely.hausdorff_distance(shapely.boundary(result.polygons), loops)
    assert away.max() < REGION_TOLERANCE
    assert shapely.get_num_coordinates(result.polygons).sum() < 0.3 * len(result.outlines.points)


def test_straight_lines_lose_points_but_corners_tips_and_slivers_stay():
    square = [[x, 0.0] for x in range(9)] + [[8.0, 8.0], [0.0, 8.0]]
    spike = [[0.0, 0.0], [4.0, 0.0], [9.0, 0.001], [4.0, 0.002], [0.0, 4.0]]
    sliver = [[0.0, 0.0], [5.0, -1e-3], [10.0, 0.0], [5.0, 1e-3]]
    points, start = straightened(np.array(square + spike + sliver), np.array([0, 11, 16, 20]), 0.01)
    first, second, third = (points[start[k] : start[k + 1]].tolist() for k in range(3))
    assert len(first) < 8 and all(corner in first for corner in ([0.0, 0.0], [8.0, 0.0], [8.0, 8.0], [0.0, 8.0]))
    assert [9.0, 0.001] in second
    assert third == sliver
