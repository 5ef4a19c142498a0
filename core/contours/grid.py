"""Neighbor search among the points of all layers: a uniform grid in sorted arrays."""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, FloatArray, IntArray, bounds
from ..ragged import ranges, starts

# Most cells for each point for which a table of all cells is kept.
CELLS_A_POINT = 64


class PointGrid:
    """Points of all layers sorted into square cells; neighbors are looked for within one layer only."""

    def __init__(
        self, points: FloatArray, layer: IntArray, cell: float, table: bool = True, name: IntArray | None = None
    ) -> None:
        """Sort points (N, 2) with their layers (N,) into cells of `cell` mm.

        A `table` of all cells pays off with many queries. Queries return numbers of points, or their `name` (N,).
        """
        self.cell = cell
        low, high = bounds(points) if len(points) else np.zeros((2, 2))
        self.low = low - 3 * cell
        self.size = np.ceil((high - self.low) / cell).astype(np.int64) + 4
        self.bottom, top = (int(layer.min()), int(layer.max())) if len(layer) else (0, 0)
        self.key = self._key(points, layer)
        cells = (top + 1 - self.bottom) * int(self.size.prod())
        self.order = np.argsort(self.key.astype(np.min_scalar_type(cells)), kind="stable")
        self.keys = self.key[self.order]
        self.order = self.order if name is None else name[self.order]
        # Where each cell's points begin, unless nearly all cells are empty.
        table = table and cells < CELLS_A_POINT * len(points)
        self.begin = starts(np.bincount(self.key, minlength=cells)) if table else None

    def _key(self, points: FloatArray, layer: IntArray) -> IntArray:
        """(N,) the cell of each point, counted through all rows of all layers."""
        # Column by column: numpy is several times slower along rows of two.
        x, y = (
            np.clip(((points[:, axis] - self.low[axis]) / self.cell).astype(np.int64), 2, self.size[axis] - 3)
            for axis in (0, 1)
        )
        return np.asarray(((layer - self.bottom) * self.size[1] + y) * self.size[0] + x)

    def candidates(self, query: FloatArray, layer: IntArray, rings: int = 1) -> tuple[IntArray, IntArray]:
        """All points in the cells around each query point: those nearer than `rings` cells, and some more.

        Args:
            query: (Q, 2) mm.
            layer: (Q,) the layer to look in.
            rings: how many cells to go in all directions, 1 or 2.

        Returns:
            (C,) indices of points, grouped by query, and (Q + 1,) where each query's group starts.
        """
        key = self._key(query, layer)
        # The cells of a row are one run of the sorted keys.
        row = key[:, None] + np.arange(-rings, rings + 1) * self.size[0]
        if self.begin is None:
            first = np.searchsorted(self.keys, row - rings, side="left")
            count = np.searchsorted(self.keys, row + rings, side="right") - first
        else:
            first = self.begin.take(row - rings, mode="clip")
            count = self.begin.take(row + rings + 1, mode="clip") - first
        found = self.order.take(ranges(first.ravel(), count.ravel()))
        return found, starts(count.sum(axis=1))


def nearest(distance: FloatArray, group: IntArray) -> tuple[IntArray, BoolArray]:
    """Position of the least value in each group.

    Args:
        distance: (C,) values.
        group: (Q + 1,) where each group starts.

    Returns:
        (Q,) index into `distance` (0 where the group is empty), (Q,) whether the group has any member.
    """
    count = np.diff(group)
    filled = count > 0
    where = np.zeros(len(count), dtype=np.int64)
    if not filled.any():
        return where, filled
    begin = group[:-1][filled]
    least = np.minimum.reduceat(distance, begin)
    hit = np.flatnonzero(distance == np.repeat(least, count[filled]))
    owner = np.searchsorted(begin, hit, side="right") - 1
    first = np.concatenate([[True], owner[1:] != owner[:-1]])
    where[filled] = hit[first]
    return where, filled
