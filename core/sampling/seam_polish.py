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

from ..model import BoolArray, FloatArray
from ..ragged import sums
from ..records import dataclass
from .phase_grid import PhaseGrid
from .projector import Projector
from .samples import Samples
from .seam_pairs import FULL, HALF, MovingSamples, Pairs, Singles, near_seams, pairs_between
from .spacing import bounded, pushed

# α where q is the error, and where q comes from the slide.
UNSEEN_ERROR, UNSEEN_SLIDE = 0.03, 0.1
# The greatest length of a step, in wavelengths, and what is added to the stiffness to damp it, 1/mm².
LONGEST, DAMPING = 0.08, 1.0
# However far the waves have slid, they count as at least this share as stiff as without any slide.
LEAST_STIFFNESS = 0.15
# Share of a step that the next one keeps on.
MOMENTUM = 0.6
STIFFENED = 2  # steps after which it is found anew how stiff samples are
RELOCATED = 8  # steps after which places are located anew among the samples


@dataclass(frozen=True)
class Stage:
    """Steps that count seams alike.

    Attributes:
        steps: how many.
        doublings: p is 2 to this power.
        half: q₀, the q that counts half.
        rate: the share of the Gauss-Newton step that is taken at first.
        last: the share at last.
    """

    steps: int
    doublings: int
    half: float
    rate: float
    last: float


@dataclass(frozen=True)
class Polish:
    """How much to polish.

    Attributes:
        stages: one after the other.
        seam: sliding by which the error is greater than this somewhere in a wave makes a place part of a seam.
        around: how many samples around a seam may move.
        apart: distance of the places in points of the contours.
        exact: whether the error itself counts, not the slide.
        few: where no more samples are near seams, `more` is done instead.
        more: None if this is never to be.
    """

    stages: tuple[Stage, ...]
    seam: float
    around: int
    apart: float
    exact: bool = False
    few: int = 0
    more: Polish | None = None


def polished(
    projector: Projector,
    grid: PhaseGrid,
    samples: Samples,
    weight: FloatArray,
    effort: Polish,
    wavelength: float,
) -> tuple[Samples, float]:
    """Samples with less visible seams, their spacings in [λ, 2λ), and how much of the contours is seen to be a seam.

    Args:
        projector: made for the contours of all layers.
        grid: of all layers.
        samples: at least one on each contour that the grid knows.
        weight: (N,) how much a seam at each contour point matters.
        effort: how much to do.
        wavelength: λ, mm.
    """
    lines = projector.lines
    waves = MovingSamples(lines, samples)
    near, node = near_seams(grid, waves, effort.seam, effort.around)
    if effort.more and np.count_nonzero(near) <= effort.few:
        effort = effort.more
        near, node = near_seams(grid, waves, effort.seam, effort.around)
    if not len(node):
        return samples, 0.0
    # A sample may move only where everything that depends on it is among the pairs.
    free = near & near[waves.behind]
    pairs = pairs_between(projector, grid, waves, node, free, weight, effort.apart)
    best, best_place = np.inf, waves.place
    for stage in effort.stages:
        _descend(waves, pairs, stage, effort.exact, free, wavelength)
        seen = waves.seen(pairs, effort.exact)
        if seen < best:
            best, best_place = seen, waves.place
    samples = Samples.on(lines, bounded(lines, lines.arc_start[waves.loop] + best_place, waves.loop, wavelength))
    patterned = sums(weight, lines.start)[np.diff(samples.start) > 0].sum() * lines.arc_start[-1] / len(lines.arc)
    return samples, float(best / patterned)


def _descend(waves: MovingSamples, pairs: Pairs, stage: Stage, exact: bool, free: BoolArray, wavelength: float) -> None:
    """Move the samples that are `free` (S,) by the steps of one stage, with some momentum."""
    velocity, stiff, longest = np.zeros(len(waves.place)), None, LONGEST * wavelength
    for number in range(stage.steps):
        if number % RELOCATED == RELOCATED - 1:
            waves.relocate(pairs)
        velocity *= MOMENTUM
        step, stiff = _gauss_newton(waves, pairs, stage, exact, stiff if number % STIFFENED else None)
        step *= stage.rate + (stage.last - stage.rate) * number / max(stage.steps - 1, 1)
        velocity += step
        velocity *= free
        np.minimum(np.maximum(velocity, -longest, out=velocity), longest, out=velocity)
        waves.place = pushed(waves.place + velocity, waves.loop, waves.start, waves.length, wavelength)
    waves.relocate(pairs)


def _gauss_newton(
    waves: MovingSamples, pairs: Pairs, stage: Stage, exact: bool, stiff: FloatArray | None
) -> tuple[FloatArray, FloatArray]:
    """(S,) the Gauss-Newton step of each sample in mm, and (S,) how stiff it is, if that is not given.

    Places are worked on in single precision, which is plenty.
    """
    share, steep = waves.shares(pairs)
    (low, high), stiffness = (_by_error if exact else _by_slide)(share, pairs.importance, stage)
    pull = np.empty_like(steep)
    np.multiply(low, steep[0], out=pull[0])
    np.multiply(high, steep[1], out=pull[1])
    share *= pull
    before, size = pairs.before.ravel(), len(waves.place)

    def summed(of: Singles) -> FloatArray:
        return np.asarray(np.bincount(before, of.ravel(), size), dtype=float)

    # A place pulls at the samples around it by how near it is to them; it is about as stiff for both.
    if stiff is None:
        steep *= steep
        steep *= stiffness
        stiff = summed(steep)
        stiff += stiff.take(waves.behind) + 2 * DAMPING
    total, of_next = summed(pull), summed(share)
    total -= of_next
    total += of_next.take(waves.behind)
    total *= -2
    total /= stiff
    return total, stiff


def _by_error(share: Singles, importance: Singles, stage: Stage) -> tuple[tuple[Singles, Singles], Singles]:
    """How fast the cost falls with the phases of places and images, (P,) each, and (2, P) how stiff it is there."""
    low, high = np.cos(FULL * share)
    rise = FULL * np.sin(FULL * share)
    rise[1] *= -1
    slope = 2 * importance * (sharpness((low - high) ** 2, stage) + UNSEEN_ERROR)
    pull = slope * (low - high) * rise
    return (pull[0], pull[1]), slope * rise**2


def _by_slide(share: Singles, importance: Singles, stage: Stage) -> tuple[tuple[Singles, Singles], Singles]:
    """The same of the slide, of which both are as stiff: (P,)."""
    slide = FULL * (share[0] - share[1])
    cosine = np.cos(slide)
    slope = HALF * importance * (sharpness((1 - cosine) / 2, stage) + UNSEEN_SLIDE)
    pull = slope * np.sin(slide)
    cosine += 1 + 2 * LEAST_STIFFNESS
    cosine *= slope
    cosine *= HALF
    return (-pull, pull), cosine


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
