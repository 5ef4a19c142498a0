"""The last step of the optimized sampling: samples around visible seams are moved so that less of the seams is visible.

Everything before treats the phase as smooth; what is measured is the error d = (t₁ − t₂)² of waves that are straight in
phase from sample to sample (paper, section 6.4), and whether it is seen. Here the samples near seams descend on

    Σ qᵖ / (qᵖ + q₀ᵖ) + α q

over places on the contours and their images on the layer above: the first term counts what is seen, the sharper the
larger p is, the second keeps what is not from growing. With u₁ and u₂ the phases of a place and its image,

    d = 4 sin²(π (u₁ − u₂)) sin²(π (u₁ + u₂)).

Either q is d itself, for which places have to lie close, or it is sin²(π (u₁ − u₂)), which changes so slowly along the
contour that one or two places a wave are enough: at all phases that a slide may meet, it decides how much is seen.

A step is a Gauss-Newton step with the diagonal alone and some momentum, cut to a tenth of a millimeter; after each,
spacings are pushed back into their bounds.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..contours.contours import Contours, loop_of
from ..model import BoolArray, FloatArray, IntArray
from ..ragged import following, preceding, ranges, sums
from ..records import dataclass
from ..settings import PrintSettings
from .phase_grid import PhaseGrid
from .sampling import Projector, Samples
from .spacing import bounded, pushed

Singles = NDArray[np.float32]

# α, where q is the error and where it comes from the slide.
UNSEEN_ERROR, UNSEEN_SLIDE = 0.03, 0.1
# The greatest length of a step in wavelengths, and what damps it, 1/mm².
LONGEST, DAMPING = 0.08, 1.0
# Steps have at least this share of the stiffness of no slide, however far the waves have slid.
LEAST_STIFFNESS = 0.15
# Share of a step that the next one keeps on.
MOMENTUM = 0.6
# After so many steps places are located anew among the samples.
RELOCATED = 8
# The error from which on a seam is seen.
VISIBLE = 0.5
HALF, FULL = np.float32(np.pi), np.float32(2 * np.pi)


@dataclass(frozen=True)
class Stage:
    """Steps that count seams alike.

    Attributes:
        steps: how many.
        doublings: p is 2 to this power.
        half: q₀, which counts half.
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
        apart: distance of the places in points of the contours.
        exact: whether the error itself counts, not the slide.
    """

    stages: tuple[Stage, ...]
    seam: float
    around: int
    apart: float
    exact: bool = False


@dataclass(frozen=True)
class _Pairs:
    """P places in the first and their images in the second row, and how much a seam between the two matters.

    Attributes:
        before: (2, P) int64, the sample before each.
        along: (2, P) mm, how far it lies after where that sample was at first.
        importance: (P,) mm of contour.
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

    def seen(self, pairs: _Pairs, exact: bool) -> float:
        """How many mm of the pairs are seen to be a seam, if not `exact` by their slide alone."""
        share, _ = self.shares(pairs)
        if exact:
            low, high = np.cos(FULL * share)
            return float(pairs.importance @ ((low - high) ** 2 >= VISIBLE))
        # The share of all phases at which 4 sin²(π slide) sin²(phase) is VISIBLE.
        least = np.float32(np.sqrt(VISIBLE) / 2) / np.maximum(np.abs(np.sin(HALF * (share[0] - share[1]))), 1e-6)
        return float(pairs.importance @ np.arccos(np.minimum(least, 1))) / (np.pi / 2)

    def shares(self, pairs: _Pairs) -> tuple[Singles, Singles]:
        """(2, P) how far each place lies on the way from the sample before to the next, and 1 by the mm between these.

        Where samples have moved past places since these were located, that is a little less than 0 or more than 1.
        """
        moved, inverse = (self.place - self.first).astype(np.float32), (1 / self.gap()).astype(np.float32)
        steep = inverse.take(pairs.before)
        share = pairs.along - moved.take(pairs.before)
        share *= steep
        return share, steep

    def relocate(self, pairs: _Pairs) -> None:
        """Find the samples before all places anew, where samples have moved past these by less than a spacing."""
        share, _ = self.shares(pairs)
        astray = np.nonzero((share < 0) | (share >= 1))
        old, early = pairs.before[astray], share[astray] < 0
        new = np.where(early, self.behind[old], self.ahead[old])
        pairs.along[astray] += np.where(early, self.first_gap[new], -self.first_gap[old])
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
    pairs = _pairs(projector, grid, waves, node, free, weight, effort.apart)
    best, best_place = np.inf, waves.place
    for stage in effort.stages:
        velocity = np.zeros(len(waves.place))
        for number in range(stage.steps):
            if number % RELOCATED == RELOCATED - 1:
                waves.relocate(pairs)
            velocity *= MOMENTUM
            velocity += _descent(waves, pairs, stage, effort.exact)
            velocity *= free
            np.minimum(np.maximum(velocity, -LONGEST * least, out=velocity), LONGEST * least, out=velocity)
            waves.place = pushed(waves.place + velocity, waves.loop, waves.start, waves.length, least)
        waves.relocate(pairs)
        seen = waves.seen(pairs, effort.exact)
        if seen < best:
            best, best_place = seen, waves.place
    samples = Samples.on(lines, bounded(lines, lines.arc_start[waves.loop] + best_place, waves.loop, settings))
    patterned = sums(weight, lines.start)[np.diff(samples.start) > 0].sum() * lines.arc_start[-1] / len(lines.arc)
    return samples, float(best / patterned)


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
    apart: float,
) -> _Pairs:
    """Places on the edges from nodes and their images among the samples, those that a free sample shapes."""
    lines = projector.lines
    loop = grid.loop[node]
    last = np.where(grid.seam[node] > 0, lines.start[loop + 1], np.searchsorted(lines.arc, grid.arc[grid.ahead[node]]))
    # How many places lie before each edge's beginning and before its end.
    begin, end = (
        np.ceil((point - lines.start[loop]) / apart).astype(np.int64)
        for point in (np.searchsorted(lines.arc, grid.arc[node]), last)
    )
    edge, place = np.repeat(node, end - begin), apart * ranges(begin, end - begin)
    point = place.astype(np.int64)
    place -= point
    point += lines.start.take(grid.loop.take(edge))
    away = projector.along.take(point) * place
    query, arc = projector.spot.take(point) + away, lines.arc.take(point) + np.abs(away)
    low, along = waves.locate(arc, grid.loop[edge])
    image = grid.above[edge] + (arc - grid.arc[edge]) / grid.length[edge] * grid.step[edge]
    up = grid.loop.take(grid.low.take(edge))
    torn = np.flatnonzero(np.isnan(image))
    image[torn] = projector.above(query[torn].view(np.float64).reshape(-1, 2), lines.layer[grid.loop[edge[torn]]])
    up[torn] = loop_of(lines, np.nan_to_num(image[torn]))
    bottom, top = lines.arc_start.take(up), lines.arc_start.take(up + 1)
    image += (top - bottom) * ((image < bottom).astype(float) - (image >= top))
    found = np.flatnonzero(~np.isnan(image) & (np.diff(waves.start)[up] > 0))
    high, _ = waves.locate(image[found], up[found])
    shaped = free | free[waves.ahead]
    some = np.flatnonzero(shaped[low[found]] | shaped[high])
    found = found[some]
    # Between nodes the image is near the line between theirs.
    image, distance = projector.nearby(query[found].view(np.float64).reshape(-1, 2), image[found])
    some = np.flatnonzero(distance <= projector.threshold)
    found = found[some]
    high, above = waves.locate(image[some], up[found])
    matters = weight.take(point[found]) * (apart * float(lines.arc_start[-1] / len(lines.arc)))
    after = np.stack([along[found], above]).astype(np.float32)
    return _Pairs(np.stack([low[found], high]), after, matters.astype(np.float32))


