"""Walls, skins and fill against analytic shapes, and invariants on random ones."""

import numpy as np
import pytest
import shapely
from dualcolor.core import parallel
from dualcolor.core.fill.mitres import moved
from dualcolor.core.fill.offsets import offset, offset_outlines, simplified
from dualcolor.core.fill.skins import remainder, skins, solid_and_sparse
from dualcolor.core.fill.walls import walls_and_fill
from dualcolor.core.paths import Feature
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.core.fill.fill_shapes import (
    WIDTH,
    annulus,
    blobs,
    fill_paths,
    lines_of,
    shapes,
    square,
    stack,
    table_is_sound,
)
from shapely import affinity


def shared(sliced, fill, layer, plan):
    """Skins and sparse fill of islands."""
    return solid_and_sparse(fill, skins(fill, layer, sliced, plan), plan)


def test_walls_step_inwards_by_the_line_width():
    sliced, islands, layer = stack([square(22)])
    paths = fill_paths(sliced, islands, layer, PrintSettings(perimeters=3))
    table_is_sound(paths)
    walls = lines_of(paths, Feature.INNER_WALL)
    assert len(walls) == 3
    for k, wall in enumerate(walls, start=1):
        assert np.allclose(wall.bounds, np.array([-1, -1, 1, 1]) * (10 - k * WIDTH))
        assert wall.length == pytest.approx(8 * (10 - k * WIDTH))


def test_walls_follow_holes_and_know_their_sense():
    sliced, islands, layer = stack([annulus(30, 10)])
    outer, hole = sorted(
        lines_of(fill_paths(sliced, islands, layer, PrintSettings()), Feature.INNER_WALL), key=lambda w: -w.length
    )
    assert np.allclose(outer.bounds[2], 14 - WIDTH) and shapely.is_ccw(shapely.LinearRing(outer))
    assert np.allclose(hole.bounds[2], 6 + WIDTH) and not shapely.is_ccw(shapely.LinearRing(hole))


def test_fill_reaches_into_the_last_wall_by_the_overlap():
    islands = shapes([square(20)])
    for perimeters, overlap in ((0, 0.0), (1, 15.0), (2, 50.0)):
        plan = PrintSettings(perimeters=perimeters, infill_overlap=overlap)
        walls, fill, _ = walls_and_fill(islands, np.full(len(islands), WIDTH), plan)
        assert len(walls) == 1 + perimeters
        assert fill[0].bounds[2] == pytest.approx(10 - WIDTH * (perimeters + 0.5 - overlap / 100))


def test_walls_cut_off_where_necks_begin_leave_no_hairs():
    wedge = shapely.Polygon([(0, 0), (20, -1.2), (20, 1.2)])
    islands = shapes([affinity.rotate(wedge, angle, origin=(0, 0)) for angle in range(0, 90, 3)])
    wall = walls_and_fill(islands, np.full(len(islands), WIDTH), PrintSettings())[0][1]
    assert (shapely.length(wall) > 20).all()
    without = offset(offset(wall, -1e-4), 1e-4)
    assert np.allclose(shapely.length(wall), shapely.length(without), atol=0.01)


def test_skins_of_a_box_are_the_layers_asked_for():
    sliced, islands, layer = stack([square(22)] * 20)
    paths = fill_paths(sliced, islands, layer, PrintSettings(bottom_solid_layers=2, top_solid_layers=4))
    assert sorted(set(paths.layer[paths.feature == Feature.SKIN])) == [0, 1, 16, 17, 18, 19]
    assert sorted(set(paths.layer[paths.feature == Feature.INFILL])) == list(range(2, 16))


@pytest.mark.parametrize(("area", "solid"), [(0.0, []), (10.0, [6]), (60.0, [6, 10]), (10000.0, [6, 10, 22])])
def test_small_sparse_fill_is_solid(area, solid):
    """Square posts, of whose inside 2.92, 6.92 and 18.92 mm across are to be filled."""
    plan = PrintSettings(solid_infill_below_area=area)
    for side in (6, 10, 22):
        paths = fill_paths(*stack([square(side)] * 20), plan)
        (feature,) = set(paths.feature[(paths.layer == 10) & (paths.feature != Feature.INNER_WALL)])
        assert (feature == Feature.SKIN) == (side in solid)


def test_no_skins_when_none_are_asked_for():
    sliced, islands, layer = stack([square(22)] * 6)
    paths = fill_paths(sliced, islands, layer, PrintSettings(bottom_solid_layers=0, top_solid_layers=0))
    assert not (paths.feature == Feature.SKIN).any()
    assert set(paths.layer[paths.feature == Feature.INFILL]) == set(range(6))


