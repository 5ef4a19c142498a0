"""Walls, skins and fill against analytic shapes, and invariants on random ones."""

import numpy as np
import pytest
import shapely
from dualcolor.core.fill import parallel
from dualcolor.core.fill.hatch import crossings, spans
from dualcolor.core.fill.paths import fill_paths
from dualcolor.core.fill.skins import remainder, solid_and_sparse
from dualcolor.core.fill.walls import simplified, walls_and_fill
from dualcolor.core.settings import PrintSettings
from dualcolor.core.toolpaths.moves import Feature
from hypothesis import given, settings
from hypothesis import strategies as st

WIDTH = 0.4
EDGE = WIDTH * (0.5 - 0.15)  # from the last wall's centre line to the boundary of the fill


def square(side, x=0.0, y=0.0):
    return shapely.box(x - side / 2, y - side / 2, x + side / 2, y + side / 2)


def annulus(outer, inner, x=0.0, y=0.0):
    return shapely.difference(square(outer, x, y), square(inner, x, y))


def shapes(items):
    column = np.empty(len(items), dtype=object)
    column[:] = items
    return column


def stack(layers, inset=1.0):
    """Sliced layers, and one island a layer, set back as the waved wall would leave it."""
    sliced = shapes(layers)
    return sliced, shapely.buffer(sliced, -inset, join_style="mitre"), np.arange(len(layers))


def blobs(count, seed, span=20.0):
    """Wobbly regions with wobbly holes."""
    random = np.random.default_rng(seed)
    turn = np.linspace(0, 2 * np.pi, 240, endpoint=False)
    waves = np.arange(2, 14)

    def ring(radius):
        wobble = (random.normal(size=(12, 1)) / waves[:, None] * np.cos(waves[:, None] * turn)).sum(axis=0)
        reach = radius * np.maximum(1 + 0.5 * wobble, 0.2)
        return shapely.Polygon(np.stack([reach * np.cos(turn), reach * np.sin(turn)], axis=1))

    made = [shapely.difference(ring(span), shapely.affinity.translate(ring(span / 5), span / 4)) for _ in range(count)]
    return shapes([shapely.buffer(shape, 0) for shape in made])


def table_is_sound(paths):
    counts = np.diff(paths.start)
    assert paths.start[0] == 0 and paths.start[-1] == len(paths.points) == len(paths.width)
    assert (counts >= np.where(paths.closed, 3, 2)).all()
    assert np.isfinite(paths.points).all() and (paths.width == WIDTH).all()
    assert len(counts) == len(paths.layer) == len(paths.feature) == len(paths.island) == len(paths.closed)


def lines_of(paths, feature=None, layer=None):
    """The chosen paths as shapely lines, closed ones closed."""
    lines = []
    for k in range(len(paths.layer)):
        if feature in (None, paths.feature[k]) and layer in (None, paths.layer[k]):
            points = paths.points[paths.start[k] : paths.start[k + 1]]
            lines.append(shapely.LineString(np.concatenate([points, points[:1]]) if paths.closed[k] else points))
    return shapes(lines)


def length_along(lines, angle_deg):
    """Total length of the segments in one direction."""
    total = 0.0
    for line in lines:
        steps = np.diff(shapely.get_coordinates(line), axis=0)
        length = np.linalg.norm(steps, axis=1)
        across = steps @ [-np.sin(np.radians(angle_deg)), np.cos(np.radians(angle_deg))]
        total += length[np.abs(across) < 1e-6].sum()
    return total


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
        walls, fill = walls_and_fill(islands, plan)
        assert len(walls) == perimeters
        assert fill[0].bounds[2] == pytest.approx(10 - WIDTH * (perimeters + 0.5 - overlap / 100))


@pytest.mark.parametrize("angle", [0.0, 17.0, 45.0, 90.0])
def test_solid_fill_covers_the_area_once(angle):
    sliced, islands, layer = stack([annulus(40, 12)])
    plan = PrintSettings(infill_density=100, infill_angle=angle)
    paths = fill_paths(sliced, islands, layer, plan)
    fill = walls_and_fill(islands, plan)[1][0]
    lines = lines_of(paths, Feature.SKIN)
    assert shapely.length(lines).sum() * WIDTH == pytest.approx(fill.area, rel=0.03)
    assert shapely.covers(fill.buffer(1e-6), lines).all()
    assert len(lines) <= 6  # the ring falls into a few cells
    printed = shapely.union_all(shapely.buffer(lines, 0.5 * WIDTH + 1e-3))
    assert shapely.difference(fill.buffer(-WIDTH), printed).area < 0.005 * fill.area


