"""The last step of the optimised sampling: samples around visible seams are moved so that less of the seams is visible.

Everything before treats the phase as smooth; what is measured is the error d = (t₁ − t₂)² of waves that are straight in
phase from sample to sample (paper, section 6.4), and whether it is seen. Here the samples near seams descend on

    Σ dᵖ / (dᵖ + d₀ᵖ) + α d

over places on the contours and their images on the layer above: the first term counts what is seen, the sharper the
larger p is, the second keeps what is not from growing. A step is a Gauss-Newton step with the diagonal alone and some
momentum, cut to a few hundredths of a millimetre; every few steps spacings are pushed back into their bounds, and the
diagonal is worked out anew. The best of what is met then is kept.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import BoolArray, FloatArray, IntArray
from ..ragged import following, preceding, ranges
from ..settings import PrintSettings
from .contours import Contours, loop_of
from .phase_grid import PhaseGrid
from .sampling import Projector, Samples
from .spacing import bounded, pushed

Singles = NDArray[np.float32]

UNSEEN_COST = 0.03
# The greatest length of a step in wavelengths, and what damps it, 1/mm².
LONGEST, DAMPING = 0.04, 2.0
# Share of a step that the next one keeps on.
MOMENTUM = 0.6
VISIBLE = 0.5
FULL = np.float32(2 * np.pi)


@dataclass(frozen=True)
class Stage:
    """Steps that count seams alike.

    Attributes:
        rounds: how many, each of a few steps.
        doublings: p is 2 to this power.
        half: d₀, the error that counts half.
        rate: the share of the Gauss-Newton step that is gone.
    """

    rounds: int
    doublings: int
    half: float
    rate: float


@dataclass(frozen=True)
class Polish:
    """How much to polish.

    Attributes:
        stages: one after the other.
        seam: sliding by which the error is greater than this somewhere in a wave makes a place part of a seam.
        around: how many samples around a seam may move.
        every: mm, how far apart the places are.
        turn: steps between two looks at where all places are among the samples.
    """

    stages: tuple[Stage, ...]
    seam: float
    around: int
    every: float
    turn: int = 1


@dataclass
class _Pairs:
    """P places and then their P images, the sample before each and how much a seam between each two matters."""

    before: IntArray
    place: FloatArray
    importance: Singles


class _Waves:
    """Samples that move, on contours set apart so that none leaves its own."""

    def __init__(self, lines: Contours, samples: Samples) -> None:
        self.loop, self.start = samples.loop, samples.start
        self.length = lines.length
        self.arc_start = lines.arc_start
        self.place = samples.arc - lines.arc_start[samples.loop]
        self.ahead, self.behind = following(self.start), preceding(self.start)
        self.around = np.where(self.ahead <= np.arange(len(self.loop)), self.length[self.loop], 0.0)

    def gap(self) -> FloatArray:
        """(S,) mm from each sample to the next."""
        return np.asarray(self.place[self.ahead] - self.place + self.around)

    def locate(self, arc: FloatArray, loop: IntArray) -> tuple[IntArray, FloatArray]:
        """The sample before each of places on contours, and how far these lie from the contour's beginning, mm.

        Places before a contour's first sample lie in its last wave, one turn farther on.
        """
        before = np.searchsorted(self.place + self.arc_start[self.loop], arc, side="right") - 1
        wrapped = before < self.start[loop]
        before = np.where(wrapped, self.start[loop + 1] - 1, before)
        return before, arc - self.arc_start[loop] + np.where(wrapped, self.length[loop], 0.0)

    def follow(self, pairs: _Pairs) -> None:
        """Find the samples before all places anew after samples have moved, by less than a spacing."""
        along = pairs.place - self.place.take(pairs.before)
        gap = self.gap().take(pairs.before)
        astray = np.flatnonzero((along < 0) | (along >= gap))
        early = along[astray] < 0
        old = pairs.before[astray]
        new = np.where(early, self.behind[old], self.ahead[old])
        # Over the contour's beginning the place is one turn farther or nearer.
        pairs.place[astray] += np.where(early, self.around[new], -self.around[old])
        pairs.before[astray] = new


def polished(
    projector: Projector,
    grid: PhaseGrid,
    samples: Samples,
    weight: FloatArray,
    effort: Polish,
    settings: PrintSettings,
) -> tuple[Samples, float]:
    """Samples with less visible seams, their spacings in [λ, 2λ), and how much of the contours is seen to be a seam.

    Args:
        projector: made for the contours of all layers.
        grid: of all layers.
        samples: at least one on each contour that the grid knows.
        weight: (N,) how much a seam at each contour point matters.
        effort: how much to do.
        settings: the wavelength is used.
    """
    lines, least = projector.lines, settings.wavelength
    waves = _Waves(lines, samples)
    near, node = _near_seams(lines, grid, waves, effort)
    if not len(node):
        return samples, 0.0
    # Only where everything that a sample shapes is among the pairs.
    free = near & near[waves.behind]
    pairs = _pairs(projector, grid, waves, node, free, weight, effort.every)
    best, best_place = np.inf, waves.place
    for stage in effort.stages:
        velocity = np.zeros(len(waves.place))
        for number in range(stage.rounds + 1):
            waves.follow(pairs)
            descent = _Descent(waves, pairs, stage)
            if descent.seen < best:
                best, best_place = descent.seen, waves.place
            for _ in range(effort.turn if number < stage.rounds else 0):
                velocity = np.where(free, MOMENTUM * velocity + descent.move(), 0.0)
                velocity = np.minimum(np.maximum(velocity, -LONGEST * least), LONGEST * least)
                waves.place = waves.place + velocity
            waves.place = pushed(waves.place, waves.loop, waves.start, waves.length, least)
    samples = Samples.on(lines, bounded(lines, lines.arc_start[waves.loop] + best_place, waves.loop, settings))
    mean = lines.arc_start[-1] / len(lines.arc)
    return samples, best / (mean * float(weight[(np.diff(samples.start) > 0)[projector.loop]].sum()))


def _near_seams(lines: Contours, grid: PhaseGrid, waves: _Waves, effort: Polish) -> tuple[BoolArray, IntArray]:
    """Which samples are near a seam, and the nodes on whose edges or their images are waves that they shape."""
    node = np.flatnonzero(grid.linked)
    own, up = grid.loop[node], grid.loop[grid.low[node]]
    gap = waves.gap()
    low, place = waves.locate(grid.arc[node], own)
    high, image = waves.locate(grid.above[node], up)
    slide = (place - waves.place[low]) / gap[low] - (image - waves.place[high]) / gap[high]
    seam = 4 * np.sin(np.pi * slide) ** 2 > effort.seam
    near = np.zeros(len(waves.place), dtype=bool)
    near[low[seam]] = True
    near[high[seam]] = True
    for _ in range(effort.around):
        near |= near[waves.ahead] | near[waves.behind]
    wanted = np.zeros(len(grid.arc), dtype=bool)
    wanted[node] = near[low] | near[high]
    wanted |= wanted[grid.ahead]
    return near, np.flatnonzero(wanted)


def _pairs(
    projector: Projector,
    grid: PhaseGrid,
    waves: _Waves,
    node: IntArray,
    free: BoolArray,
    weight: FloatArray,
    every: float,
) -> _Pairs:
    """Places on the edges from nodes and their images among the samples, those that a free sample shapes."""
    lines = projector.lines
    many = np.ceil(grid.length[node] / every).astype(np.int64)
    share = (ranges(np.zeros(len(many), dtype=np.int64), many) + 0.5) / np.repeat(many, many)
    node, each = np.repeat(node, many), np.repeat(grid.length[node] / many, many)
    arc = grid.arc[node] + share * grid.length[node]
    image = grid.above[node] + share * grid.step[node]
    torn = np.flatnonzero(np.isnan(image))
    image[torn] = projector.above(projector.at(arc[torn]), lines.layer[grid.loop[node[torn]]])
    up = np.where(np.isnan(grid.step[node]), loop_of(lines, np.nan_to_num(image)), grid.loop[grid.low[node]])
    image = lines.arc_start[up] + np.mod(image - lines.arc_start[up], lines.length[up])
    found = np.flatnonzero(~np.isnan(image) & (np.diff(waves.start)[up] > 0))
    low, place = waves.locate(arc[found], grid.loop[node[found]])
    high, _ = waves.locate(image[found], up[found])
    shaped = free | free[waves.ahead]
    some = np.flatnonzero(shaped[low] | shaped[high])
    found, low, place = found[some], low[some], place[some]
    # Between nodes the image is near the line between theirs.
    image, distance = projector.nearby(projector.at(arc[found]), image[found])
    some = np.flatnonzero(distance <= projector.threshold)
    found, low, place = found[some], low[some], place[some]
    high, above = waves.locate(image[some], up[found])
    matters = weight[np.searchsorted(lines.arc, arc[found], side="right") - 1] * each[found]
    return _Pairs(np.concatenate([low, high]), np.concatenate([place, above]), matters.astype(np.float32))


class _Descent:
    """A few steps, in which no place comes to lie between other samples; in single precision, which is plenty."""

    def __init__(self, waves: _Waves, pairs: _Pairs, stage: Stage) -> None:
        self.waves, self.pairs, self.stage = waves, pairs, stage
        share, gap = self._shares()
        # How much a place's share falls for each mm that the sample after it goes, and the one before it.
        self.after = share / gap
        self.own = 1 / gap - self.after
        difference, rise = self._rise(share)
        error = difference**2
        self.seen = float(pairs.importance @ (error >= VISIBLE))
        slope = np.tile(self._slope(error), 2)
        slope *= rise**2
        self.damped = self._summed(slope * self.own**2, slope * self.after**2) + DAMPING

    def move(self) -> FloatArray:
        """(S,) mm that each sample should move."""
        difference, rise = self._rise(self._shares()[0])
        rise *= np.tile(self._slope(difference**2) * difference, 2)
        return -self.stage.rate * self._summed(rise * self.own, rise * self.after) / self.damped

    def _shares(self) -> tuple[Singles, Singles]:
        """(2 P,) how far each place lies on the way from the sample before to the next, and the mm between these."""
        gap = self.waves.gap().astype(np.float32).take(self.pairs.before)
        along = self.pairs.place - self.waves.place.take(self.pairs.before)
        return along.astype(np.float32) / gap, gap

    def _rise(self, share: Singles) -> tuple[Singles, Singles]:
        """(P,) t₁ − t₂ and (2 P,) how fast it rises as either share falls."""
        share *= FULL
        low, high = np.split(np.cos(share), 2)
        rise = FULL * np.sin(share)
        rise[len(low) :] *= -1
        return low - high, rise

    def _slope(self, error: Singles) -> Singles:
        """(P,) twice how fast what counts grows with the error."""
        return 2 * self.pairs.importance * (sharpness(error, self.stage) + UNSEEN_COST)

    def _summed(self, own: Singles, after: Singles) -> FloatArray:
        """(S,) what acts on each sample, from the places after it and from those before it."""
        size = len(self.waves.place)
        return (
            np.bincount(self.pairs.before, own, size) + np.bincount(self.pairs.before, after, size)[self.waves.behind]
        )


def sharpness(error: Singles, stage: Stage) -> Singles:
    """How fast what counts as seen grows with the error."""
    power = error / np.float32(stage.half)
    lower = np.full_like(error, 2**stage.doublings / stage.half)
    for _ in range(stage.doublings):
        lower *= power
        power *= power
    power += 1
    power *= power
    lower /= power
    return lower