@pytest.mark.parametrize("upside_down", [False, True])
def test_skins_of_a_step_pyramid_lie_on_its_steps(upside_down):
    steps = [square(40)] * 5 + [square(28)] * 5 + [square(16)] * 5
    solid_layers = {"bottom_solid_layers": 3, "top_solid_layers": 0} if upside_down else {"bottom_solid_layers": 0}
    sliced, islands, layer = stack(steps[::-1] if upside_down else steps)
    plan = PrintSettings(**solid_layers)
    fill = walls_and_fill(islands, np.full(len(islands), WIDTH), plan)[1]
    solid, sparse = shared(sliced, fill, layer, plan)
    for column in (solid, sparse, fill):
        column[:] = column[::-1] if upside_down else column
    expected = np.zeros(15)
    for first, side in ((2, 28.0), (7, 16.0), (12, 0.0)):  # three layers each; the sparse fill is a width smaller
        sparse_side = max(side - 2 * WIDTH, 0.0)
        expected[first : first + 3] = shapely.area(fill[first : first + 3]) - sparse_side**2
    assert np.allclose(shapely.area(solid), expected, atol=0.5)
    assert np.allclose(shapely.area(solid) + shapely.area(sparse), shapely.area(fill))


def test_more_solid_layers_below_than_above():
    steps = [square(16)] * 8 + [square(40)] * 8
    sliced, islands, layer = stack(steps)
    plan = PrintSettings(bottom_solid_layers=5, top_solid_layers=1)
    solid, _ = shared(sliced, walls_and_fill(islands, np.full(len(islands), WIDTH), plan)[1], layer, plan)
    assert np.flatnonzero(shapely.area(solid) > 1).tolist() == [0, 1, 2, 3, 4, 8, 9, 10, 11, 12, 15]


def test_steep_walls_and_slivers_make_no_skin():
    steep = [square(40 - 0.3 * k) for k in range(12)]  # the wall itself is thicker than three layers' slope
    sliced, islands, layer = stack(steep)
    plan = PrintSettings()
    solid, _ = shared(sliced, walls_and_fill(islands, np.full(len(islands), WIDTH), plan)[1], layer, plan)
    assert (shapely.area(solid[3:-3]) == 0).all()
    notched = [square(40)] * 5 + [shapely.difference(square(40), shapely.box(-0.08, -9, 0.08, 9))] + [square(40)] * 5
    islands = shapes([square(38)] * 11)
    solid, _ = shared(
        shapes(notched), walls_and_fill(islands, np.full(len(islands), WIDTH), plan)[1], np.arange(11), plan
    )
    assert (shapely.area(solid[3:-3]) == 0).all()


def test_a_wrong_overlay_is_noticed_and_done_again(monkeypatch):
    exact = shapely.difference
    monkeypatch.setattr(
        shapely, "difference", lambda a, b, grid_size=None: exact(a, b, grid_size=grid_size) if grid_size else a
    )
    rest = remainder(shapes([square(10), square(8)]), shapes([square(4), square(8)]))
    assert shapely.area(rest).tolist() == pytest.approx([84.0, 0.0])


def test_small_sparse_remnants_become_solid_unless_hollow():
    sliced, islands, layer = stack([square(6)] * 9)  # 3 mm across inside the wall
    for density, features in ((10.0, {Feature.SKIN}), (0.0, set())):
        paths = fill_paths(sliced, islands, layer, PrintSettings(infill_density=density))
        assert set(paths.feature[(paths.layer == 4) & (paths.feature != Feature.INNER_WALL)]) == features


def test_hollow_and_massive():
    sliced, islands, layer = stack([square(22)] * 9)
    hollow = fill_paths(sliced, islands, layer, PrintSettings(infill_density=0))
    assert set(hollow.layer[hollow.feature == Feature.SKIN]) == {0, 1, 2, 7, 8}
    assert set(hollow.layer[hollow.feature == Feature.BRIDGE]) == {6}
    assert not (hollow.feature == Feature.INFILL).any()
    massive = fill_paths(sliced, islands, layer, PrintSettings(infill_density=100))
    assert set(massive.feature) == {Feature.INNER_WALL, Feature.SKIN}
    assert set(massive.layer[massive.feature == Feature.SKIN]) == set(range(9))


def test_islands_keep_their_numbers_and_layers():
    apart = [square(12, -20), square(12, 20)]
    sliced = shapes([shapely.MultiPolygon(apart), shapely.MultiPolygon(apart), shapely.Polygon(), square(12, 20)])
    islands = shapes([square(10, -20), square(10, 20), square(10, 20), square(10, -20), square(10, 20)])
    layer = np.array([0, 0, 1, 1, 3])  # in no order inside a layer
    paths = fill_paths(sliced, islands, layer, PrintSettings(top_solid_layers=1, bottom_solid_layers=1))
    table_is_sound(paths)
    assert (paths.layer == layer[paths.island]).all()
    middle = np.add.reduceat(paths.points[:, 0], paths.start[:-1]) / np.diff(paths.start)
    assert (np.sign(middle) == np.array([-1, 1, 1, -1, 1])[paths.island]).all()
    for feature in (Feature.INNER_WALL, Feature.SKIN):
        assert set(paths.island[paths.feature == feature]) == set(range(5))


