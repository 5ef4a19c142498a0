"""The last step of the optimised sampling: samples around visible seams are moved so that less of the seams is visible.

Everything before treats the phase as smooth; what is measured is the error d = (t₁ − t₂)² of waves that are straight in
phase from sample to sample (paper, section 6.4), and whether it is seen. Here the samples near seams descend on

    Σ dᵖ / (dᵖ + d₀ᵖ) + α d

over contour points and their images on the layer above: the first term counts what is seen, the sharper the larger p
is, the second keeps what is not from growing. A step is a Gauss-Newton step with the diagonal alone and some momentum,
cut to a few hundredths of a millimetre, and after it spacings are pushed back into their bounds. The best of all steps
is kept. Where time is taken for it, the count gets sharper stage by stage, at points twice as dense, each projected.
"""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..records import dataclass
from ..settings import PrintSettings
from ..slicing.outlines import following, preceding
from .contours import Contours, loop_of
from .phase_grid import PhaseGrid
from .sampling import Projector, Samples
from .spacing import bounded, pushed

UNSEEN_COST = 0.03
# The greatest length of a step in wavelengths, and what damps it, 1/mm².
LONGEST, DAMPING = 0.04, 2.0
# Share of a step that the next one keeps on.
MOMENTUM = 0.6
VISIBLE = 0.5


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
        seam: the error from which a place counts as part of a seam.
        around: how many samples around a seam may move.
        exact: whether points between those of the contours count too, and all are projected one by one.
    """

    stages: tuple[Stage, ...]
    seam: float
    around: int
    exact: bool = False


@dataclass(frozen=True)
class _Located:
    """Places among the samples: the sample before, the place in its turn, the share of the way to the next, the gap."""

    before: IntArray
    place: FloatArray
    share: FloatArray
    gap: FloatArray


class _Waves:
    """Samples that move, on contours set apart so that none leaves its own."""

    def __init__(self, lines: Contours, samples: Samples) -> None:
        self.loop, self.start = samples.loop, samples.start
        self.length = lines.length
        self.apart = 4 * float(lines.length.max())
        self.place = samples.arc - lines.arc_start[samples.loop]
        self.ahead, self.behind = following(self.start), preceding(self.start)
        self.around = np.where(self.ahead <= np.arange(len(self.loop)), self.length[self.loop], 0.0)

    def locate(self, place: FloatArray, loop: IntArray) -> _Located:
        """Where places on contours lie among the samples."""
        key = self.place + self.apart * self.loop
        before = np.searchsorted(key, place + self.apart * loop, side="right") - 1
        wrapped = before < self.start[loop]
        before = np.where(wrapped, self.start[loop + 1] - 1, before)
        turned = place + np.where(wrapped, self.length[loop], 0.0)
        return self.followed(_Located(before, turned, turned, turned))

    def followed(self, last: _Located) -> _Located:
        """The same places after samples have moved, by less than a spacing."""
        gap = self.place[self.ahead] - self.place + self.around
        before, place = last.before, last.place
        along, here = place - self.place[before], gap[before]
        astray = np.flatnonzero((along < 0) | (along >= here))
        if len(astray):
            early = along[astray] < 0
            old = before[astray]
            new = np.where(early, self.behind[old], self.ahead[old])
            # Over the contour's beginning the place is one turn farther or nearer.
            turn = np.where(early, self.around[new], -self.around[old])
            before, place = before.copy(), place.copy()
            before[astray], place[astray] = new, place[astray] + turn
            along, here = place - self.place[before], gap[before]
        return _Located(before, place, np.clip(along / here, 0.0, 1.0), here)


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
        grid: the fine grid on them.
        samples: at least one on each contour that the grid knows.
        weight: (N,) how much a seam at each contour point matters.
        effort: how much to do.
        settings: the wavelength is used.
    """
    lines = projector.lines
    waves = _Waves(lines, samples)
    near, point = _near_seams(lines, grid, waves, effort)
    if not len(point):
        return samples, 0.0
    # Only where everything that a sample shapes is among the pairs.
    free = near & near[waves.behind]
    place, share = lines.arc[point], 1.0
    if effort.exact:
        place, point, share = np.concatenate([place, _midpoints(lines, point)]), np.tile(point, 2), 0.5
        image = projector.above(projector.at(place), lines.layer[projector.loop[point]])
    else:
        image = grid.carried(lines, place, np.ones(len(point), dtype=bool))
    lower, upper, counted = _pairs(lines, waves, place, image, free)
    best, place = _settled(
        waves, lower, upper, (share * weight[point[counted]]).astype(np.float32), free, effort, settings.wavelength
    )
    samples = Samples.on(lines, bounded(lines, lines.arc_start[waves.loop] + place, waves.loop, settings))
    return samples, best / float(weight[np.diff(samples.start)[lines.loop] > 0].sum())


