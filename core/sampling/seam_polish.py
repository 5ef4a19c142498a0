"""The last step of the optimized sampling: samples around visible seams are moved so that less of the seams is visible.

Everything before treats the phase as smooth; what is measured is the error d = (t₁ − t₂)² of waves that are straight in
phase from sample to sample (paper, section 6.4), and whether it is seen. Here the samples near seams descend on

    Σ dᵖ / (dᵖ + d₀ᵖ) + α d

over places on the contours and their images on the layer above: the first term counts what is seen, the sharper the
larger p is, the second keeps what is not from growing. A step is a Gauss-Newton step with the diagonal alone and some
momentum, cut to a tenth of a millimeter; after each, spacings are pushed back into their bounds. The best of what is
met is kept.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..contours.contours import Contours, loop_of
from ..model import BoolArray, FloatArray, IntArray
from ..ragged import following, preceding, ranges
from ..records import dataclass
from ..settings import PrintSettings
from .phase_grid import PhaseGrid
from .sampling import Projector, Samples
from .spacing import bounded, pushed

Singles = NDArray[np.float32]

UNSEEN_COST = 0.03
# The greatest length of a step in wavelengths, and what damps it, 1/mm².
LONGEST, DAMPING = 0.08, 2.0
# Share of a step that the next one keeps on.
MOMENTUM = 0.6
VISIBLE = 0.5
FULL = np.float32(2 * np.pi)


@dataclass(frozen=True)
class Stage:
    """Steps that count seams alike.

    Attributes:
        steps: how many.
        doublings: p is 2 to this power.
        half: d₀, the error that counts half.
        rate: the share of the Gauss-Newton step that is gone.
    """

    steps: int
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
        parts: places on each segment of the contours.
    """

    stages: tuple[Stage, ...]
    seam: float
    around: int
    parts: int = 1


@dataclass(frozen=True)
class _Pairs:
    """P places and then their P images, the sample before each and how much a seam between each two matters.

    `along` is how far a place lies after where the sample before it was at first, mm.
    """

    before: IntArray
    along: Singles
    importance: Singles


class _Waves:
    """Samples that move, on contours set apart so that none leaves its own."""

    def __init__(self, lines: Contours, samples: Samples) -> None:
        self.loop, self.start = samples.loop, samples.start
        self.length = lines.length
        self.arc_start = lines.arc_start
        self.arc = samples.arc
        self.first = self.place = samples.arc - lines.arc_start[samples.loop]
        self.ahead, self.behind = following(self.start), preceding(self.start)
        self.around = np.where(self.ahead <= np.arange(len(self.loop)), self.length[self.loop], 0.0)
        self.first_gap = self.gap().astype(np.float32)

    def gap(self) -> FloatArray:
        """(S,) mm from each sample to the next."""
        return np.asarray(self.place[self.ahead] - self.place + self.around)

    def locate(self, arc: FloatArray, loop: IntArray) -> tuple[IntArray, FloatArray]:
        """The sample before each of places on contours at first, and how far these lie after it, mm.

        Places before a contour's first sample lie in its last wave, one turn farther on.
        """
        before = np.searchsorted(self.arc, arc, side="right") - 1
        wrapped = np.flatnonzero(before < self.start.take(loop))
        before[wrapped] = self.start[loop[wrapped] + 1] - 1
        along = arc - self.arc.take(before)
        along[wrapped] += self.length[loop[wrapped]]
        return before, along

    def shares(self, pairs: _Pairs) -> tuple[Singles, Singles]:
        """(2 P,) how far each place lies on the way from the sample before to the next, and 1 by the mm between these.

        The samples before all places are found anew where samples have moved past these, by less than a spacing.
        """
        moved, inverse = (self.place - self.first).astype(np.float32), (1 / self.gap()).astype(np.float32)
        steep = inverse.take(pairs.before)
        share = (pairs.along - moved.take(pairs.before)) * steep
        astray = np.flatnonzero((share < 0) | (share >= 1))
        old = pairs.before[astray]
        new = np.where(share[astray] < 0, self.behind[old], self.ahead[old])
        pairs.along[astray] += np.where(share[astray] < 0, self.first_gap[new], -self.first_gap[old])
        pairs.before[astray], steep[astray] = new, inverse[new]
        share[astray] = (pairs.along[astray] - moved[new]) * inverse[new]
        return share, steep


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
    pairs = _pairs(projector, grid, waves, node, free, weight, effort.parts)
    best, best_place = np.inf, waves.place
    for stage in effort.stages:
        velocity = np.zeros(len(waves.place))
        for number in range(stage.steps + 1):
            share, steep = waves.shares(pairs)
            low, high = np.split(np.cos(FULL * share), 2)
            seen = float(pairs.importance @ ((low - high) ** 2 >= VISIBLE))
            if seen < best:
                best, best_place = seen, waves.place
            if number == stage.steps:
                break
            velocity = np.where(
                free, MOMENTUM * velocity + _descent(waves, pairs, share, steep, low - high, stage), 0.0
            )
            velocity = np.minimum(np.maximum(velocity, -LONGEST * least), LONGEST * least)
            waves.place = pushed(waves.place + velocity, waves.loop, waves.start, waves.length, least)
    samples = Samples.on(lines, bounded(lines, lines.arc_start[waves.loop] + best_place, waves.loop, settings))
    mean = lines.arc_start[-1] / len(lines.arc)
    return samples, best / (mean * float(weight[(np.diff(samples.start) > 0)[projector.loop]].sum()))


