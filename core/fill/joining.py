"""Joins the spans of a hatch in zigzag, so that a region is filled by few long lines instead of many short ones.

Two neighboring crossings on the boundary of a region, one on line k and the next on line k + 1, are joined by a
straight link if the boundary between them runs close to it, or else along the boundary. The links between lines k and
k + 1 are made at the greater x for an even k and at the lesser x for an odd one. So each end of a span has one link at
most, a chain of spans climbs line by line, and all regions are joined at once, without a search.
"""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..records import dataclass
from .arcs import Arcs, arcs, strays
from .hatch import Crossings, Spans


@dataclass(frozen=True)
class LinkLimits:
    """Which links are made, by region. N regions.

    Attributes:
        closeness_mm: how far the boundary may stray from a straight link.
        straight_mm: (N,) greatest shift of a straight link along the scan lines.
        boundary_mm: (N,) greatest length of a link along the boundary, 0 for none.
    """

    closeness_mm: float
    straight_mm: FloatArray
    boundary_mm: FloatArray


@dataclass(frozen=True)
class _Links:
    """Links between spans of neighboring lines: from span `lower` along the arc of crossing `arc` to span `upper`."""

    lower: IntArray
    upper: IntArray
    arc: IntArray
    forwards: BoolArray
    straight: BoolArray


def joined(
    cut: Crossings, found: Spans, keep: BoolArray, trim_mm: FloatArray, limits: LinkLimits
) -> tuple[FloatArray, IntArray, IntArray]:
    """Join the spans of every region.

    Args:
        cut: the crossings of scan lines and boundaries.
        found: (S,) the spans between them.
        keep: (S,) bool, the spans to print.
        trim_mm: (N,) by region, what is taken off both ends of a span that meets the boundary square, but a quarter of
            the span at most.
        limits: which links are made.

    Returns:
        (P, 2) points in each region's own frame of scan lines; (C + 1,) where each chain's points start; (C,) region
        of each chain.
    """
    along = arcs(cut)
    links = _links(cut, along, found, keep, limits)
    span, starts = _climbed(links, np.flatnonzero(keep), cut.line[found.left])
    place = np.full(len(found.left), -1, dtype=np.int64)
    place[span] = np.arange(len(span))

    ends = _ends(cut, found, span, _trims(cut, along, links, trim_mm))
    vertex, owner, rank = _followed(cut, along, links)
    at = np.concatenate([np.repeat(np.arange(len(span)), 2), place[owner]])
    order = np.lexsort((np.concatenate([np.tile([-2, -1], len(span)), rank]), at))
    points = np.concatenate([ends, cut.vertices.take(vertex, axis=0)]).take(order, axis=0)
    first = np.searchsorted(at[order], np.flatnonzero(starts))
    return points, np.append(first, len(points)).astype(np.int64), cut.region[found.left[span[starts]]]


def _links(cut: Crossings, along: Arcs, found: Spans, keep: BoolArray, limits: LinkLimits) -> _Links:
    """All links that the limits allow between kept spans (S,) of neighboring lines."""
    span_of = np.full(len(cut.x), -1, dtype=np.int64)
    span_of[found.left[keep]] = span_of[found.right[keep]] = np.flatnonzero(keep)
    at_right = np.zeros(len(cut.x), dtype=bool)
    at_right[found.right] = True

    end = along.end
    climb = cut.line[end] - cut.line
    linked = (np.abs(climb) == 1) & (span_of >= 0) & (span_of[end] >= 0)
    linked &= (at_right == at_right[end]) & (at_right == (np.minimum(cut.line, cut.line[end]) % 2 == 0))
    straight = linked & (np.abs(cut.x[end] - cut.x) <= limits.straight_mm[cut.region])
    straight &= ~strays(cut, along, straight, limits.closeness_mm)
    linked &= straight | (along.length <= limits.boundary_mm[cut.region])

    arc = np.flatnonzero(linked)
    forwards = climb[arc] > 0
    here, there = span_of[arc], span_of[end[arc]]
    return _Links(np.where(forwards, here, there), np.where(forwards, there, here), arc, forwards, straight[arc])


def _climbed(links: _Links, kept: IntArray, line: IntArray) -> tuple[IntArray, BoolArray]:
    """The kept spans chain by chain from the lowest up, and which of them starts a chain."""
    root = np.arange(len(line))
    root[links.upper] = links.lower
    while True:
        jumped = root[root]  # pointer doubling: each round halves what is left of the way down
        if np.array_equal(jumped, root):
            break
        root = jumped
    order = kept[np.lexsort((line[kept], root[kept]))]
    starts = np.ones(len(order), dtype=bool)
    starts[1:] = root[order[1:]] != root[order[:-1]]
    return order, starts


def _trims(cut: Crossings, along: Arcs, links: _Links, trim_mm: FloatArray) -> FloatArray:
    """(X,) mm that spans end before each crossing.

    A straight link beside a slanting boundary is longer, so its spans end as much earlier: then it lies as far from the
    boundary as from one that is met square, and the lines take no more than the area that they fill.
    """
    trim: FloatArray = trim_mm[cut.region]
    begin = links.arc[links.straight]
    end = along.end[begin]
    shift = cut.places[end] - cut.places[begin]
    slant = np.hypot(1.0, shift[:, 0] / shift[:, 1])
    trim[begin] *= slant
    trim[end] *= slant
    return trim


def _ends(cut: Crossings, found: Spans, span: IntArray, trim: FloatArray) -> FloatArray:
    """(2S, 2) both ends of each span as it is printed: to the right on even lines, back on odd ones."""
    left, right = found.left[span], found.right[span]
    most = 0.25 * (cut.x[right] - cut.x[left])
    x = np.stack([cut.x[left] + np.minimum(trim[left], most), cut.x[right] - np.minimum(trim[right], most)], axis=1)
    odd = cut.line[left] % 2 == 1
    x[odd] = x[odd, ::-1]
    return np.stack([x.ravel(), np.repeat(cut.places[left, 1], 2)], axis=1)


def _followed(cut: Crossings, along: Arcs, links: _Links) -> tuple[IntArray, IntArray, IntArray]:
    """Vertices of the links along the boundary, the span after which each is printed, and its rank in that link."""
    link_of_arc = np.full(len(cut.x), -1, dtype=np.int64)
    bent = np.flatnonzero(~links.straight)
    link_of_arc[links.arc[bent]] = bent
    vertex = np.flatnonzero(along.of_vertex >= 0)
    link = link_of_arc[along.of_vertex[vertex]]
    vertex, link = vertex[link >= 0], link[link >= 0]
    # Counted from the arc's start, so that an arc over the end of its ring's vertices keeps its order.
    rank = vertex - cut.edge[links.arc[link]] - 1
    rank[rank < 0] += len(cut.vertices)
    rank = np.where(links.forwards[link], rank, 2 * len(cut.vertices) - rank)
    return vertex, links.lower[link], rank
