"""The phase of the waves on a grid, and the places where it is whole: the samples."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray, IntArray
from ..ragged import ranges, sums
from ..records import dataclass
from .phase_grid import PhaseGrid

# The phase rises at least by this along each edge of the grid.
LEAST_RISE = 1e-6


@dataclass(frozen=True)
class Phase:
    """The phase of the waves on a grid: samples sit where it is whole.

    Attributes:
        value: (K,) at each node, counting on around its contour from the first node.
        turns: (M,) int64, waves around each contour.
    """

    value: FloatArray
    turns: IntArray

    def waves(self, grid: PhaseGrid) -> FloatArray:
        """(K,) waves on the edge from each node to the next."""
        return np.asarray(self.value[grid.ahead] - self.value + grid.closes * self.turns[grid.loop])

    def at(self, node: IntArray, share: FloatArray, grid: PhaseGrid) -> FloatArray:
        """The phase on the way from nodes to the next ones."""
        ahead = self.value[grid.ahead[node]] + grid.closes[node] * self.turns[grid.loop[node]]
        return np.asarray(self.value[node] * (1 - share) + ahead * share)

    def whole(self, grid: PhaseGrid) -> tuple[FloatArray, IntArray]:
        """(S,) the arcs at which the phase is whole, and (S,) their contours."""
        # The phase has to rise along the contour; where the fit has it fall, it rises a little instead.
        rise = np.maximum(self.waves(grid), LEAST_RISE)
        rise *= (self.turns / np.maximum(sums(rise, grid.start), LEAST_RISE))[grid.loop]
        climbed = np.cumsum(rise) - rise
        first = grid.start[grid.loop]
        value = self.value[first] + climbed - climbed[first]
        begin = np.ceil(value - 1e-9)
        count = (begin[grid.ahead] + grid.closes * self.turns[grid.loop] - begin).astype(np.int64)
        edge = np.repeat(np.arange(len(rise)), count)
        whole = begin[edge] + ranges(0, count)
        share = np.clip((whole - value[edge]) / rise[edge], 0.0, 1.0)
        return grid.arc[edge] + share * grid.length[edge], grid.loop[edge]
