"""The cleaning tower: form, order, place."""

from itertools import pairwise

import numpy as np
import pytest
import shapely
import shapely.affinity
from dualcolor.core.errors import MeshError, SettingsError
from dualcolor.core.paths import Feature
from dualcolor.core.toolpaths.loops import FirstIsland
from dualcolor.core.toolpaths.order import ordered
from dualcolor.core.toolpaths.placement import placed, turned
from dualcolor.core.toolpaths.surroundings import tower_where_free
from dualcolor.core.toolpaths.tower import tower_brim, tower_loops, tower_paths
from dualcolor.tests.core.toolpaths.bed import REACH, SETTINGS, loops_of, stack


def length(loop: np.ndarray) -> float:
    return shapely.LinearRing(loop).length


# The tower's form


@pytest.mark.parametrize("height", [5.0, 54.0, 102.0, 150.0])
@pytest.mark.parametrize("volume", [1.0, 6.0, 8.0, 30.0])
@pytest.mark.parametrize("layer_height", [0.1, 0.25])
def test_every_layer_purges_enough_and_little_more(height, volume, layer_height):
    settings = SETTINGS.changed({"purge_volume": volume, "layer_height": layer_height})
    loops = tower_loops(height, settings)
    laid = sum(map(length, loops)) * settings.extrusion_width * layer_height
    assert laid >= volume
    stiff = length(tower_loops(height, settings.changed({"purge_volume": 0.5}))[0])
    least = stiff * settings.extrusion_width * layer_height
    assert laid <= max(least, volume) * 1.25  # no more than the purge, or the least tower that stands


def test_the_w_is_closed_and_its_middle_leans_on_the_bar():
    (loop,) = tower_loops(100.0, SETTINGS)
    ring = shapely.LinearRing(loop)
    assert ring.is_simple and ring.is_ccw
    inside = shapely.Polygon(ring)
    # Two feet in front with a notch between them, and the bar joins the three tips behind.
    (notch,) = [part for part in shapely.get_parts(inside.convex_hull.difference(inside)) if part.area > 1]
    assert notch.bounds[1] == pytest.approx(loop[:, 1].min())
    # Its middle leans on the bar: the two strands touch, and part the inside in two cells.
    strand = ring.buffer(SETTINGS.extrusion_width / 2 + 0.01)
    assert len(strand.interiors) == 2 and min(shapely.Polygon(cell).area for cell in strand.interiors) > 10
    assert len(ring.buffer(SETTINGS.extrusion_width / 2 - 0.01).interiors) == 1


@pytest.mark.parametrize("height", [50.0, 100.0, 150.0])
def test_it_is_stiff_both_ways(height):
    """As a thin-walled column its slenderness, height over least radius of gyration, stays below 35."""
    line = shapely.LinearRing(tower_loops(height, SETTINGS.changed({"purge_volume": 0.5}))[0])
    points = np.array([line.interpolate(share, normalized=True).coords[0] for share in np.linspace(0, 1, 4001)[:-1]])
    spread = np.linalg.eigvalsh(np.cov(points.T))
    assert height / np.sqrt(spread.min()) < 35
    assert spread.max() / spread.min() < 2


def test_several_loops_lie_side_by_side():
    settings = SETTINGS.changed({"purge_volume": 20.0})
    loops = tower_loops(60.0, settings)
    assert len(loops) == 4 or len(loops) == 3
    for inner, outer in pairwise(loops):
        assert shapely.Polygon(outer).contains(shapely.Polygon(inner))
        assert shapely.LinearRing(outer).distance(shapely.LinearRing(inner)) == pytest.approx(0.4)


