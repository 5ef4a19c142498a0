"""Paths along the boundary rings of polygons, for all travels at once."""

from __future__ import annotations

import numpy as np
import shapely

from ..model import FloatArray, IntArray
from ..ragged import ranges, starts, summable
from ..slicing.pieces_outside import Boundaries, Pieces


def on_rings(
    outside: Pieces, tips: FloatArray, walls: Boundaries, room: IntArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """The place on a ring of both ends of each piece; for an end that is on no ring, the nearest place.

    Args:
        outside: P pieces of T lines.
        tips: (T, 2, 2) mm, where the lines begin and end.
        walls: boundaries of the rooms.
        room: (T,) the room of each line.

    Returns:
        (P, 2) int64 ring, (P, 2) mm along it and (P, 2, 2) mm place of either end.
    """
    ring, arc = outside.ring.copy(), outside.arc.copy()
    begin, end = tips[outside.line].transpose(1, 0, 2)
    places = begin[:, None] + outside.share[..., None] * (end - begin)[:, None]
    piece, side = np.nonzero(ring < 0)
    if len(piece):
        found = _nearest(walls, places[piece, side], room[outside.line[piece]])
        ring[piece, side], arc[piece, side] = found
        places[piece, side] = shapely.get_coordinates(shapely.line_interpolate_point(walls.rings[found[0]], found[1]))
    return ring, arc, places


def walks_along(
    walls: Boundaries, ring: IntArray, arc: FloatArray, ends: FloatArray, distance_mm: float
) -> tuple[FloatArray, IntArray]:
    """Paths beside rings from one place on a ring to another, the shorter way round.

    Args:
        walls: with the rings.
        ring: (P,) the ring of each way; a way between different rings means nothing.
        arc: (P, 2) mm along it where the way begins and ends.
        ends: (P, 2, 2) mm, the places there.
        distance_mm: from the rings, to the side where the polygon is.

    Returns:
        (N, 2) mm, the places of all ways one after the other; (P + 1,) where each way starts.
    """
    low, high = summable(arc.T.copy())
    used, ring = np.unique(ring, return_inverse=True)
    inside_left = shapely.is_ccw(walls.rings[used]) != walls.hole[used]
    vertices, arc, base, length = _unrolled(walls, used)
    ahead = (high - low) % length[ring]
    backwards = ahead > length[ring] / 2
    low = np.where(backwards, high, low)
    way = np.where(backwards, length[ring] - ahead, ahead)
    first = np.searchsorted(arc, base[ring] + low, side="right")
    count = np.maximum(np.searchsorted(arc, base[ring] + low + way, side="left") - first, 0)
    start = starts(count + 2)
    places = np.empty((int(start[-1]), 2))
    places[start[:-1]], places[start[1:] - 1] = ends[:, 0], ends[:, 1]
    step = ranges(0, count)
    pair = np.repeat(np.arange(len(count)), count)
    step = np.where(backwards[pair], count[pair] - 1 - step, step)
    places[ranges(start[:-1] + 1, count)] = vertices[first[pair] + step]
    left = np.where(inside_left[ring] != backwards, distance_mm, -distance_mm)
    return _beside(places, start, np.repeat(left, count + 2)), start


def _beside(points: FloatArray, start: IntArray, left: FloatArray) -> FloatArray:
    """(N, 2) mm, points of lines moved to the left by (N,) mm, with mitres of up to two distances."""
    place = np.ascontiguousarray(points).view(np.complex128).ravel()
    step = np.diff(place, append=place[-1:])
    step[start[1:] - 1] = 0.0
    # Where a line begins or ends, or stands still, the direction on the other side counts alone.
    length = np.abs(step)
    leaving = step / np.where(length > 0, length, 1.0)
    arriving = np.roll(leaving, 1)
    cosine = (leaving * arriving.conj()).real
    place = place + 1j * left * (leaving + arriving) / np.maximum(1 + cosine, 0.5)
    return np.column_stack([place.real, place.imag])


def _nearest(walls: Boundaries, points: FloatArray, room: IntArray) -> tuple[IntArray, FloatArray]:
    """(P,) the ring of its room that each point is nearest to, and (P,) mm along it where."""
    first_ring = np.searchsorted(walls.room, np.arange(int(walls.room[-1]) + 2))
    count = first_ring[room + 1] - first_ring[room]
    ring = ranges(first_ring[room], count)
    pair = np.repeat(np.arange(len(room)), count)
    away = shapely.distance(walls.rings[ring], shapely.points(points)[pair])
    order = np.lexsort((away, pair))
    best = ring[order[starts(count)[:-1]]]
    return best, np.asarray(shapely.line_locate_point(walls.rings[best], shapely.points(points)))


def _unrolled(walls: Boundaries, ring: IntArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Each of (R,) rings twice in a row, so that no path passes the seam of its ring.

    Returns:
        (N, 2) mm, the vertices; (N,) mm along all rings, ascending; (R,) where each ring begins; (R,) mm, its length.
    """
    first, count = walls.ring_start[ring], walls.ring_start[ring + 1] - walls.ring_start[ring]
    length = walls.arc[first + count - 1]
    base = np.cumsum(2 * length + 1) - 2 * length - 1
    vertex = ranges(np.repeat(first, 2), np.repeat(count, 2))
    begin = np.column_stack([base, base + length]).ravel()
    return walls.points.take(vertex, axis=0), walls.arc[vertex] + np.repeat(begin, np.repeat(count, 2)), base, length
