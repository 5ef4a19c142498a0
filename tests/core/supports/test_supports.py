"""Supports: where overhangs are held, what they keep away from, and how they are printed."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import shapely
from dualcolor.core.contours.contours import contours
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.model import SupportMark, SupportVolume
from dualcolor.core.paths import Feature, Paths
from dualcolor.core.pattern.wave import modulated
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.slices import slices
from dualcolor.core.supports import grid_overlay
from dualcolor.core.supports.columns import standing_on_bed
from dualcolor.core.supports.supports import supports
from dualcolor.core.toolpaths.loops import FirstIsland
from dualcolor.core.toolpaths.order import ordered
from dualcolor.tests.core.fill.fill_shapes import lines_of
from dualcolor.tests.real_models import obj_model
from dualcolor.tests.solids import box, joined, lathe

SETTINGS = PrintSettings(pattern="wave", support_enable=True, skirt_distance=2.0)
WIDTH = SETTINGS.extrusion_width
# From the surface to the nearest center line of a support: half a wave, the air, half a line.
CLEAR = SETTINGS.wave_depth_max / 2 + SETTINGS.support_xy_distance + WIDTH / 2
TABLE = joined(box((-3, -3, 0), (3, 3, 10)), box((-12, -8, 10), (12, 8, 14)))
TABLE_TOP = 40  # the first layer of its plate


def held(model, settings=SETTINGS):
    mesh = triangulate(model, settings)
    cut = slices(mesh, settings)
    lines = contours(cut.outlines, cut.loop_polygon, settings)
    count = len(lines.points)
    depth, _ = modulated(lines, np.full(count, 0.5), np.zeros(count), settings)
    made = supports(mesh, cut, lines, depth, settings)
    return cut, SimpleNamespace(paths=made.paths, covered=shapely.buffer(made.areas, WIDTH / 2, quad_segs=2))


def heights(paths):
    return np.unique(paths.layer)


@pytest.fixture(scope="module")
def table():
    return held(TABLE)


def test_nothing_unless_wished():
    cut, made = held(TABLE, PrintSettings())
    assert not len(made.paths.layer)
    assert len(made.covered) == len(cut.regions) and shapely.is_empty(made.covered).all()


def test_underside_of_a_table_is_held_from_the_bed(table):
    _, made = table
    assert (made.paths.island == FirstIsland.SUPPORT).all()
    # The plate rests on layer 39; one layer is air.
    assert heights(made.paths).tolist() == list(range(TABLE_TOP - 1))
    leg = shapely.box(-3, -3, 3, 3)
    underside = shapely.box(-12, -8, 12, 8).difference(leg.buffer(CLEAR, join_style="mitre"))
    for layer in (1, 20, TABLE_TOP - 2):
        area = made.covered[layer].buffer(-WIDTH / 2)
        assert area.symmetric_difference(underside).area < 0.04 * underside.area
        assert shapely.box(-12, -8, 12, 8).buffer(0.02).covers(area)
        assert area.distance(leg) >= WIDTH / 2 + SETTINGS.support_xy_distance


@pytest.mark.parametrize("raft", [0, 2])
def test_lines_on_the_bed_are_as_wide_as_the_first_layer(raft):
    wide = 1.0
    cut, made = held(TABLE, SETTINGS.changed({"first_layer_extrusion_width": wide, "raft_layers": raft}))
    paths = made.paths
    width, first = paths.width, np.repeat(paths.layer == 0, np.diff(paths.start))
    assert (width[first] == (WIDTH if raft else wide)).all() and (width[~first] == WIDTH).all()
    places, half = shapely.MultiPoint(paths.points[first]), width[first][0] / 2
    assert cut.regions[0].distance(places) - half >= SETTINGS.support_xy_distance
    beside = np.unique(paths.points[first & (np.abs(paths.points[:, 1]) > 5), 1].round(3))
    assert np.diff(beside[beside > 0]).min() >= 2 * half  # side by side at most


def test_lines_cover_the_area_evenly(table):
    _, made = table
    dense = made.paths.feature == Feature.SUPPORT_INTERFACE
    assert heights_where(made.paths, dense) == [TABLE_TOP - 3, TABLE_TOP - 2]
    for layer, feature, spacing in (
        (0, Feature.SUPPORT, 0.8),  # dense, to hold on to the bed
        (20, Feature.SUPPORT, 2.5),
        (TABLE_TOP - 2, Feature.SUPPORT_INTERFACE, 0.8),
    ):
        lines = lines_of(made.paths, feature, layer)
        area = made.covered[layer].buffer(-WIDTH / 2)
        assert 0.8 * area.area < sum(line.length for line in lines) * spacing < 1.3 * area.area
        short = np.abs(np.subtract(shapely.union_all(lines).bounds, area.bounds)).reshape(2, 2).max(axis=0)
        assert short.min() < 0.05  # along themselves, lines end at the edge
        uncovered = area.difference(shapely.union_all(lines).buffer(spacing / 2 + 0.05))
        assert uncovered.area < (0.03 if layer else 0.1) * area.area


def heights_where(paths, chosen):
    return np.unique(paths.layer[chosen]).tolist()


@pytest.mark.parametrize(("angle", "expected"), [(30, False), (50, True)])
def test_a_cone_of_45_degrees_is_held_above_its_angle_only(angle, expected):
    funnel = lathe([[4, 0], [14, 10]])
    _, made = held(funnel, SETTINGS.changed({"support_threshold_angle": angle}))
    assert bool(len(made.paths.layer)) == expected


def test_a_flat_cone_is_held_all_along():
    """At 20° every layer juts out by 0.69 mm; its support starts clear of the wall and reaches as far as the cone."""
    _, made = held(lathe([[4, 0], [4, 5], [4 + 4 / np.tan(np.radians(20)), 9]]))
    reach = np.hypot(*made.paths.points[np.repeat(made.paths.layer, np.diff(made.paths.start)) == 4].T)
    assert reach.max() == pytest.approx(4 + 4 / np.tan(np.radians(20)), abs=0.8)
    ring = made.covered[4].buffer(-WIDTH / 2)
    assert ring.area == pytest.approx(np.pi * (reach.max() ** 2 - (4 + CLEAR) ** 2), rel=0.06)


def test_a_beginning_in_the_air_is_held_by_a_column_that_stands():
    """A thin pin that hangs from a roof begins in the air: it is too small to stand on, so its column is thicker."""
    roof = joined(box((-8, -1, 0), (-6, 1, 12)), box((-8, -3, 12), (8, 3, 14)), box((3, -0.4, 8), (3.8, 0.4, 12.5)))
    cut, made = held(roof)
    pin = next(k for k in range(len(cut.regions)) if cut.regions[k].covers(shapely.Point(3.4, 0)))
    column = made.covered[pin - 2]
    under = [part for part in shapely.get_parts(column) if part.buffer(0.5).covers(shapely.Point(3.4, 0))]
    assert under and under[0].area > 10


@pytest.mark.parametrize(("width", "worth_it"), [(0.8, False), (2.0, True)])
def test_a_bump_that_holds_by_itself_gets_no_column(width, worth_it):
    """A peg on a wall: what of it a column has room for, beyond the air beside the wall, is 2 or 5 mm²."""
    wall, peg = box((-5, -5, 0), (5, 5, 20)), box((4, -width / 2, 10), (8.5, width / 2, 13))
    _, made = held(joined(wall, peg))
    assert bool(len(made.paths.layer)) == worth_it


@pytest.mark.parametrize(("strip", "worth_it"), [(0.3, False), (1.0, True)])
def test_a_long_ledge_that_hardly_clears_the_wall_gets_no_column(strip, worth_it):
    """What a support has room for under it is a strip of 40 mm, however narrow; made to stand it would be 4 mm wide."""
    wall, ledge = box((-20, -3, 0), (20, 3, 20)), box((-20, 2, 10), (20, 3 + CLEAR + 0.15 + strip, 13))
    _, made = held(joined(wall, ledge))
    assert bool(len(made.paths.layer)) == worth_it


@pytest.mark.parametrize(("height", "thickness"), [(20, 4.0), (90, 7.5)])
def test_a_tall_column_is_thicker(height, thickness):
    """Below a pin of 2 mm² that hangs from a roof: a twelfth of its height, 4 mm at least; the roof gets no support."""
    post, roof = box((-8, -3, 0), (-4, 3, height + 4)), box((-8, -3, height + 3), (8, 3, height + 5))
    model = joined(post, roof, box((4, -0.7, height), (5.4, 0.7, height + 4)))
    under = box((3, -2, height - 1), (7, 2, height + 1))
    wish = SupportVolume(SupportMark.ENFORCER, under.vertices, under.polygon_start, under.corner_vertex)
    _, made = held(replace(model, volumes=(wish,)), SETTINGS.changed({"support_auto": False}))
    layer = round(height * 0.4 / SETTINGS.layer_height)
    column = made.covered[layer].buffer(-WIDTH / 2)
    assert -0.2 < 4 * column.area / column.length - thickness < 0.8
    # Lines in a narrow one would not stand without a loop around them.
    assert made.paths.closed[made.paths.layer == layer].any() == (thickness < 2.5 * SETTINGS.support_spacing)


def test_a_thin_column_is_a_tube_with_lines_inside_only_near_its_top():
    """A column of 5 mm under a plate on a post: the lines inside carry the dense layers, and nothing below does."""
    table = joined(box((-9, -3, 0), (-5, 3, 24)), box((-9, -2.5, 20), (5, 2.5, 24)))
    blocked = box((-5, -9, 0), (0, 9, 30))
    off = SupportVolume(SupportMark.BLOCKER, blocked.vertices, blocked.polygon_start, blocked.corner_vertex)
    _, made = held(replace(table, volumes=(off,)))
    layers = np.unique(made.paths.layer)
    closed = [made.paths.closed[made.paths.layer == layer] for layer in layers]
    interface = [(made.paths.feature[made.paths.layer == layer] == Feature.SUPPORT_INTERFACE).any() for layer in layers]
    alone = [bool(kinds.all()) for kinds in closed]
    top = layers[~np.array(interface)].max()
    assert layers.tolist() == list(range(len(layers))) and top * SETTINGS.layer_height > 18
    tube = (layers > 0) & (layers <= top - 1.5 / SETTINGS.layer_height)  # the first layer is dense, to hold on
    assert alone == tube.tolist()
    for layer in layers[tube].tolist():
        (loop,) = lines_of(made.paths, Feature.SUPPORT, layer)
        assert 14 < loop.length < 22 and made.covered[layer].covers(loop)


def test_wide_supports_have_no_loop(table):
    _, made = table
    assert not made.paths.closed.any()


SHELF = joined(box((-10, -6, 0), (10, 6, 4)), box((-10, -6, 4), (-6, 6, 12)), box((-10, -6, 12), (16, 6, 14)))


def test_the_object_in_the_way_ends_the_support_or_carries_it():
    """A roof over a step, which ends at x = 7 once the whole is centered, and over the bed beside it."""
    _, everywhere = held(SHELF)
    _, from_bed = held(SHELF, SETTINGS.changed({"support_from": "bed"}))
    on_step, beside = shapely.box(-7, -4, 6, 4), shapely.box(9, -4, 12, 4)
    for layer in (20, 40):
        assert everywhere.covered[layer].covers(on_step) and everywhere.covered[layer].covers(beside)
        assert not from_bed.covered[layer].intersects(on_step) and from_bed.covered[layer].covers(beside)
    # The step's top is layer 15; layer 16 is air.
    assert not everywhere.covered[16].intersects(on_step)
    assert everywhere.covered[17].covers(on_step)


@pytest.mark.parametrize(("distance", "gap"), [(0.0, 0), (0.05, 1), (0.12, 1), (0.25, 1), (0.4, 2), (1.0, 4)])
def test_air_above_and_below_is_the_distance_in_layers(distance, gap):
    """At least one of them, if there is to be any: supports that were asked to keep apart come off."""
    _, made = held(SHELF, SETTINGS.changed({"support_z_distance": distance}))
    point = shapely.Point(2, 0)
    inside = [layer for layer in range(len(made.covered)) if made.covered[layer].covers(point)]
    assert inside == list(range(16 + gap, 48 - gap))


def test_what_stands_on_the_bed_goes_on_as_far_as_it_is_carried():
    first, second = shapely.box(0, 0, 4, 4), shapely.box(0, 0, 6, 4)
    bridge = shapely.box(0, 0, 12, 4)  # over the second column, which begins on a layer above the bed
    found = np.array([first, shapely.union(second, shapely.box(8, 0, 12, 4)), bridge, shapely.box(8, 0, 12, 4)])
    standing = standing_on_bed(found)
    assert shapely.area(standing).tolist() == pytest.approx([16, 16, 16, 0], abs=0.01)
    assert shapely.covers(shapely.buffer(first, 0.01), standing[:3]).all()


def test_the_first_layer_is_dense(table):
    _, made = table
    length = [shapely.length(lines_of(made.paths, None, layer)).sum() for layer in (0, 1)]
    assert length[0] > 2 * length[1]


def test_order_is_tower_then_supports_then_part():
    square = np.array([[0.0, 0], [10, 0], [10, 10], [0, 10]])

    def one(feature, island):
        row = [np.zeros(1, dtype=np.int64), np.full(1, int(feature)), np.full(1, island)]
        return Paths(square, np.array([0, 4]), *row, np.ones(1, dtype=bool), np.full(4, WIDTH))

    table = [one(Feature.OUTER_WALL, 0), one(Feature.SUPPORT_INTERFACE, FirstIsland.SUPPORT)]
    table += [
        one(Feature.SUPPORT, FirstIsland.SUPPORT),
        one(Feature.TOWER, FirstIsland.TOWER),
        one(Feature.SKIRT, FirstIsland.SKIRT),
    ]
    order = ordered(Paths.joined(table), PrintSettings()).feature.tolist()
    wanted = [Feature.SKIRT, Feature.TOWER, Feature.SUPPORT, Feature.SUPPORT_INTERFACE, Feature.OUTER_WALL]
    assert order == [int(feature) for feature in wanted]


def test_same_input_same_lines(table):
    _, again = held(TABLE)
    assert np.array_equal(again.paths.points, table[1].paths.points)
    assert np.array_equal(again.paths.start, table[1].paths.start)


def layer_lines(moves, layer, features):
    """The extruding moves of some features on a layer, as lines, and the width of each."""
    rows = np.flatnonzero(moves.extrudes & (moves.layer == layer) & np.isin(moves.feature, features))
    ends = np.stack([moves.position[rows - 1, :2], moves.position[rows, :2]], axis=1)
    return shapely.linestrings(ends), moves.width[rows]


@pytest.mark.parametrize(
    ("name", "height", "pattern"),
    [("spot/spot.obj", 36, "wave"), ("spot/spot.obj", 36, "offset"), ("nc/gargoyle.obj", 40, "wave_offset")],
)
def test_no_support_crosses_the_wave(data, name, height, pattern):
    """Between the strands of supports and those of the waved walls is all the air that was asked for."""
    layers = {"layer_height": 0.4, "first_layer_height": 0.4, "support_z_distance": 0.4}
    settings = SETTINGS.changed({"pattern": pattern, "first_layer_extrusion_width": 0.6, **layers})
    result = generate(obj_model(data / "meshes" / name, height), settings)
    assert result.report["tool_changes"] == result.report["layers"] - 1
    moves, seen = result.moves, 0
    assert (moves.speed[moves.feature == Feature.SUPPORT] <= settings.support_speed).all()
    for layer in range(0, result.report["layers"], 4):
        held, width = layer_lines(moves, layer, [Feature.SUPPORT, Feature.SUPPORT_INTERFACE])
        walls, wall_width = layer_lines(moves, layer, [Feature.OUTER_WALL])
        support, wall = shapely.STRtree(walls).query(held, "dwithin", 2 * WIDTH + settings.support_xy_distance)
        air = shapely.distance(held[support], walls[wall]) - (width[support] + wall_width[wall]) / 2
        assert (air > settings.support_xy_distance - 1e-6).all()
        seen += len(air) > 10
    assert seen > 5


def test_wide_walls_of_the_first_layer_keep_their_air():
    settings = SETTINGS.changed({"pattern": "offset", "first_layer_extrusion_width": 0.8})
    moves = generate(TABLE, settings).moves
    held, width = layer_lines(moves, 0, [Feature.SUPPORT])
    walls, wall_width = layer_lines(moves, 0, [Feature.OUTER_WALL])
    assert (wall_width == 0.8).all()
    air = shapely.distance(held[:, None], walls) - width[:, None] / 2 - 0.4
    assert settings.support_xy_distance < air.min() < settings.support_xy_distance + WIDTH


def test_overlaps_are_looked_for_in_portions(monkeypatch):
    """Many small columns on many layers would have more pairs than fit into memory."""
    rng = np.random.default_rng(4)
    corner, side = rng.random((60, 2)) * 10, 0.5 + 2 * rng.random((60, 2))
    boxes = shapely.box(*corner.T, *(corner + side).T)
    parts, layer, others, below = boxes[:40], np.sort(rng.integers(0, 5, 40)), boxes[40:], rng.integers(-1, 6, 20)
    met = (below[:, None] == layer) & shapely.intersects(others[:, None], parts)
    for at_once in (1, 7, 1 << 20):
        monkeypatch.setattr(grid_overlay, "_PAIRS_AT_ONCE", at_once)
        assert np.array_equal(np.stack(grid_overlay.overlapping(parts, layer, others, below)), np.stack(met.nonzero()))
