"""Travels that stay inside the part: they go around walls in the way, and do not retract where they are hidden."""

from __future__ import annotations

import numpy as np
import shapely

from ..model import BoolArray, FloatArray, IntArray, Shapes
from ..ragged import starts
from ..records import dataclass
from ..settings import PrintSettings
from ..slicing.pieces_outside import Boundaries, Pieces, boundaries, pieces_outside
from .order import OrderedPaths
from .ring_walks import on_rings, walks_along

_TOLERANCE_MM = 0.1  # by which the inside of the wall is simplified, and a way along it
# A way around is worth as much time as pulling the filament back twice, and this many times the straight way.
_DETOUR = 2.0
# How far from the wall's inside a way along it is tried, in line widths.
_BESIDE = (0.5, 0.3)


@dataclass(frozen=True)
class Rooms:
    """Where the nozzle may go unseen, for the I islands of the object.

    Attributes:
        inside: (I,) Polygon or MultiPolygon, what lies inside the line of the outer wall; maybe empty.
        above: (I,) what the next layer covers there and elsewhere; empty above the last one.
    """

    inside: Shapes
    above: Shapes


@dataclass(frozen=True)
class Travels:
    """How the nozzle gets to each of K paths.

    Attributes:
        via: (V, 2) mm, places on the way.
        start: (K + 1,) int64, where the places before each path start.
        hidden: (K,) bool, whether the travel stays inside the wall and below the next layer, so that oozing is hidden.
    """

    via: FloatArray
    start: IntArray
    hidden: BoolArray

    @property
    def count(self) -> IntArray:
        """(K,) places on the way to each path."""
        return np.diff(self.start)


def rooms(inside: Shapes, layer: IntArray, regions: Shapes) -> Rooms:
    """The rooms of islands.

    Args:
        inside: (I,) what lies inside the line of the outer wall.
        layer: (I,) of each.
        regions: (L,) cross-section of each layer, see `fill.closing.Closing`.
    """
    following = np.append(regions, np.array([shapely.Polygon()], dtype=object))
    return Rooms(inside, following[layer + 1])


def straight(paths: OrderedPaths) -> Travels:
    """Straight travels for all paths, none hidden."""
    count = len(paths.layer)
    return Travels(np.zeros((0, 2)), np.zeros(count + 1, dtype=np.int64), np.zeros(count, dtype=bool))


def travels(paths: OrderedPaths, within: Rooms | None, settings: PrintSettings) -> Travels:
    """Find the way of every travel, and whether it is hidden; only longer ones inside an island are looked at.

    A travel that would cross the outer wall follows its inner side instead, the shorter way round, unless that takes
    too long.

    Args:
        paths: K, in printing order.
        within: the islands, if they are known.
        settings: avoid_crossing_perimeters, only_retract_when_crossing_perimeters, the retraction and speeds.
    """
    plain = straight(paths)
    if within is None or not (settings.avoid_crossing_perimeters or settings.only_retract_when_crossing_perimeters):
        return plain
    begin, end = paths.ends
    far = np.hypot(*(begin[1:] - end[:-1]).T) > settings.retract_before_travel
    path = np.flatnonzero(far & (paths.island[1:] == paths.island[:-1]) & (paths.island[1:] >= 0)) + 1
    if not len(path):
        return plain
    used, room = np.unique(paths.island[path], return_inverse=True)
    inside, above = copies(within.inside[used]), copies(within.above[used])
    lines, crosses = _ways(np.stack([end[path - 1], begin[path]], axis=1), inside, room, settings)
    hidden = plain.hidden.copy()
    if settings.only_retract_when_crossing_perimeters:
        hidden[path] = ~crosses & _covers(above[room], lines)
    points, line = shapely.get_coordinates(lines, return_index=True)
    between = np.ones(len(points), dtype=bool)
    ends = starts(np.bincount(line, minlength=len(lines)))
    between[ends[:-1]] = between[ends[1:] - 1] = False
    count = np.zeros(len(hidden), dtype=np.int64)
    count[path] = np.bincount(line[between], minlength=len(lines))
    return Travels(points[between], starts(count), hidden)


