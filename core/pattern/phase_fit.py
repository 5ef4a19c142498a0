"""The phase that fits best: least sliding from layer to layer and spacing within its bounds, births and deaths fixed.

With the whole numbers of waves known, the phases of all nodes are one least-squares problem,

    minimise Σ w δ² + Σ e (g − t)²,

in which δ is the phase at a node's image less the node's own, less the whole number of waves that came or went between
them, and g the waves on an edge against their target t: weakly towards the usual spacing inside of the bounds, strongly
towards the bound outside. Its weights are chosen anew a few times (iteratively reweighted least squares): sliding that
could be seen weighs more, what a birth or a death makes unavoidable weighs nothing. Each round is solved by conjugate
gradients, preconditioned by the diagonal.
"""

from __future__ import annotations

import numpy as np

from ..model import FloatArray, IntArray
from ..settings import PrintSettings
from .phase_grid import PhaseGrid
from .whole_waves import Phase

# Stiffness of the spacing inside of its bounds and outside of them, against that of the link between layers.
SOFT, HARD = 0.02, 20.0
MARGIN = 0.01
# Sliding of a wave's share that begins to be seen, and that only a birth or a death can cause.
VISIBLE, BROKEN = 0.1, 0.2
# Rounds without and with those weights.
PLAIN_ROUNDS = 2
CONVERGED = 1e-8


class PhaseFit:
    """The fit on one grid."""

    def __init__(self, grid: PhaseGrid, phase: Phase, weight: FloatArray, settings: PrintSettings) -> None:
        """Take births and deaths over from a phase that fits roughly.

        Args:
            grid: of K nodes.
            phase: on the grid.
            weight: (K,) how much each node's seam matters, 1 as a rule.
            settings: the wavelength is used.
        """
        self.grid, self.turns = grid, phase.turns
        self.node = np.flatnonzero(grid.linked)
        self.low: IntArray = grid.low[self.node]
        self.high: IntArray = grid.high[self.node]
        self.share = grid.share[self.node]
        self.wraps = grid.seam * phase.turns[grid.loop]
        wrapped = self.share * self.wraps[self.low]
        self.value = phase.value.copy()
        here = self._link(self.value) + wrapped
        self.offset = np.rint(here) - wrapped
        reach = (grid.length + grid.length[grid.behind]) / 2
        usual = float(np.median(reach)) if len(reach) else 1.0
        self.weight = (weight * np.clip(reach / usual, 0.05, 3.0))[self.node]
        self.least = grid.length / (2 * settings.wavelength) * (1 + MARGIN)
        self.most = grid.length / settings.wavelength * (1 - MARGIN)
        self.target = grid.length / (settings.wavelength * np.sqrt(2))
        self.stiffness = (settings.wavelength / np.maximum(grid.length, 1e-9)) ** 2

    def solved(self, rounds: int, steps: int) -> Phase:
        """The fitted phase after so many rounds of at most so many steps of conjugate gradients."""
        for number in range(rounds):
            waves = self._rise(self.value) + self.wraps
            slide = self._link(self.value) - self.offset
            target = np.clip(waves, self.least, self.most)
            inside = target == waves
            edge = np.where(inside, SOFT, HARD) * self.stiffness
            target = np.where(inside, self.target, target)
            link = self.weight
            if number >= PLAIN_ROUNDS:
                link = link * (1 + (slide / VISIBLE) ** 2) / (1 + (slide / BROKEN) ** 6)
            self.value = self.value + self._step(edge, link, edge * (target - waves), -link * slide, steps)
        return Phase(self.value, self.turns)

    def _rise(self, value: FloatArray) -> FloatArray:
        return np.asarray(value[self.grid.ahead] - value)

    def _link(self, value: FloatArray) -> FloatArray:
        return np.asarray(value[self.low] * (1 - self.share) + value[self.high] * self.share - value[self.node])

    def _transposed(self, rise: FloatArray, link: FloatArray) -> FloatArray:
        size = len(self.value)
        out = rise[self.grid.behind] - rise
        out += np.bincount(self.low, link * (1 - self.share), size) + np.bincount(self.high, link * self.share, size)
        out[self.node] -= link
        return np.asarray(out)

    def _step(
        self, edge: FloatArray, link: FloatArray, edge_side: FloatArray, link_side: FloatArray, steps: int
    ) -> FloatArray:
        """Conjugate gradients on the normal equations of one round."""
        size = len(self.value)
        own = np.zeros(size)
        own[self.node] = link
        diagonal = edge + edge[self.grid.behind] + own + np.bincount(self.low, link * (1 - self.share) ** 2, size)
        diagonal = diagonal + np.bincount(self.high, link * self.share**2, size)
        residual = self._transposed(edge_side, link_side)
        change, scaled = np.zeros(size), residual / diagonal
        direction, squared = scaled, float(residual @ scaled)
        enough = CONVERGED * squared
        for _ in range(steps):
            if squared <= enough:
                break
            product = self._transposed(edge * self._rise(direction), link * self._link(direction))
            length = squared / float(direction @ product)
            change += length * direction
            residual = residual - length * product
            scaled = residual / diagonal
            before, squared = squared, float(residual @ scaled)
            direction = scaled + squared / before * direction
        return change
