"""How far each point of the strands lies from what carries it: the strands of the layer below."""

from __future__ import annotations

import numpy as np

from .model import BoolArray, FloatArray, IntArray
from .pattern.chunks import in_chunks
from .pattern.grid import PointGrid, nearest

FARTHEST = 8.0
"""Unsupported distances beyond this, mm, are told as this."""

# A search looks this far, mm, among points of the layer below that are this far apart along their strands.
_SEARCHES = ((0.5, 0.2), (2.0, 0.4), (FARTHEST, 1.2))


def unsupported_distance(points: FloatArray, start: IntArray, layer: IntArray, width: FloatArray) -> FloatArray:
    """How far the centre line lies outside the strands of the layer below; 0 on material and on the bed.

    Args:
        points: (N, 3) mm of all strands; no two neighbours farther apart than about 0.5 mm.
        start: (K + 1,) where each strand's points start.
        layer: (K,); the lowest one lies on the bed.
        width: (N,) mm.

    Returns:
        (N,) mm, continuous along each strand, at most `FARTHEST`.
    """
    free = np.zeros(len(points))
    if not len(layer):
        return free
    flat = np.ascontiguousarray(points[:, :2])
    level = np.repeat(layer, np.diff(start))
    arc = _arc(flat, start)
    open_ = np.flatnonzero(level > level.min())
    free[open_] = FARTHEST
    for reach, spacing in _SEARCHES:
        below = _Carriers(flat, start, level, _thinned(arc, start, spacing), reach)
        distance, carrier = in_chunks(below.nearest, flat[open_], level[open_] - 1)
        hit = distance <= reach
        free[open_[hit]] = np.clip(distance[hit] - width[carrier[hit]] / 2, 0.0, FARTHEST)
        open_ = open_[~hit]
    return free


class _Carriers:
    """Some points of the strands, to be found by what lies above them."""

    def __init__(self, points: FloatArray, start: IntArray, level: IntArray, chosen: BoolArray, reach: float) -> None:
        self._points = points
        self._chosen = np.flatnonzero(chosen)
        self._grid = PointGrid(points[self._chosen], level[self._chosen], reach)
        # Neighbours along the strand; the ends are their own.
        self._before = np.arange(-1, len(points) - 1)
        self._before[start[:-1]] += 1
        self._after = np.arange(1, len(points) + 1)
        self._after[start[1:] - 1] -= 1

    def nearest(self, query: FloatArray, layer: IntArray) -> tuple[FloatArray, IntArray]:
        """(Q,) mm to the strands around the nearest point of a layer, inf if there is none, and (Q,) that point."""
        found, group = self._grid.candidates(query, layer)
        if not len(found):
            return np.full(len(query), np.inf), np.zeros(len(query), dtype=np.int64)
        found = self._chosen[found]
        off = self._points[found] - np.repeat(query, np.diff(group), axis=0)
        where, is_near = nearest(np.einsum("ij,ij->i", off, off), group)
        at = found[where]
        here = self._points[at]
        squares = (_square_to_segment(query, here, self._points[other[at]]) for other in (self._before, self._after))
        return np.where(is_near, np.sqrt(np.minimum(*squares)), np.inf), at


def _arc(points: FloatArray, start: IntArray) -> FloatArray:
    """(N,) mm along all strands one after the other, with a gap between two strands."""
    step = np.ones(len(points))
    step[1:] = np.sqrt((np.diff(points, axis=0) ** 2).sum(axis=1))
    step[start[:-1]] = 1.0
    return np.cumsum(step)


def _thinned(arc: FloatArray, start: IntArray, spacing: float) -> BoolArray:
    """(N,) the ends of all strands, and points between them at least about this far apart."""
    cell = np.floor(arc / spacing)
    kept = np.ones(len(arc), dtype=bool)
    kept[1:] = cell[1:] != cell[:-1]
    kept[start[:-1]] = kept[start[1:] - 1] = True
    return kept


def _square_to_segment(query: FloatArray, begin: FloatArray, end: FloatArray) -> FloatArray:
    way, out = end - begin, query - begin
    length = np.einsum("ij,ij->i", way, way)
    share = np.clip(np.einsum("ij,ij->i", way, out) / np.maximum(length, 1e-12), 0.0, 1.0)
    off = out - share[:, None] * way
    square: FloatArray = np.einsum("ij,ij->i", off, off)
    return square
