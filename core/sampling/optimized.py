"""Samples for the fewest visible seams: a plan for the whole height instead of one layer after the other.

The paper (section 3.2, Algorithm 1) carries samples up from layer to layer and adds or drops some wherever their
spacing leaves [λ, 2λ); four fifths of the visible seams are where it does. It names better parametrization as open.
Here four steps take its place, with the same projection, the same bounds and the same measure of seams:

1. a grid of places on the contours, linked from layer to layer by projection (`phase_grid.py`, `projected_grid.py`);
2. how many waves each stretch needs for the fewest births and deaths: a convex problem (`wave_plan.py`), searched on
   grids of fewer layers first (`coarse_to_fine.py`);
3. whole waves from those fractions (`whole_waves.py`);
4. the phase that slides least between layers, first on the coarse grid, then on the fine one (`phase_fit.py`).

Samples are where the phase is whole, with their spacings brought exactly within the bounds. Last, those near the seams
that are left move a little until less of these is seen (`seam_polish.py`).

All this is done on every few layers first, from which the layers between follow (`fewer_layers.py`); as a rule that is
enough.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..contours.contours import Contours, long_enough
from ..model import FloatArray
from ..settings import PrintSettings
from .coarse_to_fine import Level, Search, planned, planned_further
from .fewer_layers import fewer_layers
from .phase import Phase
from .phase_fit import FitEffort, PhaseFit
from .projected_grid import phase_grid
from .projector import Projector
from .samples import Samples
from .seam_polish import Polish, Stage, polished
from .spacing import bounded
from .wave_plan import WavePlan
from .whole_waves import rounded

# First all is done on every so many layers, with a node for so many contour points, of which one in so many is searched
# on the whole layer above; neighbors are torn if their images are so many wavelengths farther apart than they.
LAYERS, STRIDE, QUICK_SEARCHED, TEAR = 4, 12, 192, 2.0
QUICK_SEARCH = Search((Level(layers=8, stride=2, steps=100),), steps=36)
QUICK_FIT = FitEffort(rounds=2, plain=0, steps=4)
QUICK_STRAY = 0.03
# On a model with few waves near seams the polish takes more steps, at closer places: that takes no longer than on a
# large one.
FEW_NEAR, FEW_NEAR_FINE = 10_000, 5_000
SMALL_POLISH = Polish((Stage(24, 2, 0.25, 0.45, 0.25),), seam=0.05, around=3, apart=2.0)
QUICK_POLISH = Polish(
    (Stage(10, 2, 0.25, 0.45, 0.25),), seam=0.08, around=2, apart=3.0, few=FEW_NEAR, more=SMALL_POLISH
)
# If more than this share of the pattern is then a visible seam, all is done anew on all layers. The second holds where
# it is told how much a seam matters.
QUICK_ENOUGH, QUICK_ENOUGH_WEIGHED = 0.0043, 0.0022
# Then the plan is made on every so many nodes of the fine grid, and the phase fitted on both.
COARSE_STRIDE = 4
STRAY = 0.017
SEARCH = Search((Level(16, 8, 100), Level(4, 6, 100), Level(2, 4, 150)), steps=25)
COARSE_FIT, FINE_FIT = FitEffort(rounds=8, plain=1, steps=10), FitEffort(rounds=2, plain=0, steps=8)
SMALL_FINE_POLISH = Polish((Stage(20, 2, 0.25, 0.45, 0.25),), seam=0.08, around=2, apart=2.0)
POLISH = Polish(
    (Stage(10, 2, 0.2, 0.35, 0.35),), seam=0.15, around=2, apart=2.0, few=FEW_NEAR_FINE, more=SMALL_FINE_POLISH
)
# If more than this share is still a visible seam, a few more plans are tried, with longer fits.
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
# What nobody sees still counts by this much.
LEAST_WEIGHT = 0.02


def optimized_samples(
    lines: Contours, projector: Projector, settings: PrintSettings, visibility: FloatArray | None = None
) -> Samples:
    """Place samples on all layers at once for the fewest visible seams.

    Args:
        lines: contours of all layers.
        projector: made for the same contours.
        settings: the wavelength is used; spacings are in [λ, 2λ).
        visibility: (N,) 0 to 1 at every contour point: how much a seam there matters. None is 1 everywhere.
    """
    if not long_enough(lines.length, settings).any():
        return Samples.on(lines, np.zeros(0))
    weight = np.ones(len(lines.arc)) if visibility is None else np.clip(visibility, LEAST_WEIGHT, 1.0)
    return _Planning(lines, projector, weight, settings).samples()


class _Planning:
    """From contours to samples."""

    def __init__(self, lines: Contours, projector: Projector, weight: FloatArray, settings: PrintSettings) -> None:
        self.lines, self.projector, self.weight, self.settings = lines, projector, weight, settings

    def samples(self) -> Samples:
        """Those of a quick plan on fewer layers; where these have too many seams, of plans on all layers."""
        best, seen = self._quick()
        enough = QUICK_ENOUGH if self.weight.min() == 1 else QUICK_ENOUGH_WEIGHED
        return self._thorough() if seen > enough else best

    def _quick(self) -> tuple[Samples, float]:
        """Samples by a plan on fewer layers, and the share of the pattern that is a visible seam."""
        lines, settings = self.lines, self.settings
        grid = phase_grid(lines, self.projector, settings, STRIDE, QUICK_SEARCHED)
        layers = fewer_layers(lines, grid, LAYERS, TEAR * settings.wavelength)
        few, here = layers.few, self.weight[layers.few.point]
        price = np.minimum(here, here[few.ahead])
        plan = planned(lines, few, few, LAYERS, QUICK_SEARCH, price, settings)
        phase = PhaseFit(few, rounded(lines, few, plan, QUICK_STRAY, settings), here, settings).solved(QUICK_FIT)
        samples = Samples.on(lines, bounded(lines, *layers.everywhere(lines, phase).whole(grid), settings))
        return polished(self.projector, grid, samples, self.weight, QUICK_POLISH, settings)

    def _thorough(self) -> Samples:
        """The best of plans on all layers."""
        self.fine = phase_grid(self.lines, self.projector, self.settings)
        self.coarse = self.fine.coarser(self.lines, COARSE_STRIDE)
        self.here = self.weight[self.coarse.point]
        price = np.minimum(self.here, self.here[self.coarse.ahead])
        plan = planned(self.lines, self.fine, self.coarse, 1, SEARCH, price, self.settings)
        enough = ENOUGH if self.weight.min() == 1 else ENOUGH_WEIGHED
        best, seen = self._realized(plan, COARSE_FIT, FINE_FIT)
        for _ in range(MORE_TRIES):
            if seen <= enough:
                break
            plan = planned_further(self.coarse, plan, price, self.settings)
            found, left = self._realized(plan, LONGER_COARSE_FIT, LONGER_FINE_FIT)
            if left < seen:
                best, seen = found, left
        if seen > FEW * enough:
            best, _ = polished(self.projector, self.fine, best, self.weight, LONGER_POLISH, self.settings)
        return best

    def _realized(self, plan: WavePlan, coarse_fit: FitEffort, fine_fit: FitEffort) -> tuple[Samples, float]:
        """Samples by a plan, and the share of the pattern that is a visible seam."""
        lines, coarse, fine, settings = self.lines, self.coarse, self.fine, self.settings
        phase = rounded(lines, coarse, plan, STRAY, settings)
        phase = PhaseFit(coarse, phase, self.here, settings).solved(coarse_fit)
        phase = Phase(phase.at(*coarse.at(fine.arc), coarse), phase.turns)
        phase = PhaseFit(fine, phase, self.weight[fine.point], settings).solved(fine_fit)
        samples = Samples.on(lines, bounded(lines, *phase.whole(fine), settings))
        return polished(self.projector, fine, samples, self.weight, POLISH, settings)