def _near_seams(lines: Contours, grid: PhaseGrid, waves: _Waves, effort: Polish) -> tuple[BoolArray, IntArray]:
    """Which samples are near a seam, and the nodes on whose edges or their images are waves that they shape."""
    node = np.flatnonzero(grid.linked)
    own, up = grid.loop[node], grid.loop[grid.low[node]]
    gap = waves.gap()
    low, along = waves.locate(grid.arc[node], own)
    high, above = waves.locate(grid.above[node], up)
    slide = along / gap[low] - above / gap[high]
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
    parts: int,
) -> _Pairs:
    """Places on the edges from nodes and their images among the samples, those that a free sample shapes."""
    lines = projector.lines
    begin, end = (np.searchsorted(lines.arc, arc) for arc in (grid.arc[node], grid.arc[grid.ahead[node]]))
    many = np.where(grid.seam[node] > 0, lines.start[grid.loop[node] + 1], end) - begin
    edge, point = np.repeat(node, many * parts), np.repeat(ranges(begin, many), parts)
    away = projector.along.take(point) * (np.arange(len(point)) % parts / parts)
    query, arc = projector.spot.take(point) + away, lines.arc.take(point) + np.abs(away)
    image = grid.above[edge] + (arc - grid.arc[edge]) / grid.length[edge] * grid.step[edge]
    up = grid.loop.take(grid.low.take(edge))
    torn = np.flatnonzero(np.isnan(image))
    image[torn] = projector.above(query[torn].view(np.float64).reshape(-1, 2), lines.layer[grid.loop[edge[torn]]])
    up[torn] = loop_of(lines, np.nan_to_num(image[torn]))
    bottom, top = lines.arc_start.take(up), lines.arc_start.take(up + 1)
    image += (top - bottom) * ((image < bottom).astype(float) - (image >= top))
    found = np.flatnonzero(~np.isnan(image) & (np.diff(waves.start)[up] > 0))
    low, along = waves.locate(arc[found], grid.loop[edge[found]])
    high, _ = waves.locate(image[found], up[found])
    shaped = free | free[waves.ahead]
    some = np.flatnonzero(shaped[low] | shaped[high])
    found, low, along = found[some], low[some], along[some]
    # Between nodes the image is near the line between theirs.
    image, distance = projector.nearby(query[found].view(np.float64).reshape(-1, 2), image[found])
    some = np.flatnonzero(distance <= projector.threshold)
    found, low, along = found[some], low[some], along[some]
    high, above = waves.locate(image[some], up[found])
    matters = weight.take(point[found]) * np.abs(projector.along.take(point[found])) / parts
    after = np.concatenate([along, above]).astype(np.float32)
    return _Pairs(np.concatenate([low, high]), after, matters.astype(np.float32))


def _descent(
    waves: _Waves, pairs: _Pairs, share: Singles, steep: Singles, difference: Singles, stage: Stage
) -> FloatArray:
    """(S,) mm that each sample should move, in single precision, which is plenty; arguments as of `_Waves.shares`.

    `difference` (P,) is t₁ − t₂.
    """
    # How fast it rises as either place's share falls, for each mm that the samples around it go.
    rise = np.sin(FULL * share)
    rise *= FULL * steep
    rise[len(difference) :] *= -1
    slope = 2 * pairs.importance * (sharpness(difference**2, stage) + UNSEEN_COST)
    pull = np.tile(slope * difference, 2) * rise
    stiff = np.tile(slope, 2)
    stiff *= rise
    stiff *= rise
    own, size = 1 - share, len(waves.place)

    def summed(own: Singles, after: Singles) -> FloatArray:
        of_next = np.bincount(pairs.before, after, size)
        return np.bincount(pairs.before, own, size) + of_next[waves.behind]

    return -stage.rate * summed(pull * own, pull * share) / (summed(stiff * own**2, stiff * share**2) + DAMPING)


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
