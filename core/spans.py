"""How far each point of the strands lies from what carries it: the strands of the layer below."""

from __future__ import annotations

from functools import partial

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
    level = np.repeat(layer, np.diff(start))
    arc = _arc(points, start)
    open_ = np.flatnonzero(level > level.min())
    free[open_] = FARTHEST
    for reach, spacing in _SEARCHES:
        below = np.flatnonzero(_thinned(arc, start, spacing))
        carriers = points[below, :2]
        search = partial(_nearest, PointGrid(carriers, level[below], reach), carriers)
        found, is_near = in_chunks(search, points[open_, :2], level[open_] - 1)
        near, carrier = open_[is_near], below[found[is_near]]
        distance = _to_strand(points[near, :2], carrier, points, start)
        hit = distance <= reach
        free[near[hit]] = np.clip(distance - width[carrier] / 2, 0.0, FARTHEST)[hit]
        is_settled = is_near.copy()
        is_settled[is_near] = hit
        open_ = open_[~is_settled]
    return free


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


def _nearest(grid: PointGrid, points: FloatArray, query: FloatArray, layer: IntArray) -> tuple[IntArray, BoolArray]:
    """(Q,) index of the nearest of a layer's points, and whether there is any in the cells around."""
    found, group = grid.candidates(query, layer)
    if not len(found):
        return np.zeros(len(query), dtype=np.int64), np.zeros(len(query), dtype=bool)
    counts = np.diff(group)
    x = points[found, 0] - np.repeat(query[:, 0], counts)
    y = points[found, 1] - np.repeat(query[:, 1], counts)
    where, is_near = nearest(x * x + y * y, group)
    return found[where], is_near


def _to_strand(query: FloatArray, at: IntArray, points: FloatArray, start: IntArray) -> FloatArray:
    """(Q,) mm from each query to the nearer of the two segments that meet at its point `at` of a strand."""
    ends = np.zeros(len(points), dtype=bool)
    ends[start[1:] - 1] = True
    begins = np.zeros(len(points), dtype=bool)
    begins[start[:-1]] = True
    squares = [
        _square_to_segment(query, points[at, :2], points[at + step, :2])
        for step in (np.where(ends[at], 0, 1), np.where(begins[at], 0, -1))
    ]
    distance: FloatArray = np.sqrt(np.minimum(*squares))
    return distance


def _square_to_segment(query: FloatArray, begin: FloatArray, end: FloatArray) -> FloatArray:
    way, out = end - begin, query - begin
    length = np.einsum("ij,ij->i", way, way)
    share = np.clip(np.einsum("ij,ij->i", way, out) / np.maximum(length, 1e-12), 0.0, 1.0)
    off = out - share[:, None] * way
    square: FloatArray = np.einsum("ij,ij->i", off, off)
    return square
