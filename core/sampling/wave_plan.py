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
preconditioning (Pock, Chambolle 2011) and over-relaxation; a step is linear in the number of nodes. Most of the way is
gone on grids of every sixteenth and every fourth layer, whose plan, prices of births and deaths included, is where that
of all starts.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..contours.contours import Contours
from ..model import FloatArray, IntArray
from ..parallel import product
from ..records import dataclass
from ..settings import PrintSettings
from .phase_grid import PhaseGrid

Singles = NDArray[np.float32]

# Steps of each further search, where the plan left too many seams.
MORE_STEPS = 400
# It takes so many times as many where births and deaths cost more in some places than in others, as they move farther.
WEIGHTED_STEPS = 3
OVER_RELAXATION = 1.8
# Steps of the waves and slides are shorter than the diagonal asks for by this, those of the prices as much longer:
# there are many waves to move and few prices. The second holds where prices differ.
PRIMAL_SHARE, WEIGHTED_SHARE = 0.1, 1.0
# How far the waves may slide from a layer to the next, in waves, and what sliding and uneven spacing cost.
SLIDE = 0.045
SLIDE_COST = 0.012
UNEVEN_COST = 0.002
# Steps that change no number of waves and no price by more than this end the search.
SETTLED = 1e-5
# The plan keeps this share away from the bounds on the spacing.
MARGIN = 0.05


@dataclass(frozen=True)
class Search:
    """How long to search.

    Attributes:
        spans: grids of every so many layers, every so many nodes of them, and the steps on each.
        steps: on the grid that is planned on.
    """

    spans: tuple[tuple[int, int, int], ...]
    steps: int


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


class _Sums:
    """Weighted sums of a few of K values for each of K results, most of them of one or two, in single precision."""

    def __init__(self, result: IntArray, value: IntArray, weight: FloatArray, size: int) -> None:
        """Take E weighted values for E results; `size` is K."""
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
        self.results, self.others, self.weights = result[left], value[left], _single(weight[left])
        self.work = np.empty_like(self.weight)

    def __call__(self, values: Singles, out: Singles) -> None:
        """`out` (K,) of values (K,)."""
        # Clipping, of which there is nothing to do, is quicker than checking.
        values.take(self.value, out=self.work, mode="clip")
        self.work *= self.weight
        np.add(self.work[0], self.work[1], out=out)
        if len(self.others):
            np.add.at(out, self.results, values.take(self.others) * self.weights)


class _Curl:
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


def planned(
    lines: Contours,
    fine: PhaseGrid,
    grid: PhaseGrid,
    layers: int,
    search: Search,
    weight: FloatArray,
    settings: PrintSettings,
) -> WavePlan:
    """The plan with the fewest births and deaths.

    Args:
        lines: the contours.
        fine: a grid of as many layers, on which those of even fewer are made.
        grid: the grid of K nodes to plan on.
        layers: how many it goes by.
        search: how long to search.
        weight: (K,) what a birth or a death above the edge from each node costs, 1 as a rule.
        settings: the wavelength is used.
    """
    grids = [(grid, layers)]
    for span, stride, _ in reversed(search.spans):
        fine = fine.spanning(lines, span, span * settings.wavelength / 2)
        grids.insert(0, (fine.every(lines, stride), span))
    first = grids[0][0]
    none = np.zeros(len(first.arc))
    plan = WavePlan(first.length / (settings.wavelength * np.sqrt(2)), none, none, 0.0)
    counts = [steps for _, _, steps in search.spans] + [search.steps]
    for number, ((coarse, span), steps) in enumerate(zip(grids, counts, strict=True)):
        if number:
            plan = _taken_over(lines, coarse, span, *grids[number - 1], plan)
        node, _ = grid.at(coarse.arc)
        plan = _solved(coarse, weight[node], plan, steps * (WEIGHTED_STEPS if _uneven(weight) else 1), settings)
    return plan


def planned_further(grid: PhaseGrid, plan: WavePlan, weight: FloatArray, settings: PrintSettings) -> WavePlan:
    """A plan with fewer births and deaths, for several times the work; arguments as of `planned`, and its plan."""
    return _solved(grid, weight, plan, MORE_STEPS, settings)


