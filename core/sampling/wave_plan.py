"""How many waves each stretch of each contour should have, planned for the whole height at once.

A wave begins or ends in between two layers wherever the number of waves on a stretch of contour differs from the number
on what lies above it. With g the waves on each edge of the grid and δ the phase by which the pattern slides sideways
from one layer to the next, the births less the deaths above an edge are

    c = (waves above the edge) − g − δ(next node) + δ(node),

the curl of the phase (compare the singularities of stripe patterns: Knöppel, Crane, Pinkall, Schröder, *Stripe Patterns
on Surfaces*, 2015, where they come out of a quadratic energy and the spacing is free). The plan is the solution of

    minimize Σ w |c| + ε Σ (g − t)² / 2t + μ Σ δ² / 2   with   length / 2λ < g < length / λ,   |δ| ≤ τ:

the fewest births and deaths that the bounds on the spacing allow, all layers together; fractions of a wave are allowed
here and rounded in `whole_waves.py`. Torn edges owe nothing. The sum of g is held at what the usual spacing λ√2 asks
for. It is a convex problem, solved by the primal-dual method of Chambolle and Pock (2011) with their diagonal
preconditioning (Pock, Chambolle 2011) and over-relaxation; a step is linear in the number of nodes.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model import FloatArray
from ..parallel import product
from ..records import dataclass
from .curl import Curl, Singles
from .phase_grid import PhaseGrid

OVER_RELAXATION = 1.8
# The steps of the waves and slides are this share of what the diagonal asks for, and those of the prices are longer by
# as much: there are many waves to move and few prices. The second share is used where weights differ.
PRIMAL_SHARE, WEIGHTED_SHARE = 0.1, 1.0
# How far the waves may slide from a layer to the next, in waves (τ), and what sliding (μ) and uneven spacing (ε) cost.
SLIDE = 0.045
SLIDE_COST = 0.012
UNEVEN_COST = 0.002
SETTLED = 1e-5  # the search ends when a step changes no number of waves and no price by more than this,
CHECKED = 20  # which is looked at once in this many steps
# The plan keeps this share away from the bounds on the spacing.
MARGIN = 0.05


@dataclass(frozen=True)
class WavePlan:
    """Waves on each edge of the grid and sliding at each node, both fractions of a wave.

    Attributes:
        waves: (K,) on the edge from each node to the next.
        slide: (K,) by how much the phase at a node's image exceeds the node's.
        price: (K,) what one more wave above the edge would cost, between minus and plus the weight; 0 on torn edges.
        level: what one more wave anywhere would cost.
    """

    waves: FloatArray
    slide: FloatArray
    price: FloatArray
    level: float


class PrimalDual:
    """The problem on one grid, made ready for the steps of the primal-dual method, in single precision.

    The primal variables are waves and slides (2, K), the dual ones the prices (K,) and one level: that of one more row
    of the linear map, which holds the number of all waves, so that the mean spacing stays what it should be.
    """

    def __init__(self, grid: PhaseGrid, weight: FloatArray, wavelength: float) -> None:
        """Set up the problem.

        Args:
            grid: of K nodes.
            weight: (K,) what a birth or a death above the edge from each node costs.
            wavelength: λ, mm.
        """
        self.curl = curl = Curl(grid)
        self.usual = usual = grid.length / (wavelength * np.sqrt(2))
        share = WEIGHTED_SHARE if uneven(weight) else PRIMAL_SHARE
        mean = grid.stands_for / grid.stands_for.mean() if len(usual) else usual
        self.goal = product(mean, usual)
        by_waves, by_slide = curl.column_sums()
        step = share / np.stack([by_waves + mean, np.maximum(by_slide, 1)])
        # Sliding and uneven spacing are pulled back implicitly, by this factor.
        keep = 1 / (1 + step * np.stack([UNEVEN_COST / usual, np.full(len(usual), SLIDE_COST)]))
        fewest, most = grid.bounds(wavelength, MARGIN)
        self.mean, self.keep, self.step = _single(mean), _single(keep), _single(step * keep)
        self.least, self.most = (
            _single(np.stack(rows)) for rows in ([fewest, -SLIDE * grid.span], [most, SLIDE * grid.span])
        )
        self.price_step, self.bound = _single(1 / curl.row_sums() / share), _single(weight * curl.whole)
        self.level_step = 1 / share / max(len(usual), 1)

    def even_plan(self) -> WavePlan:
        """Waves of the usual spacing everywhere, which do not slide."""
        none = np.zeros(len(self.usual))
        return WavePlan(self.usual, none, none, 0.0)

    def solved(self, first: WavePlan, steps: int) -> WavePlan:
        """The plan after at most `steps` steps from a first guess."""
        curl = self.curl
        if not len(curl.edge):
            return replace(self.even_plan(), level=first.level)
        # Rows: waves, slides, prices, and the births less deaths that waves and slides give.
        old = _single(np.stack([first.waves, first.slide, first.price * curl.whole, self.usual]))
        old[:2] = np.minimum(np.maximum(old[:2], self.least), self.most)
        curl(old[0], old[1], old[3])
        new, work = np.empty_like(old), np.empty_like(old)
        many, level = product(self.mean, old[0]), first.level
        for number in range(steps):
            self._primal_step(old, level, new, work)
            self._dual_step(old, new, work[2])
            if number % CHECKED == CHECKED - 1 and np.abs(new[:3:2] - old[:3:2]).max() < SETTLED:
                break
            now = product(self.mean, new[0])
            level += OVER_RELAXATION * self.level_step * (2 * now - many - self.goal)
            many += OVER_RELAXATION * (now - many)
            np.subtract(new, old, out=work)
            work *= OVER_RELAXATION
            old += work
        waves, slide, price = new[:3].astype(np.float64)
        return WavePlan(waves, slide, price, level)

    def _primal_step(self, old: Singles, level: float, new: Singles, work: Singles) -> None:
        """Waves and slides of `new` (4, K) from `old` (4, K) and the level; `work` is written over."""
        pull, price = work[:2], work[2]
        self.curl.transposed(old[2], pull)
        np.multiply(self.mean, level, out=price)
        price -= UNEVEN_COST
        pull[0] += price
        pull *= self.step
        np.multiply(self.keep, old[:2], out=new[:2])
        new[:2] -= pull
        np.minimum(np.maximum(new[:2], self.least, out=pull), self.most, out=new[:2])

    def _dual_step(self, old: Singles, new: Singles, price: Singles) -> None:
        """Prices and births less deaths of `new` (4, K); `price` (K,) is written over."""
        self.curl(new[0], new[1], new[3])
        np.subtract(new[3], old[3], out=price)
        price += new[3]
        price *= self.price_step
        price += old[2]
        np.minimum(np.maximum(price, -self.bound, out=price), self.bound, out=new[2])


def uneven(weight: FloatArray) -> bool:
    """Whether births and deaths cost more in some places than in others."""
    return bool(len(weight)) and float(weight.min()) < float(weight.max())


def _single(values: FloatArray) -> NDArray[Any]:
    """In single precision, which is half as much to read and write."""
    return np.asarray(values, dtype=np.float32)
