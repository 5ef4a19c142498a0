"""Removes crossings of loops: cut where they cross and joined the other way, as winding numbers allow."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray, IntArray
from ..ragged import following, ranges, starts
from .cycles import cycles
from .outlines import Outlines, interpolated

_OBLIQUE = np.array([1.0, 0.6180339887])  # along it hardly any two segments of straight walls lie side by side
_MOST_PAIRS = 256  # for each segment; where more have to be looked at, GEOS is faster
_PAIRS_AT_ONCE = 1 << 18


def uncrossed(outlines: Outlines) -> tuple[Outlines, IntArray]:
    """Where two lines cross, let each continue along the other; lines and directions stay as they are.

    So the winding number of every place stays as it was. Loops that only touch or lie on one another are left, and
    rounding may make new crossings: whoever needs loops without any has to look again.

    Args:
        outlines: loops of some layers.

    Returns:
        The loops, and the layers in which some touch or lie on one another.
    """
    segment, share, place, touching = _crossings(outlines)
    count, nodes = len(outlines.points), len(segment)
    if not nodes:
        return outlines, touching
    # Each crossing makes two nodes, one on either segment; they come after the points, and the second ones last.
    source, begin = np.concatenate([np.arange(count), segment]), np.concatenate([np.zeros(count), share])
    loop = outlines.loop[source]
    along = np.lexsort((begin, source))
    parted = np.flatnonzero(source[along][1:] == source[along][:-1])
    end = np.ones(len(source))
    end[along[parted]] = begin[along[parted + 1]]
    successor = np.empty_like(source)
    successor[along] = along[following(starts(np.bincount(loop, minlength=len(outlines.layer))))]
    other_way = np.concatenate([np.arange(count), count + np.roll(np.arange(nodes), nodes // 2)])
    order, start = cycles(other_way[successor], outlines.layer[loop])
    points = np.concatenate([outlines.points, place, place])[order]
    layer = outlines.layer[loop[order[start[:-1]]]]
    source, begin, end = source[order], begin[order], end[order]
    carried = outlines.carried[source]
    pieces = np.flatnonzero((begin > 0) | (end < 1))
    ends = [interpolated(carried[pieces], at[pieces]) for at in (begin, end)]
    carried[pieces] = np.stack(ends, axis=1)
    return Outlines(points, start, layer, outlines.face[source], carried), touching


def _crossings(outlines: Outlines) -> tuple[IntArray, FloatArray, FloatArray, IntArray]:
    """Where the insides of two segments of a layer cross: K places.

    Returns:
        (2K,) segments, the first of each crossing's two, then the second of each; (2K,) the share of each segment's
        length at which it is crossed; (K, 2) mm, the places; and the layers in which an end of one segment lies on
        another one.
    """
    tails, heads = outlines.points, outlines.ends
    first, second = _near_pairs(tails, heads, outlines.layer[outlines.loop])
    onwards = outlines.following
    apart = np.flatnonzero((onwards.take(first) != second) & (onwards.take(second) != first))  # the others touch
    first, second = first.take(apart), second.take(apart)
    a, b, c, d = tails[first], heads[first], tails[second], heads[second]
    # On which side of each segment's line the ends of the other one lie.
    before, after = _cross(b - a, c - a), _cross(b - a, d - a)
    below, above = _cross(d - c, a - c), _cross(d - c, b - c)
    through, across = before * after, below * above
    crossing = np.flatnonzero((through < 0) & (across < 0))
    meeting = np.flatnonzero((through <= 0) & (across <= 0) & ((through == 0) | (across == 0)))
    touching = np.unique(outlines.layer[outlines.loop[first[meeting]]])
    first, second, a, b = first[crossing], second[crossing], a[crossing], b[crossing]
    before, after, below, above = (side[crossing] for side in (before, after, below, above))
    share = below / (below - above)
    place = a + share[:, None] * (b - a)
    return np.concatenate([first, second]), np.concatenate([share, before / (before - after)]), place, touching


def _cross(one: FloatArray, other: FloatArray) -> FloatArray:
    """(N,) cross products of vectors (N, 2): above 0 where `other` is to the left of `one`."""
    return np.asarray(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])


def _near_pairs(tails: FloatArray, heads: FloatArray, layer: IntArray) -> tuple[IntArray, IntArray]:
    """Pairs of segments of one layer whose oblique bounding boxes meet; none at all where there are too many."""
    axes = [_OBLIQUE, _OBLIQUE[::-1] * [-1, 1]]
    (low, high), (left, right) = (
        (np.minimum(one, other), np.maximum(one, other))
        for one, other in ((np.einsum("ij,j->i", ends, axis) for ends in (tails, heads)) for axis in axes)
    )
    pitch = layer * (np.ptp(np.append(low, high)) + 1) if len(layer) else layer
    low, high = low + pitch, high + pitch
    order = np.argsort(low)
    low, high, left, right = (bound.take(order) for bound in (low, high, left, right))
    count = np.searchsorted(low, high, side="right") - np.arange(1, len(order) + 1)
    if count.sum() > _MOST_PAIRS * len(count):
        count[:] = 0
    found = [np.zeros((2, 0), dtype=np.int64)]
    for part in np.split(np.arange(len(count)), np.flatnonzero(np.diff(np.cumsum(count) // _PAIRS_AT_ONCE)) + 1):
        one, other = np.repeat(part, count[part]), ranges(part + 1, count[part])
        meets = np.flatnonzero((left.take(one) <= right.take(other)) & (left.take(other) <= right.take(one)))
        found.append(order.take([one.take(meets), other.take(meets)]))
    first, second = np.concatenate(found, axis=1)
    return first, second
