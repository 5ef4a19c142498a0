"""How far each point of the strands lies from what carries it: the strands of the layer below."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray, IntArray
from ..parallel import in_threads
from ..ragged import ranges, starts

FARTHEST = 8.0
"""Unsupported distances are limited to this, mm."""

# Points of the layer below that lie so far apart along their strands, mm, are sorted into cells of this size, mm, and
# looked for in so many rings of cells around. The first search finds what rests on material, most of all points; each
# later one is for what those before it have not found.
_SEARCHES = ((0.25, 0.2, (1, 2)), (1.0, 0.4, (1, 2)), (FARTHEST, 1.2, (1,)))
_BLOCK_POINTS = 1 << 15  # points that are worked on together, whole layers at a time: their tables stay in the cache
_BORDER = 4  # empty cells around the points; a place farther out is looked for from the second of them
_LOW_BITS = np.int64(0xFFFFFFFF)


def unsupported_distance(points: FloatArray, start: IntArray, layer: IntArray, width: FloatArray) -> FloatArray:
    """How far the center line lies outside the strands of the layer below; 0 on material and on the bed.

    Args:
        points: (N, 3) mm of all strands; no two neighbors farther apart than about 0.5 mm.
        start: (K + 1,) where each strand's points start.
        layer: (K,); the lowest one lies on the bed.
        width: (N,) mm.

    Returns:
        (N,) mm, continuous along each strand, at most `FARTHEST`.
    """
    free = np.zeros(len(points))
    if not len(layer):
        return free
    level = np.repeat(layer - layer.min(), np.diff(start))
    lines = _Lines(points, start, width)
    order = None if (np.diff(layer) >= 0).all() else np.argsort(level, kind="stable")
    begin = starts(np.bincount(level))
    cut = np.flatnonzero(np.diff(begin[1:] // _BLOCK_POINTS, prepend=-1))  # the first layer of each block

    def rows(low: int, high: int) -> IntArray:
        place = np.arange(begin[max(low, 0)], begin[high])
        return place if order is None else order[place]

    def block(ends: tuple[int, int]) -> None:
        above = rows(max(ends[0], 1), ends[1])
        free[above] = _distances(lines, above, rows(ends[0] - 1, ends[1] - 1), level)

    in_threads(block, zip(cut.tolist(), [*cut[1:].tolist(), len(begin) - 1], strict=True))
    return free


class _Lines:
    """All strands, seen from above; an end of a strand is its own neighbor `before` or `after`."""

    def __init__(self, points: FloatArray, start: IntArray, width: FloatArray) -> None:
        self.x, self.y = np.ascontiguousarray(points[:, 0]), np.ascontiguousarray(points[:, 1])
        self.width = width
        step, number = np.ones(len(points)), np.arange(len(points))
        step[1:] = np.sqrt(np.diff(self.x) ** 2 + np.diff(self.y) ** 2)
        step[start[:-1]] = 1.0
        self.arc = np.cumsum(step)  # with a gap between two strands
        self.before, self.after = number - 1, number + 1
        self.before[start[:-1]], self.after[start[1:] - 1] = start[:-1], start[1:] - 1

    def thinned(self, rows: IntArray, spacing: float) -> IntArray:
        """Of some points the ends of strands, and those between them that are at least about this far apart."""
        cell = (self.arc[rows] / spacing).astype(np.int64)
        kept = self.after[rows] - self.before[rows] < 2
        kept[1:] |= cell[1:] != cell[:-1]
        return np.asarray(rows[kept])

    def distance(self, query: IntArray, at: IntArray) -> FloatArray:
        """(Q,) mm from each point of `query` to the strand on both sides of the point `at`."""
        x, y = self.x.take(at), self.y.take(at)
        out_x, out_y = self.x.take(query) - x, self.y.take(query) - y
        squares = []
        for other in (self.before.take(at), self.after.take(at)):
            way_x, way_y = self.x.take(other) - x, self.y.take(other) - y
            share = way_x * out_x
            share += way_y * out_y
            share /= np.maximum(way_x * way_x + way_y * way_y, 1e-12)
            np.minimum(np.maximum(share, 0.0, out=share), 1.0, out=share)
            way_x *= share
            way_y *= share
            squares.append((out_x - way_x) ** 2 + (out_y - way_y) ** 2)
        return np.asarray(np.sqrt(np.minimum(*squares)))


def _distances(lines: _Lines, above: IntArray, below: IntArray, level: IntArray) -> FloatArray:
    """(Q,) mm that the points `above` lie outside the strands of the points `below` that are one layer lower."""
    free = np.full(len(above), FARTHEST)
    open_ = np.arange(len(above) if len(below) else 0)
    for size, spacing, all_rings in _SEARCHES:
        if not len(open_):
            break
        carriers = lines.thinned(below, spacing)
        cells = _Cells(lines.x[carriers], lines.y[carriers], level[carriers], size)
        for rings in all_rings:
            rows = above[open_]
            found = cells.nearest(lines.x[rows], lines.y[rows], level[rows] - 1, rings)
            near = np.flatnonzero(found >= 0)
            at = carriers[found[near]]
            distance = lines.distance(rows[near], at)
            outside = distance - lines.width[at] / 2
            hit = (distance <= rings * size) | (outside <= 0)
            free[open_[near[hit]]] = np.clip(outside[hit], 0.0, FARTHEST)
            left = np.ones(len(open_), dtype=bool)
            left[near[hit]] = False
            open_ = open_[left]
    return free


class _Cells:
    """Points of some layers sorted into square cells, in single precision: enough to tell which one is near."""

    def __init__(self, x: FloatArray, y: FloatArray, level: IntArray, size: float) -> None:
        self._size = size
        self._level = int(level.min())
        self._low = float(x.min()) - _BORDER * size, float(y.min()) - _BORDER * size
        self._columns, self._rows = (
            int((values.max() - low) / size) + _BORDER + 1 for values, low in zip((x, y), self._low, strict=True)
        )
        key = self._key(x, y, level)
        self._order = np.argsort(key, kind="stable")
        counts = np.bincount(key, minlength=self._columns * self._rows * (int(level.max()) - self._level + 1))
        self._begin = np.zeros(len(counts) + 1, dtype=np.int32)  # there are many more cells than points
        np.cumsum(counts, out=self._begin[1:])
        self._x, self._y = (values.take(self._order).astype(np.float32) for values in (x, y))

    def _key(self, x: FloatArray, y: FloatArray, level: IntArray) -> IntArray:
        column, row = (
            np.clip(((values - low) / self._size).astype(np.int64), _BORDER - 1, last - _BORDER)
            for values, low, last in zip((x, y), self._low, (self._columns, self._rows), strict=True)
        )
        return np.asarray(((level - self._level) * self._rows + row) * self._columns + column)

    def nearest(self, x: FloatArray, y: FloatArray, level: IntArray, rings: int) -> IntArray:
        """(Q,) the nearest point of a layer in the cell of each query and in `rings` around it, -1 if there is none."""
        nearest = np.full(len(x), -1)
        key = self._key(x, y, level)
        first, count = (np.empty((len(x), 2 * rings + 1), dtype=np.int64) for _ in range(2))
        several = np.zeros(len(x), dtype=np.int64)
        for number in range(2 * rings + 1):
            row = key + (self._columns * (number - rings) - rings)
            begin = self._begin.take(row)
            row += 2 * rings + 1
            held = self._begin.take(row) - begin
            first[:, number], count[:, number] = begin, held
            several += held
        some = np.flatnonzero(several)
        if not len(some):
            return nearest
        found = ranges(first.ravel(), count.ravel())
        square = np.zeros(len(found), dtype=np.float32)
        for own, values in ((self._x, x), (self._y, y)):
            away = own.take(found)
            away -= np.repeat(values.astype(np.float32), several)
            away *= away
            square += away
        # A positive float's bits sort as the float does: square and place in one number, so that one pass finds both.
        packed = square.view(np.int32).astype(np.int64)
        packed <<= 32
        packed |= found
        group = (np.cumsum(several) - several)[some]
        nearest[some] = self._order[np.minimum.reduceat(packed, group) & _LOW_BITS]
        return nearest
