"""The pieces of straight travels that lie outside of the rooms that they start in, for all of them at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from ..model import FloatArray, IntArray
from ..slicing.outlines import ranges

# Pairs of a line and an edge of its room that are looked at together.
_MOST_PAIRS = 1 << 20


@dataclass(frozen=True)
class Boundaries:
    """The boundaries of polygons, with E edges in all.

    Attributes:
        rings: (R,) LinearRings.
        room: (R,) int64, ascending, the polygon of each.
        points: (V, 2) mm, their vertices, each ring's first one repeated at its end.
        tail: (E,) int64, the vertex that each edge starts at; it ends at the next one.
        ring: (E,) int64.
        arc: (E,) mm along its ring where each edge starts.
        start: (S + 1,) int64, where the edges of each of S polygons start.
    """

    rings: NDArray[np.object_]
    room: IntArray
    points: FloatArray
    tail: IntArray
    ring: IntArray
    arc: FloatArray
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


def boundaries(shapes: NDArray[np.object_]) -> Boundaries:
    """The boundaries of (S,) Polygons or MultiPolygons."""
    parts, of_part = shapely.get_parts(shapes, return_index=True)
    rings, part = shapely.get_rings(parts, return_index=True)
    points, of_point = shapely.get_coordinates(rings, return_index=True)
    tail = np.flatnonzero(of_point[1:] == of_point[:-1])
    ring = of_point[tail].astype(np.int64)
    step = np.hypot(*(points[tail + 1] - points[tail]).T)
    along = np.cumsum(step) - step
    room = of_part[part].astype(np.int64)
    first = np.searchsorted(ring, np.arange(len(rings)))
    return Boundaries(
        rings=rings,
        room=room,
        points=points,
        tail=tail,
        ring=ring,
        arc=along - along[first][ring],
        start=np.searchsorted(room[ring], np.arange(len(shapes) + 1)),
    )


def pieces_outside(begin: FloatArray, end: FloatArray, walls: Boundaries, room: IntArray) -> Pieces:
    """What of straight lines lies outside of their rooms.

    Args:
        begin: (T, 2) mm.
        end: (T, 2) mm.
        walls: of the rooms.
        room: (T,) the room of each line.
    """
    pairs = np.cumsum(walls.start[room + 1] - walls.start[room])
    cuts = np.flatnonzero(np.diff(pairs // _MOST_PAIRS)) + 1
    found = [
        _crossings(part, begin[part], end[part], walls, room[part])
        for part in np.split(np.arange(len(begin)), cuts)
        if len(part)
    ]
    line, share, edge, arc = (np.concatenate(column) for column in zip(*found, strict=True))
    # Ahead of a place outside lies an even number of crossings, as a ray leaves a polygon as often as it enters it.
    outside_first = np.bincount(line, minlength=len(begin)) % 2 == 0
    within = np.flatnonzero(share < 1)
    outside_last = outside_first ^ (np.bincount(line[within], minlength=len(begin)) % 2 == 1)
    firsts, lasts = np.flatnonzero(outside_first), np.flatnonzero(outside_last)
    tips = len(firsts) + len(lasts)
    line = np.concatenate([firsts, line[within], lasts])
    share = np.concatenate([np.zeros(len(firsts)), share[within], np.ones(len(lasts))])
    none = np.full(tips, -1)
    ring = np.concatenate([none[: len(firsts)], walls.ring[edge[within]], none[len(firsts) :]])
    arc = np.concatenate([np.zeros(len(firsts)), arc[within], np.zeros(len(lasts))])
    # The line's own ends stand at 0 and 1, where no crossing does: outside goes from an odd place to an even one.
    order = np.lexsort((share, line))
    return Pieces(line[order[::2]], *(column[order].reshape(-1, 2) for column in (share, ring, arc)))


def _crossings(
    number: IntArray, begin: FloatArray, end: FloatArray, walls: Boundaries, room: IntArray
) -> tuple[IntArray, FloatArray, IntArray, FloatArray]:
    """The line, the share of it, the edge and the arc at each crossing of rays from some begins through their ends."""
    count = walls.start[room + 1] - walls.start[room]
    edge, line = ranges(walls.start[room], count), np.repeat(np.arange(len(room)), count)
    origin, along = begin.take(line, axis=0), (end - begin).take(line, axis=0)
    tail, head = (walls.points.take(walls.tail[edge] + step, axis=0) - origin for step in (0, 1))
    left_tail, left_head = (along[:, 0] * each[:, 1] - along[:, 1] * each[:, 0] for each in (tail, head))
    # A vertex on the ray counts for one of its two edges or for both or none.
    cut = np.flatnonzero((left_tail > 0) != (left_head > 0))
    of_edge = left_tail[cut] / (left_tail[cut] - left_head[cut])
    place = tail[cut] + of_edge[:, None] * (head[cut] - tail[cut])
    along, line, edge = along[cut], line[cut], edge[cut]
    share = np.einsum("ij,ij->i", place, along) / np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
    ahead = np.flatnonzero(share > 0)
    length = np.hypot(*(head[cut] - tail[cut])[ahead].T)
    return number[line[ahead]], share[ahead], edge[ahead], walls.arc[edge[ahead]] + of_edge[ahead] * length