@pytest.mark.parametrize("volume", [6.0, 20.0])
@pytest.mark.parametrize("first", [0.3, 0.8])
def test_lines_of_the_first_layer_do_not_overlap(volume, first):
    settings = SETTINGS.changed({"purge_volume": volume, "first_layer_extrusion_width": first, "tower_brim_width": 3.0})
    paths = tower_paths(tower_loops(60.0, settings), 2, settings).first_layer
    rings = [shapely.LinearRing(loop) for loop in np.split(paths.points, paths.start[1:-1])]
    widths = paths.width[paths.start[:-1]]
    inwards = np.argsort([-ring.length for ring in rings])
    for outer, inner in pairwise(inwards):
        room = rings[outer].distance(rings[inner]) - (widths[outer] + widths[inner]) / 2
        # Loops stay where those above are, however narrow their lines are.
        assert room == pytest.approx(0.0, abs=0.02) or (0 < room < 0.12 and widths[outer] == widths[inner] == 0.3)
    assert (widths[-1] == first) == (volume == 6.0 or first < 0.4)


def test_no_layer_is_left_out_and_the_start_corner_turns():
    loops = tower_loops(100.0, SETTINGS)
    paths = tower_paths(loops, 11, SETTINGS)
    tower = paths.island >= FirstIsland.TOWER
    assert paths.layer[tower].tolist() == list(range(11))
    assert paths.closed.all() and (paths.feature == Feature.TOWER).all()
    starts = paths.points[paths.start[:-1]][tower]
    corners = loops[0]
    assert starts == pytest.approx(corners[np.arange(11) % 5])
    # Each tool, which prints every other layer, comes to all corners as well.
    assert len(np.unique(starts[0:10:2].round(6), axis=0)) == 5
    for loop in loops_of(paths, Feature.TOWER)[-11:]:
        assert length(loop) == pytest.approx(length(corners))


@pytest.mark.parametrize("seam", ["rear", "aligned"])
def test_the_order_leaves_the_tower_and_its_corners_alone(seam):
    paths = tower_paths(tower_loops(100.0, SETTINGS), 6, SETTINGS)
    order = ordered(paths, SETTINGS.changed({"seam_position": seam}))
    begun = order.points[order.start[:-1]]
    assert begun[-6:] == pytest.approx(paths.points[paths.start[:-1]][-6:])
    away = [np.hypot(*order.points[first:last].T).max() for first, last in pairwise(order.start)]
    brim = len(away) - 6
    assert brim == 8 and away[:brim] == sorted(away[:brim], reverse=True)  # from the outside in, then the W
    assert away[brim] < away[brim - 1]


def test_the_towers_own_brim_is_only_on_the_bed():
    settings = SETTINGS.changed({"tower_brim_width": 4.0, "first_layer_extrusion_width": 0.5})
    loops = tower_loops(100.0, settings)
    paths = tower_paths(loops, 3, settings)
    assert np.bincount(paths.layer).tolist() == [9, 1, 1]
    outermost = shapely.Polygon(tower_brim(loops, settings)[0])
    assert shapely.LinearRing(loops[0]).distance(outermost.exterior) == pytest.approx(4.0, abs=0.1)
    assert (paths.width[: paths.start[9]] == 0.5).all() and (paths.width[paths.start[9] :] == 0.4).all()
    assert not tower_brim(loops, settings.changed({"tower_brim_width": 0.0}))


# Its place

OBJECTS = [
    shapely.box(-20, -20, 20, 20),
    shapely.box(-104, -60, 104, -20),
    shapely.box(-104, 20, 104, 60),
    shapely.box(60, -70, 104, 70),
    shapely.MultiPolygon([shapely.box(-60, -40, -30, 40), shapely.box(30, -40, 60, 40)]),
    shapely.Point(0, 0).buffer(65).difference(shapely.Point(0, 0).buffer(40)),
]


@pytest.mark.parametrize("obstacle", OBJECTS)
@pytest.mark.parametrize("rotation", [0.0, 30.0])
def test_it_stands_near_and_clear_of_all_else(obstacle, rotation):
    settings = SETTINGS.changed({"tower_rotation": rotation})
    loops = tower_where_free(obstacle, stack(400), settings)
    outline = shapely.Polygon(tower_brim(loops, settings)[0]).buffer(0.2)
    assert REACH.covers(outline.buffer(-0.01))
    assert not obstacle.intersects(outline)
    assert outline.convex_hull.distance(obstacle) >= settings.tower_distance - 0.05
    # Half a step nearer to the middle or rather behind it, and it would be too near.
    left, front, right, back = obstacle.bounds
    way = np.array([(left + right) / 2, front + 0.75 * (back - front)]) - np.concatenate(loops).mean(axis=0)
    if np.hypot(*way) > 3.0:
        nearer = shapely.transform(outline.convex_hull, lambda points: points + way / np.hypot(*way))
        assert nearer.distance(obstacle) < settings.tower_distance or not REACH.covers(nearer)


