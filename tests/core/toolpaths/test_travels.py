"""Travels inside the part: around what they would cross, unseen without retraction."""

import numpy as np
import pytest
import shapely
from dualcolor.core.paths import Feature
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.pieces_outside import boundaries, pieces_outside
from dualcolor.core.slicing.planes import Layers
from dualcolor.core.toolpaths.assemble import assemble
from dualcolor.core.toolpaths.order import OrderedPaths
from dualcolor.core.toolpaths.travels import Rooms, copies, rooms, travels
from dualcolor.tests.solids import cylinder

SETTINGS = PrintSettings()
# A U of 30 × 30 mm whose arms are 10 mm wide, and what a layer above may cover.
U = shapely.Polygon([(0, 0), (30, 0), (30, 30), (20, 30), (20, 10), (10, 10), (10, 30), (0, 30)])
WIDE = shapely.box(-10, -10, 60, 60)
NOTHING = shapely.Polygon()


def lines(*ends, island=None):
    """Straight lines of two points, all on layer 0."""
    points = np.array(ends, dtype=float).reshape(-1, 2)
    count = len(ends)
    return OrderedPaths(
        points=points,
        width=np.full(len(points), 0.4),
        start=2 * np.arange(count + 1),
        layer=np.zeros(count, dtype=np.int64),
        feature=np.full(count, int(Feature.INFILL)),
        island=np.zeros(count, dtype=np.int64) if island is None else np.array(island),
    )


def room(inside, above=WIDE):
    return Rooms(np.array([inside], dtype=object), np.array([above], dtype=object))


def way(paths, found, number=1):
    """The places from the path before to this one."""
    via = found.via[found.start[number] : found.start[number + 1]]
    ends = paths.points[[paths.start[number] - 1, paths.start[number]]]
    return shapely.LineString([ends[0], *via, ends[1]])


ARMS = lines([(5, 15), (5, 14)], [(25, 14), (25, 15)])


def test_around_the_gap_of_a_u():
    found = travels(ARMS, room(U), SETTINGS)
    route = way(ARMS, found)
    assert U.covers(route)
    assert route.distance(shapely.box(10.01, 10.01, 19.99, 31)) >= 0.5 * 0.4 - 0.11  # half a line from the wall
    shortest = 2 * np.hypot(5, 4) + 10
    assert shortest < route.length < shortest + 8  # along the wall it is not quite as short
    assert found.hidden.tolist() == [False, True]
    assert found.count.tolist() == [0, len(found.via)]


def test_the_shorter_way_around_a_hole():
    ring = shapely.Polygon([(0, 0), (40, 0), (40, 40), (0, 40)], [[(15, 10), (25, 10), (25, 34), (15, 34)]])
    paths = lines([(5, 13), (6, 13)], [(30, 13), (31, 13)])
    found = travels(paths, room(ring), SETTINGS)
    route = way(paths, found)
    assert ring.covers(route)
    assert found.via[:, 1].max() < 14  # below the hole, not above it
    # the other way round as well: the same place
    back = lines([(31, 13), (30, 13)], [(6, 13), (5, 13)])
    assert way(back, travels(back, room(ring), SETTINGS)).length == pytest.approx(route.length)


def test_inside_it_goes_straight_and_needs_no_retraction():
    paths = lines([(5, 29), (5, 28)], [(5, 3), (25, 3)])
    found = travels(paths, room(U), SETTINGS)
    assert len(found.via) == 0 and found.hidden.tolist() == [False, True]
    # from the line of the outer wall itself too, whatever rounding says
    edge = lines([(5, 29), (0, 20)], [(9.99, 12), (5, 3)])
    assert travels(edge, room(U), SETTINGS).hidden[1]


@pytest.mark.parametrize("above", [NOTHING, shapely.box(0, 0, 14, 60)])
def test_what_is_seen_from_above_is_retracted(above):
    found = travels(ARMS, room(U, above), SETTINGS)
    assert len(found.via) and not found.hidden.any()


def test_switched_off():
    both = SETTINGS.changed({"avoid_crossing_perimeters": False, "only_retract_when_crossing_perimeters": False})
    assert not travels(ARMS, room(U), both).hidden.any()
    crossing = travels(ARMS, room(U), SETTINGS.changed({"avoid_crossing_perimeters": False}))
    assert len(crossing.via) == 0 and not crossing.hidden.any()
    seen = travels(ARMS, room(U), SETTINGS.changed({"only_retract_when_crossing_perimeters": False}))
    assert len(seen.via) and not seen.hidden.any()


