"""The last step of the optimised sampling: samples around visible seams are moved so that less of the seams is visible.

Everything before treats the phase as smooth; what is measured is the error d = (t₁ − t₂)² of waves that are straight in
phase from sample to sample (paper, section 6.4), and whether it is seen. Here the samples near seams descend on

    Σ d² / (d² + d₀²) + α d

over contour points and their images on the layer above: the first term counts what is seen, the second keeps what is
not from growing. A step is a Gauss-Newton step with the diagonal alone, cut to a few hundredths of a millimetre, and
after it spacings are pushed back into their bounds. The best of all steps is kept.
"""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..settings import PrintSettings
from ..slicing.outlines import following, preceding
from .contours import Contours
from .phase_grid import PhaseGrid, loop_of
from .sampling import Projector, Samples
from .spacing import bounded, pushed

STEPS = 24
PUSHES = 4
# Error from which a place counts as part of a seam, and how many samples around it may move.
SEAM, AROUND = 0.15, 4
HALF_SEEN = 0.5
UNSEEN_COST = 0.1
# Share of the Gauss-Newton step that is gone, its greatest length in wavelengths, and what damps it, 1/mm².
RATE, LONGEST, DAMPING = 0.3, 0.04, 2.0
VISIBLE = 0.5


class _Waves:
    """Samples that move, on contours set apart so that none leaves its own."""

    def __init__(self, lines: Contours, samples: Samples) -> None:
        self.loop, self.start = samples.loop, samples.start
        self.length = lines.length
        self.apart = 4 * float(lines.length.max())
        self.place = samples.arc - lines.arc_start[samples.loop]
        self.ahead, self.behind = following(self.start), preceding(self.start)
        self.around = np.where(self.ahead <= np.arange(len(self.loop)), self.length[self.loop], 0.0)

    def locate(self, place: FloatArray, loop: IntArray) -> tuple[IntArray, FloatArray, FloatArray]:
        """The sample before places on contours, the share of the way to the next one, and the spacing there."""
        gap = self.place[self.ahead] - self.place + self.around
        key = self.place + self.apart * self.loop
        before = np.searchsorted(key, place + self.apart * loop, side="right") - 1
        wrapped = before < self.start[loop]
        before = np.where(wrapped, self.start[loop + 1] - 1, before)
        along = place - self.place[before] + np.where(wrapped, self.length[loop], 0.0)
        # A sample that has moved over its contour's beginning.
        early, late = along < 0, along >= gap[before]
        before, along = (
            np.where(early, self.behind[before], np.where(late, self.ahead[before], before)),
            along - np.where(late, gap[before], 0.0),
        )
        along = along + np.where(early, gap[before], 0.0)
        return before, np.clip(along / gap[before], 0.0, 1.0), gap[before]


def polished(
    lines: Contours,
    grid: PhaseGrid,
    projector: Projector,
    samples: Samples,
    weight: FloatArray,
    settings: PrintSettings,
) -> Samples:
    """Samples with less visible seams, their spacings in [λ, 2λ).

    Args:
        lines: contours of all layers.
        grid: the fine grid on them.
        projector: made for the same contours.
        samples: at least one on each contour that the grid knows.
        weight: (N,) how much a seam at each contour point matters.
        settings: the wavelength is used.
    """
    waves = _Waves(lines, samples)
    near, point = _near_seams(lines, grid, waves)
    if not len(point):
        return samples
    lower, upper, importance = _pairs(lines, projector, waves, point, weight)
    # Only where everything that a sample shapes is among the pairs.
    free = near & near[waves.behind]
    best, best_place = np.inf, waves.place
    for step in range(STEPS + 1):
        move, seen = _descent(waves, lower, upper, importance)
        if seen < best:
            best, best_place = seen, waves.place
        if step < STEPS:
            longest = LONGEST * settings.wavelength
            place = waves.place + np.where(free, np.clip(move, -longest, longest), 0.0)
            waves.place = pushed(place, waves.loop, waves.start, waves.length, settings.wavelength, PUSHES)
    return Samples.on(lines, bounded(lines, lines.arc_start[waves.loop] + best_place, waves.loop, settings))


Places = tuple[FloatArray, IntArray]


def _near_seams(lines: Contours, grid: PhaseGrid, waves: _Waves) -> tuple[BoolArray, IntArray]:
    """Which samples are near a seam, and the contour points whose waves or images' waves they shape."""
    node = np.flatnonzero(grid.linked)
    up = loop_of(lines, grid.above[node])
    this, share, _ = waves.locate(grid.arc[node] - lines.arc_start[grid.loop[node]], grid.loop[node])
    that, high_share, _ = waves.locate(grid.above[node] - lines.arc_start[up], up)
    error = (np.cos(2 * np.pi * share) - np.cos(2 * np.pi * high_share)) ** 2
    near = np.zeros(len(waves.place), dtype=bool)
    near[this[error > SEAM]] = True
    near[that[error > SEAM]] = True
    for _ in range(AROUND):
        near |= near[waves.ahead] | near[waves.behind]
    wanted = np.zeros(len(grid.arc), dtype=bool)
    wanted[node] = near[this] | near[that]
    wanted |= wanted[grid.behind] | wanted[grid.ahead]
    before = np.searchsorted(grid.arc, lines.arc, side="right") - 1
    loop = lines.loop
    known = (before >= 0) & (np.diff(waves.start)[loop] > 0)
    return near, np.flatnonzero(known & wanted[np.maximum(before, 0)])


def _pairs(
    lines: Contours, projector: Projector, waves: _Waves, point: IntArray, weight: FloatArray
) -> tuple[Places, Places, FloatArray]:
    """Contour points and their images: places and contours of both, and how much each counts."""
    layer = lines.layer[lines.loop[point]]
    point = point[layer < lines.layer.max(initial=0)]
    arc, distance = projector.project(lines.points[point], lines.layer[lines.loop[point]] + 1)
    up = loop_of(lines, arc)
    found = np.isfinite(distance) & (np.diff(waves.start)[up] > 0)
    point, arc, up = point[found], arc[found], up[found]
    own = lines.loop[point]
    return (lines.arc[point] - lines.arc_start[own], own), (arc - lines.arc_start[up], up), weight[point]


def _descent(waves: _Waves, lower: Places, upper: Places, importance: FloatArray) -> tuple[FloatArray, float]:
    """How far each sample should move, mm, and how much is seen now."""
    size = len(waves.place)
    this, share, gap = waves.locate(*lower)
    that, high_share, high_gap = waves.locate(*upper)
    difference = np.cos(2 * np.pi * share) - np.cos(2 * np.pi * high_share)
    error = difference**2
    seen = float(importance[error >= VISIBLE].sum())
    slope = importance * (2 * error * HALF_SEEN**2 / (error**2 + HALF_SEEN**2) ** 2 + UNSEEN_COST)
    pull, stiffness = np.zeros(size), np.zeros(size)
    rise, high_rise = -2 * np.pi * np.sin(2 * np.pi * share), 2 * np.pi * np.sin(2 * np.pi * high_share)
    for sample, by_place in (
        (this, -rise * (1 - share) / gap),
        (waves.ahead[this], -rise * share / gap),
        (that, -high_rise * (1 - high_share) / high_gap),
        (waves.ahead[that], -high_rise * high_share / high_gap),
    ):
        pull += np.bincount(sample, 2 * slope * difference * by_place, size)
        stiffness += np.bincount(sample, 2 * slope * by_place**2, size)
    return -RATE * pull / (stiffness + DAMPING), seen
