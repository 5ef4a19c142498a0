"""The wave plan of a grid, searched on grids of fewer layers first.

Most of the way is gone on grids of every sixteenth and every fourth layer, whose plan, prices of births and deaths
included, is where the search on the next finer one starts.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..model import FloatArray
from .phase_grid import PhaseGrid
from .wave_plan import PrimalDual, WavePlan, uneven

# Steps of each further search, where the plan left too many seams.
MORE_STEPS = 400
# Times as many steps are taken where weights differ, as births and deaths move farther there.
WEIGHTED_STEPS = 3


class Level(NamedTuple):
    """Steps on a coarser grid.

    Attributes:
        layers: the grid has one in this many of all layers,
        stride: and one in this many of their nodes.
        steps: of the search.
    """

    layers: int
    stride: int
    steps: int


class Search(NamedTuple):
    """How long to search.

    Attributes:
        levels: on coarser grids, the coarsest first.
        steps: on the grid that is planned on.
    """

    levels: tuple[Level, ...]
    steps: int


def planned(
    fine: PhaseGrid, grid: PhaseGrid, layers: int, search: Search, weight: FloatArray, wavelength: float
) -> WavePlan:
    """The plan with the fewest births and deaths.

    Args:
        fine: the grid that those of fewer layers are made from, of the same layers as `grid`.
        grid: the grid of K nodes to plan on.
        layers: it has one in this many of all layers.
        search: how long to search.
        weight: (K,) what a birth or a death above the edge from each node costs, 1 as a rule.
        wavelength: λ, mm.
    """
    stages = [(grid, layers, search.steps)]
    for level in reversed(search.levels):
        fine = fine.spanning(level.layers, level.layers * wavelength / 2)
        stages.insert(0, (fine.every(level.stride), level.layers, level.steps))
    more = WEIGHTED_STEPS if uneven(weight) else 1
    coarser: tuple[PhaseGrid, int, WavePlan] | None = None
    for here, span, steps in stages:
        problem = PrimalDual(here, weight[grid.at(here.arc)[0]], wavelength)
        guess = _taken_over(here, span, *coarser) if coarser else problem.even_plan()
        plan = problem.solved(guess, more * steps)
        coarser = here, span, plan
    return plan


def planned_further(grid: PhaseGrid, plan: WavePlan, weight: FloatArray, wavelength: float) -> WavePlan:
    """A plan with fewer births and deaths, for several times the work; arguments as of `planned`, and its plan."""
    return PrimalDual(grid, weight, wavelength).solved(plan, MORE_STEPS)


def _taken_over(grid: PhaseGrid, layers: int, coarse: PhaseGrid, coarse_layers: int, plan: WavePlan) -> WavePlan:
    """The plan on a grid of every `coarse_layers` layers as a first guess for that on a grid of every `layers`."""
    if not len(coarse.arc):
        usual = np.zeros(len(grid.arc))
        return WavePlan(usual, usual, usual, plan.level)
    place, loop = grid.raised(grid.arc, grid.loop, coarse_layers)
    known = ~np.isnan(place)
    node = np.maximum(coarse.lookup.before(np.where(known, place, 0.0)), 0)
    known &= coarse.loop[node] == loop
    cell, start, edge, weight = coarse.rows()
    owner = np.repeat(cell, np.diff(start))
    covered = np.bincount(edge, np.abs(weight), len(coarse.arc))
    below = np.bincount(edge, np.abs(weight) * plan.price[owner], len(coarse.arc)) / np.maximum(covered, 1e-9)
    price = np.where(loop == grid.loop, plan.price[node], below[node])
    density = plan.waves[node] / coarse.length[node]
    usual = plan.waves.sum() / coarse.length.sum()
    return WavePlan(
        waves=grid.length * np.where(known, density, usual),
        slide=np.where(known, plan.slide[node] * layers / coarse_layers, 0.0),
        price=np.where(known, price, 0.0),
        level=plan.level,
    )