def _descent(waves: _Waves, pairs: _Pairs, stage: Stage, exact: bool) -> FloatArray:
    """(S,) mm that each sample should move, in single precision, which is plenty."""
    share, steep = waves.shares(pairs)
    pull, stiffness = (_by_error if exact else _by_slide)(share, pairs.importance, stage)
    pull *= steep
    steep *= steep
    stiffness = stiffness * steep
    before, size = pairs.before.ravel(), len(waves.place)

    def summed(values: Singles) -> FloatArray:
        """Values of places for both samples around each, by how near it is to them."""
        after = values * share
        values -= after
        of_next = np.bincount(before, after.ravel(), size)
        return np.asarray(np.bincount(before, values.ravel(), size) + of_next.take(waves.behind))

    return -stage.rate * summed(pull) / (summed(stiffness) + DAMPING)


def _by_error(share: Singles, importance: Singles, stage: Stage) -> tuple[Singles, Singles]:
    """(2, P) how fast the cost falls with the phase of each place, and how stiff it is there."""
    low, high = np.cos(FULL * share)
    rise = FULL * np.sin(FULL * share)
    rise[1] *= -1
    slope = 2 * importance * (sharpness((low - high) ** 2, stage) + UNSEEN_ERROR)
    return slope * (low - high) * rise, slope * rise**2


def _by_slide(share: Singles, importance: Singles, stage: Stage) -> tuple[Singles, Singles]:
    """The same of the slide: (2, P) and (P,)."""
    slide = FULL * (share[0] - share[1])
    cosine = np.cos(slide)
    slope = HALF * importance * (sharpness((1 - cosine) / 2, stage) + UNSEEN_SLIDE)
    pull = slope * np.sin(slide)
    return np.stack([-pull, pull]), HALF * slope * (1 + 2 * LEAST_STIFFNESS + cosine)


def sharpness(cost: Singles, stage: Stage) -> Singles:
    """How fast what counts as seen grows with q."""
    power = cost / np.float32(stage.half)
    lower = np.full_like(cost, 2**stage.doublings / stage.half)
    for _ in range(stage.doublings):
        lower *= power
        power *= power
    power += 1
    power *= power
    lower /= power
    return lower