def test_an_island_of_several_parts_with_holes_is_filled_whole():
    islands = shapes([shapely.MultiPolygon([annulus(30, 10, -20), square(14, 20)])])
    plan = PrintSettings()
    paths = fill_paths(islands, islands, np.zeros(1, dtype=np.int64), plan)
    assert (paths.feature == Feature.INNER_WALL).sum() == 3
    lines = lines_of(paths, Feature.SKIN)
    fill = walls_and_fill(islands, np.full(len(islands), WIDTH), plan)[1][0]
    assert shapely.length(lines).sum() * WIDTH == pytest.approx(fill.area, rel=0.03)
    assert shapely.covers(fill.buffer(WIDTH), lines).all()


def test_tiny_empty_and_broken_regions_do_no_harm():
    bow_tie = shapely.Polygon([(0, 0), (10, 10), (10, 0), (0, 10)])
    spike = shapely.Polygon([(0, 0), (10, 0), (10, 10), (10, 0), (0, 0.001)])
    items = [shapely.Polygon(), None, square(0.1), square(0.9), square(1.3), bow_tie, spike, shapely.MultiPolygon()]
    paths = fill_paths(shapes([*items, square(30)]), shapes(items), np.arange(len(items)), PrintSettings())
    table_is_sound(paths)
    assert not set(paths.island) & {0, 1, 2, 7}
    assert shapely.length(lines_of(paths, Feature.INNER_WALL)).min() >= 2 * WIDTH
    assert shapely.area(simplified(shapes([bow_tie]), 0.02))[0] == pytest.approx(50, rel=0.02)
    halves = lines_of(paths, Feature.INNER_WALL, 5)
    assert len(halves) == 2
    none = np.zeros(0, dtype=object)
    assert len(fill_paths(none, none, np.zeros(0, dtype=np.int64), PrintSettings()).layer) == 0
    assert len(fill_paths(shapes([square(9)]), none, np.zeros(0, dtype=np.int64), PrintSettings()).layer) == 0


def test_simplifying_moves_the_boundary_by_the_tolerance_at_most():
    before = blobs(20, 5)
    after = simplified(before, 0.02)
    assert shapely.is_valid(after).all()
    assert shapely.get_num_coordinates(after).sum() < 0.8 * shapely.get_num_coordinates(before).sum()
    for a, b in zip(shapely.boundary(before), shapely.boundary(after), strict=True):
        assert shapely.hausdorff_distance(a, b) < 0.02 + 1e-6


def star(points, reach, sharpness):
    """Points that are thin and corners between them that are sharp."""
    turn = np.arange(2 * points) * np.pi / points
    radius = np.where(np.arange(2 * points) % 2, reach * sharpness, reach)
    return shapely.Polygon(np.stack([radius * np.cos(turn), radius * np.sin(turn)], axis=1))


@pytest.mark.parametrize("distance", [-2.5, -0.4, -0.1, 0.1, 0.4, 2.5])
def test_outlines_are_offset_as_geos_does(distance):
    split = shapely.MultiPolygon([annulus(30, 10, -20), square(14, 20)])
    necked = shapely.union_all([square(8, -6), square(8, 6), shapely.box(-6, -0.3, 6, 0.3)])
    stars = [star(points, reach, sharp) for points in (3, 7, 40) for reach in (0.3, 3, 20) for sharp in (0.2, 0.9)]
    exact = [square(10), shapely.Polygon(), split, necked, square(0.7), annulus(9, 8.5), *stars]
    outlines = shapely.force_2d(np.concatenate([shapes(exact), simplified(blobs(60, 3), 0.02)]))
    outlines[::2] = shapely.reverse(outlines[::2])  # the sense of rings does not matter
    grown = offset_outlines(outlines, np.full(len(outlines), distance))
    truth = offset(outlines, distance)
    assert shapely.is_valid(grown).all()
    assert shapely.area(shapely.symmetric_difference(grown, truth)).max() < 1e-4
    if abs(distance) < 1.0:
        assert moved(outlines[-60:], np.full(60, distance)).sound.mean() > 0.85  # few need GEOS


def test_same_input_same_paths_in_threads_or_not(monkeypatch):
    islands = blobs(36, 11)
    layer = np.arange(36) // 2
    sliced = shapes([shapely.unary_union(list(islands[layer == k])) for k in range(18)])
    monkeypatch.setattr(parallel, "_LEAST_SHAPES", 5)
    first = fill_paths(sliced, islands, layer, PrintSettings())
    again = fill_paths(sliced, islands, layer, PrintSettings())
    monkeypatch.setattr(parallel, "_LEAST_SHAPES", 1000)
    alone = fill_paths(sliced, islands, layer, PrintSettings())
    for name in ("points", "start", "layer", "feature", "island", "closed", "width"):
        assert np.array_equal(getattr(first, name), getattr(again, name))
        assert np.array_equal(getattr(first, name), getattr(alone, name))