@given(st.lists(st.tuples(st.integers(-6, 6), st.integers(-6, 6)), min_size=3, max_size=9), st.integers(1, 2))
@settings(max_examples=80, deadline=None)
def test_vertices_on_scan_lines_do_not_break_the_pairing(corners, spacing):
    region = shapely.buffer(shapely.make_valid(shapely.Polygon(corners)), 0)
    on_grid = shapely.set_precision(shapely.set_precision(region, 1.0), 0.0)  # every vertex is on a scan line
    column = shapes([on_grid])
    cut = crossings(column, np.zeros(1), np.full(1, float(spacing)))
    found = spans(cut)
    assert (cut.line[found.left] == cut.line[found.right]).all()
    for line in range(-7, 8):
        row = cut.line[found.left] == line
        height = line * spacing + 1e-7  # a line takes what is just above it
        inside = shapely.intersection(on_grid, shapely.LineString([(-50, height), (50, height)]))
        assert (cut.x[found.right] - cut.x[found.left])[row].sum() == pytest.approx(inside.length, abs=1e-4)


def test_skins_of_a_box_are_the_layers_asked_for():
    sliced, islands, layer = stack([square(22)] * 20)
    paths = fill_paths(sliced, islands, layer, PrintSettings(bottom_solid_layers=2, top_solid_layers=4))
    assert sorted(set(paths.layer[paths.feature == Feature.SKIN])) == [0, 1, 16, 17, 18, 19]
    assert sorted(set(paths.layer[paths.feature == Feature.INFILL])) == list(range(2, 16))


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
    fill = walls_and_fill(islands, plan)[1]
    solid, sparse = solid_and_sparse(sliced, fill, layer, plan)
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
    solid, _ = solid_and_sparse(sliced, walls_and_fill(islands, plan)[1], layer, plan)
    assert np.flatnonzero(shapely.area(solid) > 1).tolist() == [0, 1, 2, 3, 4, 8, 9, 10, 11, 12, 15]


def test_steep_walls_and_slivers_make_no_skin():
    steep = [square(40 - 0.3 * k) for k in range(12)]  # the wall itself is thicker than three layers' slope
    sliced, islands, layer = stack(steep)
    plan = PrintSettings()
    solid, _ = solid_and_sparse(sliced, walls_and_fill(islands, plan)[1], layer, plan)
    assert (shapely.area(solid[3:-3]) == 0).all()
    notched = [square(40)] * 5 + [shapely.difference(square(40), shapely.box(-0.08, -9, 0.08, 9))] + [square(40)] * 5
    islands = shapes([square(38)] * 11)
    solid, _ = solid_and_sparse(shapes(notched), walls_and_fill(islands, plan)[1], np.arange(11), plan)
    assert (shapely.area(solid[3:-3]) == 0).all()


def test_a_wrong_overlay_is_noticed_and_done_again(monkeypatch):
    exact = shapely.difference
    monkeypatch.setattr(shapely, "difference", lambda a, b, grid_size=None: exact(a, b, grid_size) if grid_size else a)
    rest = remainder(shapes([square(10), square(8)]), shapes([square(4), square(8)]))
    assert shapely.area(rest).tolist() == pytest.approx([84.0, 0.0])


def test_small_sparse_remnants_become_solid_unless_hollow():
    sliced, islands, layer = stack([square(6)] * 9)  # 3 mm across inside the wall
    for density, features in ((10.0, {Feature.SKIN}), (0.0, set())):
        paths = fill_paths(sliced, islands, layer, PrintSettings(infill_density=density))
        assert set(paths.feature[(paths.layer == 4) & (paths.feature != Feature.INNER_WALL)]) == features


@pytest.mark.parametrize("pattern", ["rectilinear", "grid"])
@pytest.mark.parametrize("density", [5.0, 10.0, 25.0, 60.0])
def test_density_is_the_share_of_the_area_under_lines(density, pattern):
    sliced, islands, layer = stack([square(102)] * 2)
    plan = PrintSettings(
        bottom_solid_layers=0, top_solid_layers=0, infill_density=density, infill_pattern=pattern, infill_angle=30
    )
    paths = fill_paths(sliced, islands, layer, plan)
    area = walls_and_fill(islands, plan)[1][0].area
    for k, directions in enumerate(((30, 120), (30, 120)) if pattern == "grid" else ((30,), (-30,))):
        lengths = [length_along(lines_of(paths, Feature.INFILL, k), direction) for direction in directions]
        assert sum(lengths) * WIDTH / area == pytest.approx(density / 100, rel=0.04)
        assert np.ptp(lengths) < 0.05 * sum(lengths)


def test_hollow_and_massive():
    sliced, islands, layer = stack([square(22)] * 9)
    hollow = fill_paths(sliced, islands, layer, PrintSettings(infill_density=0))
    assert set(hollow.layer[hollow.feature == Feature.SKIN]) == {0, 1, 2, 6, 7, 8}
    assert not (hollow.feature == Feature.INFILL).any()
    massive = fill_paths(sliced, islands, layer, PrintSettings(infill_density=100))
    assert set(massive.feature) == {Feature.INNER_WALL, Feature.SKIN}
    assert set(massive.layer[massive.feature == Feature.SKIN]) == set(range(9))