def _taken_over(
    lines: Contours, grid: PhaseGrid, layers: int, span: PhaseGrid, spanned: int, plan: WavePlan
) -> WavePlan:
    """The plan on a grid of every `spanned` layers as a first guess for that on a grid of every `layers`."""
    if not len(span.arc):
        usual = np.zeros(len(grid.arc))
        return WavePlan(usual, usual, usual, plan.level)
    place, loop = grid.raised(lines, grid.arc, grid.loop, spanned)
    known = ~np.isnan(place)
    node = np.maximum(span.lookup.before(np.where(known, place, 0.0)), 0)
    known &= span.loop[node] == loop
    cell, start, edge, weight = span.rows()
    owner = np.repeat(cell, np.diff(start))
    covered = np.bincount(edge, np.abs(weight), len(span.arc))
    below = np.bincount(edge, np.abs(weight) * plan.price[owner], len(span.arc)) / np.maximum(covered, 1e-9)
    price = np.where(loop == grid.loop, plan.price[node], below[node])
    density = plan.waves[node] / span.length[node]
    usual = plan.waves.sum() / span.length.sum()
    return WavePlan(
        waves=grid.length * np.where(known, density, usual),
        slide=np.where(known, plan.slide[node] * layers / spanned, 0.0),
        price=np.where(known, price, 0.0),
        level=plan.level,
    )


def _solved(
    grid: PhaseGrid,
    weight: FloatArray,
    first: WavePlan,
    steps: int,
    settings: PrintSettings,
) -> WavePlan:
    """So many steps of the primal-dual method from a first guess, in single precision."""
    share = WEIGHTED_SHARE if _uneven(weight) else PRIMAL_SHARE
    usual = grid.length / (settings.wavelength * np.sqrt(2))
    curl = _Curl(grid)
    if not len(curl.edge):
        none = np.zeros(len(usual))
        return WavePlan(usual, none, none, first.level)
    # Waves and slides, in two rows; one more row of the map holds the number of all waves, so that the mean spacing
    # stays what it should be.
    mean = grid.stands_for / grid.stands_for.mean()
    by_waves, by_slide = curl.column_sums()
    step = share / np.stack([by_waves + mean, np.maximum(by_slide, 1)])
    keep = 1 / (1 + step * np.stack([UNEVEN_COST / usual, np.full(len(usual), SLIDE_COST)]))
    step *= keep
    dual_step, bound = 1 / curl.row_sums() / share, weight * curl.whole
    fewest, most = grid.bounds(settings.wavelength, MARGIN)
    least, most = np.stack([fewest, -SLIDE * grid.span]), np.stack([most, SLIDE * grid.span])
    level, level_step = first.level, 1 / share / len(usual)
    goal = product(mean, usual)
    mean, step, keep, dual_step, bound, least, most = map(_single, (mean, step, keep, dual_step, bound, least, most))
    old = _single(np.stack([first.waves, first.slide, first.price * curl.whole, usual]))
    old[:2] = np.minimum(np.maximum(old[:2], least), most)
    many, new, work = product(mean, old[0]), np.empty_like(old), np.empty_like(old)
    curl(old[0], old[1], old[3])
    pull, price = work[:2], work[2]
    for number in range(steps):
        curl.transposed(old[2], pull)
        np.multiply(mean, level, out=price)
        price -= UNEVEN_COST
        pull[0] += price
        pull *= step
        np.multiply(keep, old[:2], out=new[:2])
        new[:2] -= pull
        np.minimum(np.maximum(new[:2], least, out=pull), most, out=new[:2])
        curl(new[0], new[1], new[3])
        np.subtract(new[3], old[3], out=price)
        price += new[3]
        price *= dual_step
        price += old[2]
        np.minimum(np.maximum(price, -bound, out=price), bound, out=new[2])
        if number % 20 == 19 and np.abs(new[:3:2] - old[:3:2]).max() < SETTLED:
            break
        now = product(mean, new[0])
        level += OVER_RELAXATION * level_step * (2 * now - many - goal)
        many += OVER_RELAXATION * (now - many)
        np.subtract(new, old, out=work)
        work *= OVER_RELAXATION
        old += work
    waves, slide, price = new[:3].astype(np.float64)
    return WavePlan(waves, slide, price, level)


def _single(values: FloatArray) -> NDArray[Any]:
    """In single precision, which is half as much to read and write."""
    return np.asarray(values, dtype=np.float32)


def _uneven(weight: FloatArray) -> bool:
    return bool(len(weight)) and float(weight.min()) < float(weight.max())
