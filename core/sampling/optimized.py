"""Samples for the fewest visible seams: a plan for the whole height instead of one layer after the other.

The paper (section 3.2, Algorithm 1) carries samples up from layer to layer and adds or drops some wherever their
spacing leaves [λ, 2λ); four fifths of the visible seams are where it does. It mentions that one could "perform some
global optimization using all layer slices in parallel", but does not. Here that is done in six steps, with the same
projection, the same bounds and the same measure of seams:

1. a grid of places on the contours, linked from layer to layer by projection (`phase_grid.py`, `projected_grid.py`);
2. how many waves each stretch needs for the fewest births and deaths: a convex problem (`wave_plan.py`, with the linear
   map `curl.py`), searched on grids of fewer layers first (`coarse_to_fine.py`);
3. whole waves from those fractions (`whole_waves.py`);
4. the phase (`phase.py`) that slides least between layers (`phase_fit.py`);
5. samples where the phase is whole, with their spacings brought exactly within the bounds (`spacing.bounded`);
6. samples near the seams that are left move a little until less of these is seen (`seam_polish.py`, `seam_pairs.py`).

All this is done on every fourth layer first, from which the layers between follow (`fewer_layers.py`): the quick plan.
As a rule it is enough; where it leaves too many seams, the thorough plan on all layers takes its place.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..contours.places import long_enough
from ..model import FloatArray
from ..settings import PrintSettings
from .coarse_to_fine import Level, Search, planned, planned_further
from .fewer_layers import fewer_layers
from .phase import Phase
from .phase_fit import FitEffort, PhaseFit
from .phase_grid import PhaseGrid
from .projected_grid import phase_grid
from .projector import Projector
from .samples import Samples
from .seam_polish import Polish, Stage, polished
from .spacing import bounded
from .wave_plan import WavePlan
from .whole_waves import rounded

LEAST_WEIGHT = 0.02  # what nobody sees still counts by this much

# The quick plan.
LAYERS = 4  # one layer in four is planned
STRIDE = 12  # contour points from node to node
QUICK_SEARCHED = 192  # contour points from node to node of those that are searched for on the whole layer above
TEAR = 2.0  # wavelengths; neighbors whose images are farther apart than they, by more than this, are torn
QUICK_SEARCH = Search((Level(layers=8, stride=2, steps=100),), steps=36)
QUICK_STRAY = 0.03  # see `whole_waves.rounded`
QUICK_FIT = FitEffort(rounds=2, plain=0, steps=4)
# Where no more samples than these are near seams, the polish takes more steps, at closer places: that takes no longer
# than on a large model.
FEW_NEAR, FEW_NEAR_FINE = 10_000, 5_000
SMALL_POLISH = Polish((Stage(24, 2, 0.25, 0.45, 0.25),), seam=0.05, around=3, apart=2.0)
QUICK_POLISH = Polish(
    (Stage(10, 2, 0.25, 0.45, 0.25),), seam=0.08, around=2, apart=3.0, few=FEW_NEAR, more=SMALL_POLISH
)
# Shares of the pattern that may be a visible seam after the quick plan; the second one where visibility is given.
QUICK_ENOUGH, QUICK_ENOUGH_WEIGHED = 0.0043, 0.0022

# The thorough plan.
COARSE_STRIDE = 4  # nodes of the fine grid to a node of the coarse one, on which the plan is made
SEARCH = Search((Level(16, 8, 100), Level(4, 6, 100), Level(2, 4, 150)), steps=25)
STRAY = 0.017
COARSE_FIT, FINE_FIT = FitEffort(rounds=8, plain=1, steps=10), FitEffort(rounds=2, plain=0, steps=8)
SMALL_FINE_POLISH = Polish((Stage(20, 2, 0.25, 0.45, 0.25),), seam=0.08, around=2, apart=2.0)
POLISH = Polish(
    (Stage(10, 2, 0.2, 0.35, 0.35),), seam=0.15, around=2, apart=2.0, few=FEW_NEAR_FINE, more=SMALL_FINE_POLISH
)
# If a greater share than this is still a visible seam, more plans are tried, with longer fits.
ENOUGH, ENOUGH_WEIGHED = 0.004, 0.0025
MORE_TRIES = 2
LONGER_COARSE_FIT, LONGER_FINE_FIT = FitEffort(rounds=8, plain=1, steps=20), FitEffort(rounds=4, plain=0, steps=12)
# If more than this part of that share is left, the best of all is polished longer, on the error itself.
FEW = 0.8
SHARPENED = (
    Stage(25, 1, 0.8, 0.2, 0.2),
    Stage(25, 2, 0.7, 0.12, 0.12),
    Stage(25, 3, 0.6, 0.06, 0.06),
    Stage(25, 4, 0.53, 0.03, 0.03),
)
LARGE_LONGER_POLISH = Polish(SHARPENED, seam=0.1, around=4, apart=0.4, exact=True)
SMALL_LONGER_POLISH = replace(LARGE_LONGER_POLISH, stages=tuple(replace(stage, steps=40) for stage in SHARPENED))
LONGER_POLISH = replace(LARGE_LONGER_POLISH, few=FEW_NEAR_FINE, more=SMALL_LONGER_POLISH)


def optimized_samples(projector: Projector, settings: PrintSettings, visibility: FloatArray | None = None) -> Samples:
    """Place samples on all layers at once for the fewest visible seams.

    Args:
        projector: made for the contours of all layers, N points.
        settings: the wavelength is used; spacings are in [λ, 2λ).
        visibility: (N,) 0 to 1 at every contour point: how much a seam there matters. None is 1 everywhere.
    """
    lines, wavelength = projector.lines, settings.wavelength
    if not long_enough(lines.length, wavelength).any():
        return Samples.on(lines, np.zeros(0))
    weight = np.ones(len(lines.arc)) if visibility is None else np.clip(visibility, LEAST_WEIGHT, 1.0)
    samples, seen = _quick(projector, weight, wavelength)
    if seen <= (QUICK_ENOUGH if weight.min() == 1 else QUICK_ENOUGH_WEIGHED):
        return samples
    return _Thorough(projector, weight, wavelength).samples()


def _quick(projector: Projector, weight: FloatArray, wavelength: float) -> tuple[Samples, float]:
    """Samples by a plan on fewer layers, and the share of the pattern that is a visible seam.

    Args:
        projector: made for the contours.
        weight: (N,) how much a seam at each contour point matters.
        wavelength: λ, mm.
    """
    grid = phase_grid(projector, wavelength, STRIDE, QUICK_SEARCHED)
    layers = fewer_layers(grid, LAYERS, TEAR * wavelength)
    few, here = layers.few, weight[layers.few.point]
    plan = planned(few, few, LAYERS, QUICK_SEARCH, _price(few, here), wavelength)
    phase = PhaseFit(few, rounded(few, plan, QUICK_STRAY, wavelength), here, wavelength).solved(QUICK_FIT)
    samples = _samples(grid, layers.everywhere(phase), wavelength)
    return polished(projector, grid, samples, weight, QUICK_POLISH, wavelength)


def _price(grid: PhaseGrid, weight: FloatArray) -> FloatArray:
    """(K,) what a birth or a death above each edge costs, where a seam at each node matters by `weight` (K,)."""
    return np.minimum(weight, weight[grid.ahead])


def _samples(grid: PhaseGrid, phase: Phase, wavelength: float) -> Samples:
    """Where the phase is whole, moved until spacings keep within their bounds."""
    return Samples.on(grid.lines, bounded(grid.lines, *phase.whole(grid), wavelength))


class _Thorough:
    """Plans on all layers: made on a coarse grid, realized as samples on a fine one; arguments as of `_quick`."""

    def __init__(self, projector: Projector, weight: FloatArray, wavelength: float) -> None:
        self.projector, self.weight, self.wavelength = projector, weight, wavelength
        self.fine = phase_grid(projector, wavelength)
        self.coarse = self.fine.coarser(COARSE_STRIDE)

    def samples(self) -> Samples:
        """The samples of the best of some plans."""
        price = _price(self.coarse, self.weight[self.coarse.point])
        enough = ENOUGH if self.weight.min() == 1 else ENOUGH_WEIGHED
        plan = planned(self.fine, self.coarse, 1, SEARCH, price, self.wavelength)
        best, seen = self._realized(plan, COARSE_FIT, FINE_FIT)
        for _ in range(MORE_TRIES):
            if seen <= enough:
                break
            plan = planned_further(self.coarse, plan, price, self.wavelength)
            found, left = self._realized(plan, LONGER_COARSE_FIT, LONGER_FINE_FIT)
            if left < seen:
                best, seen = found, left
        if seen > FEW * enough:
            best, _ = polished(self.projector, self.fine, best, self.weight, LONGER_POLISH, self.wavelength)
        return best

    def _realized(self, plan: WavePlan, coarse_fit: FitEffort, fine_fit: FitEffort) -> tuple[Samples, float]:
        """Samples by a plan, and the share of the pattern that is a visible seam."""
        coarse, fine, wavelength = self.coarse, self.fine, self.wavelength
        phase = rounded(coarse, plan, STRAY, wavelength)
        phase = PhaseFit(coarse, phase, self.weight[coarse.point], wavelength).solved(coarse_fit)
        phase = Phase(phase.at(*coarse.at(fine.arc), coarse), phase.turns)
        phase = PhaseFit(fine, phase, self.weight[fine.point], wavelength).solved(fine_fit)
        samples = _samples(fine, phase, wavelength)
        return polished(self.projector, fine, samples, self.weight, POLISH, wavelength)