def test_sparse_lines_of_every_second_layer_stack_up():
    outline = blobs(1, 3)[0]
    shifted = [square(60), square(60), shapely.union(square(60), square(20, 30, 7)), square(60)]
    sliced, islands, layer = stack([*shifted, outline])
    plan = PrintSettings(bottom_solid_layers=0, top_solid_layers=0)
    paths = fill_paths(sliced, islands, layer, plan)

    def offsets(k, angle):
        steps = [shapely.get_coordinates(line) for line in lines_of(paths, Feature.INFILL, k)]
        normal = np.array([-np.sin(np.radians(angle)), np.cos(np.radians(angle))])
        found = [line[:-1] @ normal for line in steps]
        along = [np.abs(np.diff(line, axis=0) @ normal) < 1e-6 for line in steps]
        return np.concatenate(found)[np.concatenate(along)]

    for k in range(5):
        lines = offsets(k, 45 if k % 2 == 0 else -45) / 4.0
        assert len(lines) > 4 and np.allclose(lines, np.round(lines), atol=1e-6)


@pytest.mark.parametrize("pattern", ["rectilinear", "grid"])
def test_random_regions_are_filled_once_and_never_left(pattern):
    islands = blobs(24, 7)
    layer = np.arange(24) // 2
    plan = PrintSettings(infill_density=30, infill_pattern=pattern, bottom_solid_layers=1, top_solid_layers=2)
    sliced = shapes([shapely.unary_union(list(islands[layer == k])) for k in range(12)])
    paths = fill_paths(sliced, islands, layer, plan)
    table_is_sound(paths)
    _, fill = walls_and_fill(islands, plan)
    solid, sparse = solid_and_sparse(sliced, fill, layer, plan)
    assert shapely.area(shapely.intersection(solid, sparse)).max() < 1e-6
    scanned, printed = 0, 0
    for feature, regions in ((Feature.SKIN, solid), (Feature.INFILL, sparse)):
        lines, island = lines_of(paths, feature), paths.island[paths.feature == feature]
        assert len(lines) and (paths.layer[paths.feature == feature] == layer[island]).all()
        assert shapely.covers(shapely.buffer(regions, WIDTH)[island], lines).all()
        for k in range(24):
            grid = feature == Feature.INFILL and pattern == "grid"
            angles = [45, 135] if grid else [45 if layer[k] % 2 == 0 else -45]
            spacing = WIDTH if feature == Feature.SKIN else WIDTH / 0.3 * len(angles)
            for angle in angles:
                cut = crossings(regions[k : k + 1], np.full(1, float(angle)), np.full(1, spacing))
                found = spans(cut)
                length = cut.x[found.right] - cut.x[found.left]
                length = length[length >= WIDTH / 2]
                if feature == Feature.SKIN:
                    length = length - np.minimum(WIDTH, length / 2)
                assert length_along(lines[island == k], angle) == pytest.approx(length.sum(), rel=1e-3, abs=0.5)
                scanned += len(length)
        printed += len(lines)
    assert printed < 0.2 * scanned  # joined into long spans


def test_joins_of_a_comb_stay_out_of_its_gaps():
    teeth = [shapely.box(3 * k, 0, 3 * k + 2, 20) for k in range(8)]
    comb = shapely.union_all([*teeth, shapely.box(0, 0, 23, 3)])
    plan = PrintSettings(infill_density=100, infill_angle=0, perimeters=0)
    islands = shapes([comb])
    lines = lines_of(fill_paths(islands, islands, np.zeros(1, dtype=np.int64), plan), Feature.SKIN)
    assert shapely.covers(comb, lines).all()
    assert len(lines) == 8  # one for each tooth, the first of them goes on into the back


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
    fill = walls_and_fill(islands, plan)[1][0]
    assert shapely.length(lines).sum() * WIDTH == pytest.approx(fill.area, rel=0.03)
    assert shapely.covers(fill.buffer(WIDTH), lines).all()


def test_tiny_empty_and_broken_regions_do_no_harm():
    bow_tie = shapely.Polygon([(0, 0), (10, 10), (10, 0), (0, 10)])
    spike = shapely.Polygon([(0, 0), (10, 0), (10, 10), (10, 0), (0, 0.001)])
    items = [shapely.Polygon(), None, square(0.1), square(0.9), square(1.3), bow_tie, spike, shapely.MultiPolygon()]
    paths = fill_paths(shapes([*items, square(30)]), shapes(items), np.arange(len(items)), PrintSettings())
    table_is_sound(paths)
    assert not set(paths.island) & {0, 1, 2, 7}
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


def test_same_input_same_paths_in_threads_or_not(monkeypatch):
    islands = blobs(36, 11)
    layer = np.arange(36) // 2
    sliced = shapes([shapely.unary_union(list(islands[layer == k])) for k in range(18)])
    first = fill_paths(sliced, islands, layer, PrintSettings())
    again = fill_paths(sliced, islands, layer, PrintSettings())
    monkeypatch.setattr(parallel, "_SHAPES_WORTH_THREADS", 1000)
    alone = fill_paths(sliced, islands, layer, PrintSettings())
    for name in ("points", "start", "layer", "feature", "island", "closed", "width"):
        assert np.array_equal(getattr(first, name), getattr(again, name))
        assert np.array_equal(getattr(first, name), getattr(alone, name))
