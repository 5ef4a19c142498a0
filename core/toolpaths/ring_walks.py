"""Ways along the boundaries of polygons, for all of them at once."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from ..model import BoolArray, FloatArray, IntArray
from ..slicing.outlines import ranges, starts


def walks_along(
    rings: NDArray[np.object_], room: IntArray, begin: FloatArray, end: FloatArray, owner: IntArray
) -> tuple[FloatArray, IntArray, BoolArray]:
    """The shorter ways along a ring between places on the boundary of a room, or near it.

    Args:
        rings: (R,) LinearRings, the boundaries of the rooms.
        room: (R,) of each ring, ascending; each room has one at least.
        begin: (P, 2) mm.
        end: (P, 2) mm.
        owner: (P,) the room of each pair of places.

    Returns:
        (N, 2) mm, the places of all ways one after the other; (P + 1,) where each way starts; (P,) whether both ends
        lie on the same ring, without which a way means nothing.
    """
    first_ring = np.searchsorted(room, np.arange(int(room[-1]) + 2))
    ring, low = _nearest(rings, first_ring, begin, owner)
    other, high = _nearest(rings, first_ring, end, owner)
    length = shapely.length(rings)
    ahead = (high - low) % length[ring]
    backwards = ahead > length[ring] / 2
    low = np.where(backwards, high, low)
    way = np.where(backwards, length[ring] - ahead, ahead)
    vertices, arc, base = _unrolled(rings, length)
    first = np.searchsorted(arc, base[ring] + low, side="right")
    count = np.maximum(np.searchsorted(arc, base[ring] + low + way, side="left") - first, 0)
    start = starts(count + 2)
    places = np.empty((int(start[-1]), 2))
    tips = [_place(rings[ring], np.where(turn, (low + way) % length[ring], low)) for turn in (backwards, ~backwards)]
    places[start[:-1]], places[start[1:] - 1] = tips
    step = ranges(np.zeros(len(count), dtype=np.int64), count)
    pair = np.repeat(np.arange(len(count)), count)
    step = np.where(backwards[pair], count[pair] - 1 - step, step)
    places[ranges(start[:-1] + 1, count)] = vertices[first[pair] + step]
    return places, start, np.asarray(ring == other)


def _nearest(
    rings: NDArray[np.object_], first_ring: IntArray, points: FloatArray, owner: IntArray
) -> tuple[IntArray, FloatArray]:
    """(P,) the ring of its room that each point is nearest to, and (P,) mm along it where."""
    count = first_ring[owner + 1] - first_ring[owner]
    ring = ranges(first_ring[owner], count)
    pair = np.repeat(np.arange(len(owner)), count)
    away = shapely.distance(rings[ring], shapely.points(points)[pair])
    order = np.lexsort((away, pair))
    best = ring[order[starts(count)[:-1]]]
    return best, np.asarray(shapely.line_locate_point(rings[best], shapely.points(points)))


def _unrolled(rings: NDArray[np.object_], length: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Each ring twice in a row, so that no way passes its seam.

    Returns:
        (N, 2) mm, the vertices; (N,) mm along all rings, ascending; (R,) where each ring begins.
    """
    points, ring = shapely.get_coordinates(rings, return_index=True)
    base = np.concatenate([[0.0], np.cumsum(2 * length + 1)[:-1]])
    first = np.searchsorted(ring, np.arange(len(rings)))
    step = np.concatenate([[0.0], np.hypot(*np.diff(points, axis=0).T)])
    step[first] = 0.0
    along = np.cumsum(step)
    along -= along[first][ring]
    count = np.diff(np.append(first, len(ring)))
    once = ranges(first, count)
    twice = np.concatenate([once, once])
    arc = np.concatenate([along, along + length[ring]]) + np.concatenate([base[ring], base[ring]])
    order = np.argsort(arc, kind="stable")
    return points[twice[order]], arc[order], base


def _place(rings: NDArray[np.object_], arc: FloatArray) -> FloatArray:
    return np.asarray(shapely.get_coordinates(shapely.line_interpolate_point(rings, arc)))
