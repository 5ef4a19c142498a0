"""Spacings of samples around closed contours, and how they are brought within [λ, 2λ)."""

from __future__ import annotations

import numpy as np

from ..contours.contours import Contours
from ..contours.places import long_enough, on_loop
from ..model import BoolArray, FloatArray, IntArray
from ..ragged import following, preceding, ranges, starts

# Spacings are compared with this slack, mm, so that rounding does not prune an exact fit.
SLACK = 1e-9
# They are brought within the bounds by this share of the wavelength, so that rounding does not break them again.
INSIDE = 5e-4


def in_order(local: FloatArray, loop: IntArray) -> tuple[FloatArray, IntArray]:
    """Samples sorted by loop and place."""
    onward = loop[1:] > loop[:-1]
    if (onward | ((loop[1:] == loop[:-1]) & (local[1:] >= local[:-1]))).all():
        return local, loop
    # Nearly in order as they are, they are sorted at once by a sort that goes by runs.
    order = np.argsort(local + loop * (2 * np.abs(local).max()), kind="stable")
    return local[order], loop[order]


def spacings(local: FloatArray, loop: IntArray, length: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(S,) mm from each sample to the next one around its loop, and (S,) to the one before.

    Args:
        local: (S,) mm along its loop, increasing within each.
        loop: (S,) of each sample, not decreasing.
        length: (M,) mm of each loop.
    """
    last = np.flatnonzero(np.append(loop[1:] != loop[:-1], len(loop) > 0))
    first = np.append(0, last[:-1] + 1)[: len(last)]
    ahead, behind = _gaps(local, first, last, length[loop[last]]), np.empty(len(local))
    behind[1:] = ahead[:-1]
    behind[first] = ahead[last]
    return ahead, behind


def gaps(local: FloatArray, start: IntArray, length: FloatArray) -> FloatArray:
    """(S,) mm from each sample to the next one around its loop; `start` (M + 1,) is where each loop's samples start."""
    some = np.flatnonzero(start[1:] > start[:-1])
    return _gaps(local, start[some], start[some + 1] - 1, length[some])


def _gaps(local: FloatArray, first: IntArray, last: IntArray, length: FloatArray) -> FloatArray:
    """As `gaps`, given the first and the last sample of each loop that has any, and the length of these loops."""
    gap = np.empty_like(local)
    np.subtract(local[1:], local[:-1], out=gap[:-1])
    gap[last] = local[first] + length - local[last]
    return gap


def relaxed(local: FloatArray, loop: IntArray, length: FloatArray, share: float) -> tuple[FloatArray, IntArray]:
    """Move every sample by `share` of the way to the middle of its two neighbors.

    Spacings become weighted means of neighboring spacings, so bounds that all of them keep stay kept.
    """
    ahead, behind = spacings(local, loop, length)
    moved = local + share * (ahead - behind) / 2
    around = length[loop]
    if ((moved < 0) | (moved >= around)).any():
        return in_order(np.mod(moved, around), loop)
    return moved, loop


def pruned(local: FloatArray, loop: IntArray, length: FloatArray, least: float) -> tuple[FloatArray, IntArray]:
    """Remove samples until none is closer than `least` to the next.

    In each round the spacings that are shorter than both their neighbors lose one end: the one whose removal leaves
    the shorter gap.
    """
    while True:
        gap, before = spacings(local, loop, length)
        short = gap < least - SLACK
        if not short.any():
            return local, loop
        start = starts(np.bincount(loop, minlength=len(length)))
        ahead, behind = following(start), preceding(start)
        chosen = short & _comes_first(gap, ahead) & _comes_first(gap, behind)
        doomed = np.where(before <= gap[ahead], np.arange(len(gap)), ahead)[chosen]
        keep = np.ones(len(gap), dtype=bool)
        keep[doomed] = False
        local, loop = local[keep], loop[keep]


def _comes_first(gap: FloatArray, other: IntArray) -> BoolArray:
    """Whether each spacing is shorter than another one; of equal ones the earlier counts as shorter."""
    return np.asarray((gap < gap[other]) | ((gap == gap[other]) & (np.arange(len(gap)) < other)))


def filled(
    local: FloatArray, loop: IntArray, length: FloatArray, usable: BoolArray, least: float
) -> tuple[FloatArray, IntArray]:
    """Insert evenly spaced samples into gaps of twice `least` and more, as many as fit; empty loops get some likewise.

    Args:
        local: (S,) mm along its loop, increasing within each.
        loop: (S,) of each sample, not decreasing.
        length: (M,) mm of each loop.
        usable: (M,) which loops are to have samples.
        least: λ, mm.

    Returns:
        Places and loops of all samples.
    """
    gap, _ = spacings(local, loop, length)
    has = np.zeros(len(length), dtype=bool)
    has[loop] = True
    empty = np.flatnonzero(usable & ~has)
    if not len(empty) and (gap < 2 * least - SLACK).all():
        return local, loop
    # An empty loop is one gap of its whole length that has a sample at its beginning.
    begin = np.concatenate([local, np.zeros(len(empty))])
    loop = np.concatenate([loop, empty])
    gap = np.concatenate([gap, length[empty]])
    wide = np.flatnonzero(gap >= 2 * least - SLACK)
    parts = np.floor(gap[wide] / least + SLACK).astype(np.int64)
    source, share = np.repeat(wide, parts - 1), ranges(1, parts - 1)
    place = begin[source] + gap[source] * share / np.repeat(parts, parts - 1)
    local, loop = np.concatenate([begin, place]), np.concatenate([loop, loop[source]])
    return in_order(_on_contours(local, loop, length), loop)


def _on_contours(local: FloatArray, loop: IntArray, length: FloatArray) -> FloatArray:
    """Places (Q,) along closed contours, those beyond an end brought back onto their contour."""
    around = length.take(loop)
    beyond = np.flatnonzero((local < 0) | (local >= around))
    if len(beyond):
        local = local.copy()
        local[beyond] = np.mod(local[beyond], around[beyond])
    return local


def bounded(lines: Contours, arc: FloatArray, loop: IntArray, least: float) -> FloatArray:
    """Samples near the given ones with every spacing in [λ, 2λ), on all contours at once.

    Neighbors that are too close push each other apart, those too far apart pull each other together. Where the number
    of samples does not fit, some are dropped or added as in the paper.

    Args:
        lines: M contours.
        arc: (S,) mm, the samples.
        loop: (S,) their contours.
        least: λ, mm.

    Returns:
        Increasing arcs; none on contours too short for the pattern.
    """
    local, loop = in_order(arc - lines.arc_start[loop], loop)
    start = starts(np.bincount(loop, minlength=len(lines.layer)))
    local = pushed(local, loop, start, lines.length, least)
    local, loop = in_order(_on_contours(local, loop, lines.length), loop)
    local, loop = pruned(local, loop, lines.length, least)
    local, loop = filled(local, loop, lines.length, long_enough(lines.length, least), least)
    return np.sort(on_loop(lines.arc_start[loop] + local, loop, lines.arc_start), kind="stable")


def pushed(local: FloatArray, loop: IntArray, start: IntArray, length: FloatArray, least: float) -> FloatArray:
    """Samples in order on closed contours with every spacing in [λ, 2λ), wherever their number allows it.

    Going around a contour one way and pushing each sample on that is too near to the one before gives spacings that are
    long enough, and so does going the other way; the mean of both is taken, which favors neither. Samples that are
    too far apart are pulled together likewise, which makes no spacing too short.

    Args:
        local: (S,) mm along their contours.
        loop: (S,) contour of each.
        start: (M + 1,) where the samples of each contour start.
        length: (M,) mm.
        least: λ, mm.
    """
    count = np.diff(start)
    gap = gaps(local, start, length)
    mean = length / np.maximum(count, 1)
    fits = (mean > least) & (mean < 2 * least)
    low, high = least * (1 + INSIDE), 2 * least * (1 - INSIDE)
    for wrong, bound, sign in (
        (gap < low, np.minimum(low, (least + mean) / 2), 1.0),
        (gap > high, np.maximum(high, (2 * least + mean) / 2), -1.0),
    ):
        amiss = np.zeros(len(count), dtype=bool)
        amiss[loop[wrong]] = True
        amiss &= fits
        some = ranges(start[:-1][amiss], count[amiss])
        if len(some):
            local = local.copy()
            local[some] = _spread(local.take(some), count[amiss], length[amiss], bound[amiss], sign)
    return local


def _spread(local: FloatArray, count: IntArray, length: FloatArray, bound: FloatArray, sign: float) -> FloatArray:
    """The samples of a few contours, moved so that spacings are at least `bound`, or at most where `sign` is -1."""
    number = np.arange(len(count))
    owner = np.repeat(number, count)
    first = starts(count)[:-1]
    # Contours lie apart, so that no sample is pushed by those of another; on each, samples are a `bound` apart.
    usual = sign * bound
    apart = (8 * float(length.max()) * number + usual * first).take(owner)
    apart -= np.arange(len(local)) * usual.take(owner)
    place = sign * local + apart
    onward = np.maximum.accumulate(place)
    back = np.minimum.accumulate(place[::-1])[::-1]
    # What goes on over a contour's beginning has this much more room there.
    spare = sign * (length - count * bound)
    onward = np.maximum(onward, (onward[first + count - 1] - spare).take(owner))
    onward += np.minimum(back, (back[first] + spare).take(owner))
    onward /= 2
    onward -= apart
    onward *= sign
    return onward