def test_from_island_to_island_and_too_far_around_it_goes_straight():
    apart = lines([(5, 15), (5, 14)], [(25, 14), (25, 15)], island=[0, 1])
    two = Rooms(np.array([U, U], dtype=object), np.array([WIDE, WIDE], dtype=object))
    assert len(travels(apart, two, SETTINGS).via) == 0
    tall = shapely.affinity.scale(U, 1, 40, origin=(0, 0))
    paths = lines([(5, 1100), (5, 1099)], [(25, 1099), (25, 1100)])
    found = travels(paths, room(tall), SETTINGS)
    assert len(found.via) == 0 and not found.hidden.any()
    # nor where the room falls apart
    squares = [shapely.box(0, 0, 10, 10), shapely.box(20, 0, 30, 10)]
    paths = lines([(5, 5), (5, 6)], [(25, 6), (25, 5)])
    assert len(travels(paths, room(shapely.union_all(squares)), SETTINGS).via) == 0
    # but through a neck that is narrower than a line
    neck = shapely.union_all([*squares, shapely.box(10, 0, 20, 0.3)])
    found = travels(paths, room(neck), SETTINGS)
    assert found.hidden[1] and neck.covers(way(paths, found))


def test_what_is_above_many_islands_is_copied_once():
    """A layer of many islands is above each of those below it."""
    above, other = shapely.box(0, 0, 1, 1), shapely.box(0, 0, 2, 2)
    copied = copies(np.array([above, other, above, above], dtype=object))
    assert copied[0] is copied[2] is copied[3] and copied[0] is not above
    assert shapely.area(copied).tolist() == [1, 4, 1, 1]


def test_above_is_the_next_layer():
    regions = np.array([WIDE, U, NOTHING], dtype=object)
    found = rooms(np.array([U, U, U], dtype=object), np.array([0, 1, 2]), regions)
    assert found.above.tolist() == [U, NOTHING, NOTHING]


def stack():
    top = np.array([0.25, 0.5])
    return Layers(top - 0.125, top, np.full(2, 0.25))


def test_moves_pass_by_the_places():
    found = travels(ARMS, room(U), SETTINGS)
    moves = assemble(ARMS, stack(), SETTINGS, room(U))
    laid = np.flatnonzero(moves.extrudes)
    between = slice(laid[0] + 1, laid[1])
    assert (moves.feature[between] == Feature.TRAVEL).all() and (moves.filament[between] == 0).all()
    assert moves.position[between, :2].tolist() == [*found.via.tolist(), [25, 14]]
    assert (moves.position[between, 2] == 0.25).all()
    hopping = SETTINGS.changed({"z_hop": 0.6, "wipe": 0.5})
    moves = assemble(ARMS, stack(), hopping, room(U, NOTHING))
    laid = np.flatnonzero(moves.extrudes)
    rows = np.arange(laid[0] + 1, laid[1])
    assert moves.filament[rows].sum() == pytest.approx(0) and moves.filament[rows[0]] < 0
    high = rows[moves.position[rows, 2] > 0.3]
    assert (moves.position[high, 2] == 0.85).all()
    assert moves.position[high[1:], :2].tolist() == [*found.via.tolist(), [25, 14]]


def test_a_print_retracts_less_and_crosses_less():
    bore = cylinder(radius=12, height=2)
    off = {"avoid_crossing_perimeters": False, "only_retract_when_crossing_perimeters": False, "infill_density": 20}
    plain = generate(bore, SETTINGS.changed(off)).moves
    kind = generate(bore, SETTINGS.changed({"infill_density": 20})).moves
    retractions = [(moves.filament < 0).sum() for moves in (plain, kind)]
    assert retractions[1] < 0.8 * retractions[0]
    assert kind.filament[kind.extrudes].sum() == pytest.approx(plain.filament[plain.extrudes].sum())
    # the last layer is seen: it keeps its retractions
    top = [(moves.filament[moves.layer == moves.layer.max()] < 0).sum() for moves in (plain, kind)]
    assert top[0] == top[1]


def test_pieces_outside_are_what_the_difference_leaves():
    rng = np.random.default_rng(3)
    disc = shapely.Point(0, 0).buffer(6).difference(shapely.box(-1, -2, 2, 3))
    rooms = np.array([disc, shapely.MultiPolygon([shapely.box(-5, -5, -1, 5), shapely.box(1, -5, 5, 5)])], dtype=object)
    tips, room = rng.uniform(-8, 8, (400, 2, 2)), rng.integers(0, 2, 400)
    walls = boundaries(rooms)
    found = pieces_outside(tips[:, 0], tips[:, 1], walls, room)
    lines = shapely.linestrings(tips)
    outside = np.bincount(found.line, np.ptp(found.share, axis=1), 400) * shapely.length(lines)
    assert outside == pytest.approx(shapely.length(shapely.difference(lines, rooms[room])))
    ends = tips[found.line, 0, None] + found.share[..., None] * (tips[found.line, 1] - tips[found.line, 0])[:, None]
    on = found.ring >= 0
    places = shapely.line_interpolate_point(walls.rings[found.ring[on]], found.arc[on])
    assert shapely.get_coordinates(places) == pytest.approx(ends[on], abs=1e-6)
