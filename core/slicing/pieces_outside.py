"""Where straight lines leave the regions in which they start: the pieces outside, for all lines at once."""

from __future__ import annotations

import numpy as np
import shapely

from ..model import BoolArray, FloatArray, IntArray, Shapes
from ..ragged import ranges, starts, summable
from ..records import dataclass

# Pairs of a line and an edge of its room that are tested at once.
_MOST_PAIRS = 1 << 17


@dataclass(frozen=True)
class Boundaries:
    """The boundaries of S polygons: R rings with V vertices in all, each ring's first one repeated at its end.

    Attributes:
        rings: (R,) LinearRings.
        room: (R,) int64, ascending, the polygon of each.
        hole: (R,) bool, whether it bounds a hole.
        points: (V, 2) mm, their vertices.
        arc: (V,) mm along its ring.
        ring_start: (R + 1,) int64, where the vertices of each ring start.
        start: (S + 1,) int64, where those of each polygon start.
    """

    rings: Shapes
    room: IntArray
    hole: BoolArray
    points: FloatArray
    arc: FloatArray
    ring_start: IntArray
    start: IntArray


@dataclass(frozen=True)
class Pieces:
    """P pieces of lines, in the order of the lines and along them.

    Attributes:
        line: (P,) int64.
        share: (P, 2) of the line where the piece begins and ends.
        ring: (P, 2) int64, the ring that is crossed there, -1 where the line itself begins or ends.
        arc: (P, 2) mm along that ring.
    """

    line: IntArray
    share: FloatArray
    ring: IntArray
    arc: FloatArray

    def of(self, chosen: IntArray) -> Pieces:
        """The pieces of some lines (C,), ascending, which are numbered anew."""
        number = np.searchsorted(chosen, self.line)
        kept = np.append(chosen, -1)[number] == self.line
        return Pieces(number[kept], self.share[kept], self.ring[kept], self.arc[kept])


def boundaries(shapes: Shapes) -> Boundaries:
    """The boundaries of (S,) Polygons or MultiPolygons."""
    parts, of_part = shapely.get_parts(shapes, return_index=True)
    rings, part = shapely.get_rings(parts, return_index=True)
    points = shapely.get_coordinates(rings)
    ring_start = starts(shapely.get_num_points(rings))
    x, y = np.diff(points, axis=0, prepend=0.0).T
    step = summable(np.sqrt(x * x + y * y))
    step[ring_start[:-1]] = 0.0
    arc = np.cumsum(step)
    arc -= np.repeat(arc[ring_start[:-1]], np.diff(ring_start))
    room = of_part[part].astype(np.int64)
    start = ring_start[np.searchsorted(room, np.arange(len(shapes) + 1))]
    return Boundaries(rings, room, np.append(False, part[1:] == part[:-1])[: len(part)], points, arc, ring_start, start)


def pieces_outside(begin: FloatArray, end: FloatArray, walls: Boundaries, room: IntArray) -> Pieces:
    """The pieces of straight lines that lie outside their rooms.

    Args:
        begin: (T, 2) mm.
        end: (T, 2) mm.
        walls: of the rooms.
        room: (T,) the room of each line.
    """
    pairs = np.cumsum(walls.start[room + 1] - walls.start[room])
    cuts = np.flatnonzero(np.diff(pairs // _MOST_PAIRS)) + 1
    found = [
        _crossings(part, begin[part], end[part], walls, room[part]) for part in np.split(np.arange(len(begin)), cuts)
    ]
    line, share, crossed, arc = (np.concatenate(column) for column in zip(*found, strict=True))
    # Ahead of a place outside lies an even number of crossings, as a ray leaves a polygon as often as it enters it.
    outside_first = np.bincount(line, minlength=len(begin)) % 2 == 0
    within = np.flatnonzero(share < 1)
    outside_last = outside_first ^ (np.bincount(line[within], minlength=len(begin)) % 2 == 1)
    firsts, lasts = np.flatnonzero(outside_first), np.flatnonzero(outside_last)
    tips = len(firsts) + len(lasts)
    line = np.concatenate([firsts, line[within], lasts])
    share = np.concatenate([np.zeros(len(firsts)), share[within], np.ones(len(lasts))])
    none = np.full(tips, -1)
    ring = np.concatenate([none[: len(firsts)], crossed[within], none[len(firsts) :]])
    arc = np.concatenate([np.zeros(len(firsts)), arc[within], np.zeros(len(lasts))])
    # The line's own ends stand at 0 and 1, where no crossing does: outside goes from an odd place to an even one.
    order = np.lexsort((share, line))
    return Pieces(line[order[::2]], *(column[order].reshape(-1, 2) for column in (share, ring, arc)))


def _crossings(
    number: IntArray, begin: FloatArray, end: FloatArray, walls: Boundaries, room: IntArray
) -> tuple[IntArray, FloatArray, IntArray, FloatArray]:
    """For each crossing of some lines with the walls: the line, the share of it before, the ring, and the arc there."""
    count = walls.start[room + 1] - walls.start[room]
    vertex = ranges(walls.start[room], count)
    (x, y), along = walls.points.T, end - begin
    left = np.repeat(along[:, 0], count) * y.take(vertex)
    left -= np.repeat(along[:, 1], count) * x.take(vertex)
    left -= np.repeat(along[:, 0] * begin[:, 1] - along[:, 1] * begin[:, 0], count)
    # A vertex on the ray counts for one of its two edges or for both or none. From a ring's last one no edge leaves.
    cut = np.flatnonzero((left[1:] > 0) != (left[:-1] > 0))
    is_last = np.zeros(len(walls.points), dtype=bool)
    is_last[walls.ring_start[1:] - 1] = True
    cut = cut[~is_last[vertex[cut]]]
    of_edge = left[cut] / (left[cut] - left[cut + 1])
    vertex, line = vertex[cut], np.searchsorted(np.cumsum(count), cut, side="right")
    along, origin = along[line], begin[line]
    tail, head = walls.points[vertex] - origin, walls.points[vertex + 1] - origin
    place = tail + of_edge[:, None] * (head - tail)
    share = np.einsum("ij,ij->i", place, along) / np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
    ahead = np.flatnonzero(share > 0)
    vertex, line = vertex[ahead], line[ahead]
    arc = walls.arc[vertex] + of_edge[ahead] * (walls.arc[vertex + 1] - walls.arc[vertex])
    return number[line], share[ahead], np.searchsorted(walls.ring_start, vertex, side="right") - 1, arc