def test_a_bay_that_is_wide_enough_holds_it():
    bay = shapely.MultiPolygon([shapely.box(-60, -60, -30, 60), shapely.box(30, -60, 60, 60)])
    center = np.concatenate(tower_where_free(bay, stack(100), SETTINGS)).mean(axis=0)
    assert abs(center[0]) < 20 and abs(center[1]) < 45


def test_the_same_place_every_time_whatever_the_rounding():
    box = shapely.box(-20, -20, 20, 20)
    nearly = shapely.box(-20 + 1e-11, -20, 20, 20 - 1e-11)
    first, second = (tower_where_free(shape, stack(100), SETTINGS)[0] for shape in (box, nearly))
    assert first == pytest.approx(second, abs=1e-6)


def test_no_room_and_no_tower():
    plate = shapely.box(-100, -70, 100, 70)
    with pytest.raises(MeshError, match="no room") as error:
        tower_where_free(plate, stack(3), SETTINGS)
    assert "tower_type" in error.value.hint
    none = SETTINGS.changed({"tower_type": "none"})
    assert tower_where_free(plate, stack(3), none) == []
    assert not len(tower_paths([], 3, SETTINGS).layer)


def test_no_tool_change_and_no_tower():
    plate, raft = shapely.box(-20, -20, 20, 20), SETTINGS.changed({"raft_layers": 3})
    assert tower_where_free(plate, stack(1), SETTINGS) == [] and tower_where_free(plate, stack(4), raft) == []
    assert tower_where_free(plate, stack(2), SETTINGS) and tower_where_free(plate, stack(5), raft)
    assert tower_where_free(plate, stack(1), SETTINGS.changed({"solid_regions": "tool_change"}))  # within the layer


def test_placed_by_hand():
    chosen = SETTINGS.changed({"tower_placement": "manual", "tower_x": 50, "tower_y": -30, "tower_rotation": 90})
    (loop,) = tower_where_free(shapely.box(-20, -20, 20, 20), stack(100), chosen)
    (upright,) = tower_loops(25.0, chosen)
    assert loop == pytest.approx(upright @ np.array([[0, 1], [-1, 0]]) + [50, -30])
    with pytest.raises(SettingsError, match="X 15, Y 0 meets the object") as error:
        tower_where_free(shapely.box(-20, -20, 20, 20), stack(100), chosen.changed({"tower_x": 15, "tower_y": 0}))
    assert "tower_x" in error.value.hint and "\n" not in str(error.value)
    with pytest.raises(SettingsError, match="reach"):
        tower_where_free(shapely.box(-20, -20, 20, 20), stack(100), chosen.changed({"tower_x": 100}))


def test_turning():
    assert turned(np.array([[1.0, 0.0], [0.0, 2.0]]), 90) == pytest.approx(np.array([[0.0, 1.0], [-2.0, 0.0]]))


def test_nothing_on_the_bed_puts_it_in_the_middle():
    x, y, _ = placed(np.array([[-5.0, -5], [5, -5], [5, 5], [-5, 5]]), shapely.Polygon(), SETTINGS)
    assert abs(x) <= 1.5 and abs(y) <= 1.5


def test_it_stands_behind_what_is_wide_at_its_rear():
    # Beside the foot, under the wings, it would be 2 mm nearer to the middle, and stand before the picture.
    winged = shapely.union(shapely.box(-14, -25, 14, 15), shapely.box(-30, 15, 30, 25))
    x, y, _ = placed(np.array([[-5.0, -5], [5, -5], [5, 5], [-5, 5]]), winged, SETTINGS)
    assert abs(x) <= 15 and 25 + 5 + SETTINGS.tower_distance <= y + 1e-6 < 36
