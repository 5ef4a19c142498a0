"""The phase that fits best: least sliding from layer to layer and spacing within its bounds, births and deaths fixed.

With the whole numbers of waves known, the phases of all nodes are one least-squares problem,

    minimize Σ w δ² + Σ e (g − t)²,

in which δ is the phase at a node's image less the node's own, less the whole number of waves that came or went between
them, and g the waves on an edge against their target t: weakly towards the usual spacing inside of the bounds, strongly
towards the bound outside. Its weights are chosen anew a few times (iteratively reweighted least squares): sliding that
could be seen weighs more, what a birth or a death makes unavoidable weighs nothing. Each round is solved by conjugate
gradients, preconditioned by the diagonal.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..model import FloatArray
from ..parallel import product
from .phase import Phase
from .phase_grid import PhaseGrid

# Stiffness of the spacing inside of its bounds and outside of them, against that of the link between layers.
SOFT, HARD = 0.02, 20.0
MARGIN = 0.01
# Sliding in a layer, in waves, from which on it is seen, and beyond which only a birth or a death can cause it.
VISIBLE, BROKEN = 0.1, 0.2
# The most that the latter comes to where a node and its image are several layers apart.
MOST_BROKEN = 0.4
CONVERGED = 1e-8


class FitEffort(NamedTuple):
    """How long to fit.

    Attributes:
        rounds: how often the weights are chosen.
        plain: number of first rounds in which all sliding weighs the same.
        steps: of conjugate gradients in each round, at most.
    """

    rounds: int
    plain: int
    steps: int


class PhaseFit:
    """The fit on one grid."""

    def __init__(self, grid: PhaseGrid, phase: Phase, weight: FloatArray, wavelength: float) -> None:
        """Take births and deaths over from a phase that fits roughly.

        Args:
            grid: of K nodes.
            phase: on the grid.
            weight: (K,) how much each node's seam matters, 1 as a rule.
            wavelength: λ, mm.
        """
        self.grid, self.turns = grid, phase.turns
        filled = grid.start[1:] > grid.start[:-1]
        self.first, self.last = grid.start[:-1][filled], grid.start[1:][filled] - 1
        self.share, linked = grid.share, grid.linked
        self.wraps = grid.closes * phase.turns[grid.loop]
        wrapped = self.share * self.wraps[grid.low]
        self.value = phase.value.copy()
        self.offset = np.rint(self._link(self.value, self._rise(self.value)) + wrapped) - wrapped
        reach = (grid.length + grid.length[grid.behind]) / 2
        usual = float(np.median(reach)) if len(reach) else 1.0
        self.weight = weight * np.clip(reach / usual, 0.05, 3.0) * linked
        self.least, self.most = grid.bounds(wavelength, MARGIN)
        self.target = grid.length / (wavelength * np.sqrt(2))
        self.visible = VISIBLE * grid.span
        self.broken = np.minimum(BROKEN * grid.span, MOST_BROKEN)
        self.stiffness = (wavelength / np.maximum(grid.length, 1e-9)) ** 2

    def solved(self, effort: FitEffort) -> Phase:
        """The fitted phase."""
        for number in range(effort.rounds):
            rise = self._rise(self.value)
            waves = rise + self.wraps
            slide = self._link(self.value, rise) - self.offset
            target = np.minimum(np.maximum(waves, self.least), self.most)
            inside = target == waves
            edge = np.where(inside, SOFT, HARD) * self.stiffness
            target = np.where(inside, self.target, target)
            link = self.weight
            if number >= effort.plain:
                square = slide**2
                link = link * (1 + square / self.visible**2) / (1 + square**3 / self.broken**6)
            self.value = self.value + self._step(edge, link, edge * (target - waves), -link * slide, effort.steps)
        return Phase(self.value, self.turns)

    def _rise(self, value: FloatArray) -> FloatArray:
        """From each node to the next."""
        rise = np.empty_like(value)
        np.subtract(value[1:], value[:-1], out=rise[:-1])
        rise[self.last] = value[self.first] - value[self.last]
        return rise

    def _link(self, value: FloatArray, rise: FloatArray) -> FloatArray:
        """From each node to its image."""
        link = rise.take(self.grid.low)
        link *= self.share
        link += value.take(self.grid.low)
        link -= value
        return link

    def _transposed(self, rise: FloatArray, link: FloatArray) -> FloatArray:
        size = len(self.value)
        rise = rise + np.bincount(self.grid.low, link * self.share, size)
        out: FloatArray = np.asarray(np.bincount(self.grid.low, link, size), dtype=float)
        out -= link
        out -= rise
        out[1:] += rise[:-1]
        # What comes over a contour's beginning is that of its own last node, not of the contour before.
        out[self.first[1:]] -= rise[self.first[1:] - 1]
        out[self.first] += rise[self.last]
        return out

    def _step(
        self, edge: FloatArray, link: FloatArray, edge_side: FloatArray, link_side: FloatArray, steps: int
    ) -> FloatArray:
        """Conjugate gradients on the normal equations of one round."""
        size = len(self.value)
        high = link * self.share
        diagonal = edge + edge[self.grid.behind] + link
        diagonal += np.bincount(self.grid.low, link * (1 - self.share) ** 2, size)
        diagonal += np.bincount(self.grid.low, high * self.share, size)[self.grid.behind]
        residual = self._transposed(edge_side, link_side)
        inverse = 1 / diagonal
        change, direction = np.zeros(size), residual * inverse
        squared = product(residual, direction)
        enough = CONVERGED * squared
        for _ in range(steps):
            if squared <= enough:
                break
            rise = self._rise(direction)
            towards = self._transposed(edge * rise, link * self._link(direction, rise))
            length = squared / product(direction, towards)
            change += length * direction
            towards *= length
            residual -= towards
            scaled = residual * inverse
            before, squared = squared, product(residual, scaled)
            direction *= squared / before
            direction += scaled
        return change