def _settled(
    waves: _Waves,
    lower: _Located,
    upper: _Located,
    importance: FloatArray,
    free: BoolArray,
    effort: Polish,
    least: float,
) -> tuple[float, FloatArray]:
    """Run all stages; how much is seen at best, and where the samples are then."""
    best, best_place = np.inf, waves.place
    for stage in effort.stages:
        velocity = np.zeros(len(waves.place))
        for step in range(stage.steps + 1):
            lower, upper = waves.followed(lower), waves.followed(upper)
            move, seen = _descent(waves, lower, upper, importance, stage)
            if seen < best:
                best, best_place = seen, waves.place
            if step < stage.steps:
                velocity = np.where(free, np.clip(MOMENTUM * velocity + move, -LONGEST * least, LONGEST * least), 0.0)
                place = waves.place + velocity
                waves.place = pushed(place, waves.loop, waves.start, waves.length, least)
    return best, best_place


def _midpoints(lines: Contours, point: IntArray) -> FloatArray:
    """The places halfway from contour points to the next ones."""
    end = np.append(lines.arc[1:], lines.arc_start[-1])
    last = lines.start[1:] - 1
    end[last] = lines.arc_start[1:]
    return np.asarray((lines.arc[point] + end[point]) / 2)


def _near_seams(lines: Contours, grid: PhaseGrid, waves: _Waves, effort: Polish) -> tuple[BoolArray, IntArray]:
    """Which samples are near a seam, and the contour points whose waves or images' waves they shape."""
    node = np.flatnonzero(grid.linked)
    up = loop_of(lines, grid.above[node])
    low = waves.locate(grid.arc[node] - lines.arc_start[grid.loop[node]], grid.loop[node])
    high = waves.locate(grid.above[node] - lines.arc_start[up], up)
    seam = (np.cos(2 * np.pi * low.share) - np.cos(2 * np.pi * high.share)) ** 2 > effort.seam
    near = np.zeros(len(waves.place), dtype=bool)
    near[low.before[seam]] = True
    near[high.before[seam]] = True
    for _ in range(effort.around):
        near |= near[waves.ahead] | near[waves.behind]
    wanted = np.zeros(len(grid.arc), dtype=bool)
    wanted[node] = near[low.before] | near[high.before]
    wanted |= wanted[grid.behind] | wanted[grid.ahead]
    before = np.searchsorted(grid.arc, lines.arc, side="right") - 1
    loop = lines.loop
    known = (before >= 0) & (np.diff(waves.start)[loop] > 0)
    return near, np.flatnonzero(known & wanted[np.maximum(before, 0)])


def _pairs(
    lines: Contours, waves: _Waves, place: FloatArray, image: FloatArray, free: BoolArray
) -> tuple[_Located, _Located, IntArray]:
    """Places and their images among the samples, and which they are; those that a free sample shapes."""
    found = np.flatnonzero(~np.isnan(image))
    found = found[np.diff(waves.start)[loop_of(lines, image[found])] > 0]
    up, own = loop_of(lines, image[found]), loop_of(lines, place[found])
    low = waves.locate(place[found] - lines.arc_start[own], own)
    high = waves.locate(image[found] - lines.arc_start[up], up)
    shaped = free | free[waves.ahead]
    some = np.flatnonzero(shaped[low.before] | shaped[high.before])
    return (
        _Located(low.before[some], low.place[some], low.share[some], low.gap[some]),
        _Located(high.before[some], high.place[some], high.share[some], high.gap[some]),
        found[some],
    )


def _descent(
    waves: _Waves, low: _Located, high: _Located, importance: FloatArray, stage: Stage
) -> tuple[FloatArray, float]:
    """How far each sample should move, mm, and how much is seen now."""
    size = len(waves.place)
    # Single precision is plenty for which way to go, and its sines are cheap.
    full = np.float32(2 * np.pi)
    share, high_share = low.share.astype(np.float32), high.share.astype(np.float32)
    turn, high_turn = full * share, full * high_share
    difference = np.cos(turn) - np.cos(high_turn)
    error = difference**2
    seen = float(importance[error >= VISIBLE].sum(dtype=float))
    slope = 2 * importance * (_sharpness(error, stage) + UNSEEN_COST)
    pull, stiffness = np.zeros(size), np.zeros(size)
    for place, part, rise in ((low, share, np.sin(turn)), (high, high_share, -np.sin(high_turn))):
        rise *= full / place.gap.astype(np.float32)
        ahead, before = rise * part, rise - rise * part
        weighted = slope * ahead
        pull += np.bincount(place.before, weighted * difference, size)[waves.behind]
        stiffness += np.bincount(place.before, weighted * ahead, size)[waves.behind]
        weighted = slope * before
        pull += np.bincount(place.before, weighted * difference, size)
        stiffness += np.bincount(place.before, weighted * before, size)
    return -stage.rate * pull / (stiffness + DAMPING), seen


def _sharpness(error: FloatArray, stage: Stage) -> FloatArray:
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
