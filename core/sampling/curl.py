"""Births and deaths of waves as a linear map of the waves and slides on a phase grid, ready to be applied often."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..model import FloatArray, IntArray
from .phase_grid import PhaseGrid

Singles = NDArray[np.float32]


class _Sums:
    """A sparse matrix (K, K) in single precision: each result sums up a few weighted values, mostly one or two.

    These first two lie in dense rows, so that applying the matrix is a few calls of numpy; only the rest is scattered.
    """

    def __init__(self, result: IntArray, value: IntArray, weight: FloatArray, size: int) -> None:
        """Take E entries: rows `result`, columns `value`, `weight`; `size` is K."""
        # Two of each result, with weights of zero where there are fewer, and all others.
        self.value, self.weight = np.zeros((2, size), dtype=np.int64), np.zeros((2, size), dtype=np.float32)
        left, chosen = np.arange(len(result)), np.empty(size, dtype=np.int64)
        for row in range(2):
            theirs = result.take(left)
            chosen[theirs] = left
            is_one = chosen.take(theirs) == left
            one, left = left.take(np.flatnonzero(is_one)), left.take(np.flatnonzero(~is_one))
            theirs = result.take(one)
            self.value[row, theirs], self.weight[row, theirs] = value.take(one), weight.take(one)
        self.results, self.others, self.weights = result[left], value[left], weight[left].astype(np.float32)
        self.work = np.empty_like(self.weight)

    def __call__(self, values: Singles, out: Singles) -> None:
        """`out` (K,) of values (K,)."""
        # No index is out of range; with mode="clip" numpy saves itself the check.
        values.take(self.value, out=self.work, mode="clip")
        self.work *= self.weight
        np.add(self.work[0], self.work[1], out=out)
        if len(self.others):
            np.add.at(out, self.results, values.take(self.others) * self.weights)


class Curl:
    """The linear map from waves and slides to births less deaths above each edge, and its transpose.

    What it says of torn edges means nothing: no price is put on them.
    """

    def __init__(self, grid: PhaseGrid) -> None:
        self.size, self.grid = len(grid.arc), grid
        cell, start, self.edge, self.weight = grid.rows()
        self.owner = np.repeat(cell, np.diff(start))
        self.above = _Sums(self.owner, self.edge, self.weight, self.size)
        self.below = _Sums(self.edge, self.owner, self.weight, self.size)
        self.whole = np.zeros(self.size)
        self.whole[cell] = 1.0
        self.work = np.empty(self.size, dtype=np.float32)

    def __call__(self, waves: Singles, slide: Singles, out: Singles) -> None:
        """`out` (K,) for waves (K,) and slides (K,)."""
        self.above(waves, out)
        out -= waves
        out += slide
        out -= slide.take(self.grid.ahead, out=self.work, mode="clip")

    def transposed(self, dual: Singles, out: Singles) -> None:
        """`out` (2, K) for births less deaths (K,) that are none on torn edges."""
        self.below(dual, out[0])
        out[0] -= dual
        np.subtract(dual, dual.take(self.grid.behind, out=self.work, mode="clip"), out=out[1])

    def row_sums(self) -> FloatArray:
        """Sums of the magnitudes of each row."""
        return np.asarray(np.bincount(self.owner, np.abs(self.weight), self.size) + 3)

    def column_sums(self) -> tuple[FloatArray, FloatArray]:
        """Sums of the magnitudes of the columns of the waves and of the slides."""
        waves = np.bincount(self.edge, np.abs(self.weight), self.size) + self.whole
        return waves, self.whole + self.whole.take(self.grid.behind)