def _ways(tips: FloatArray, inside: Shapes, room: IntArray, settings: PrintSettings) -> tuple[Shapes, BoolArray]:
    """(T,) lines from place to place, if need be along the outer wall's inner side; (T,) which still cross the wall.

    Args:
        tips: (T, 2, 2) mm, where the travels begin and end.
        inside: (R,) rooms.
        room: (T,) the room of each travel.
        settings: as of `travels`.
    """
    lines, walls, reach = shapely.linestrings(tips), boundaries(inside), _wall_depth(settings)
    outside = pieces_outside(tips[:, 0], tips[:, 1], walls, room)
    crosses = _longest(outside.line, np.ptp(outside.share, axis=1), len(lines)) * shapely.length(lines) > reach
    for distance in _BESIDE if settings.avoid_crossing_perimeters else ():
        chosen = np.flatnonzero(crosses)
        if not len(chosen):
            break
        around = _around(tips[chosen], outside.of(chosen), walls, room[chosen], distance * settings.extrusion_width)
        good = ~_leaves(around, inside[room[chosen]], reach) & _worth(around, lines[chosen], settings)
        lines[chosen[good]] = around[good]
        crosses[chosen[good]] = False
    return lines, crosses


def copies(shapes: Shapes) -> Shapes:
    """Copies of shapes, one for each distinct shape: a prepared shape must not be shared with another thread."""
    _, first, same = np.unique([id(shape) for shape in shapes.tolist()], return_index=True, return_inverse=True)
    copied: Shapes = shapely.force_2d(shapes[first])[same]
    return copied


def _wall_depth(settings: PrintSettings) -> float:
    """Depth of the outer wall, mm: from its line's outermost point to its inside, simplification included."""
    return 2 * settings.wave_crest + 2 * _TOLERANCE_MM


def _covers(shapes: Shapes, lines: Shapes) -> BoolArray:
    """(T,) whether each line lies in its shape; not in threads, as several lines share a shape's prepared form."""
    shapely.prepare(shapes)
    covered = np.asarray(shapely.covers(shapes, lines))
    shapely.destroy_prepared(shapes)
    return covered


def _leaves(lines: Shapes, room: Shapes, reach: float) -> BoolArray:
    """(T,) which lines cross the wall: a piece of them outside their room is longer than `reach`, mm."""
    leaves = ~_covers(room, lines)
    piece, owner = shapely.get_parts(shapely.difference(lines[leaves], room[leaves]), return_index=True)
    leaves[leaves] = _longest(owner, shapely.length(piece), int(leaves.sum())) > reach
    return leaves


def _longest(owner: IntArray, length: FloatArray, count: int) -> FloatArray:
    """(count,) the greatest of each owner's lengths, 0 for an owner without any."""
    longest = np.zeros(count)
    np.maximum.at(longest, owner, length)
    return longest


def _worth(around: Shapes, lines: Shapes, settings: PrintSettings) -> BoolArray:
    """(T,) ways around that take no longer than what they save: the straight lines with a retraction; see `_DETOUR`."""
    retraction = 2 * settings.retract_length / settings.retract_speed * settings.travel_speed
    return np.asarray(shapely.length(around) <= _DETOUR * (shapely.length(lines) + retraction))


def _around(tips: FloatArray, outside: Pieces, walls: Boundaries, room: IntArray, distance_mm: float) -> Shapes:
    """(T,) lines whose pieces outside their room follow its boundary, beside it; where that fails, straight.

    A line leaves a room and comes back through the same ring, since what lies beyond a ring is connected.

    Args:
        tips: (T, 2, 2) mm, where the lines begin and end.
        outside: the pieces.
        walls: boundaries of the rooms.
        room: (T,) the room of each line.
        distance_mm: from the boundary.
    """
    result = np.asarray(shapely.linestrings(tips))
    ring, arc, ends = on_rings(outside, tips, walls, room)
    walks, start = walks_along(walls, ring[:, 0], arc, ends, distance_mm)
    # All along a line: its begin, for each piece the walk instead, its end.
    piece = np.repeat(np.arange(len(outside.line)), np.diff(start))
    number = np.arange(len(tips))
    line = np.concatenate([number, outside.line[piece], number])
    order = np.argsort(line, kind="stable")
    routes = shapely.linestrings(np.concatenate([tips[:, 0], walks, tips[:, 1]])[order], indices=line[order])
    good = np.ones(len(tips), dtype=bool)
    good[outside.line[ring[:, 0] != ring[:, 1]]] = False
    result[good] = shapely.simplify(routes[good], _TOLERANCE_MM, preserve_topology=False)
    return result
