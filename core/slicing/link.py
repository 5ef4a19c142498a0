"""Segments → closed loops, by pointer jumping over all layers at once."""

from __future__ import annotations

import numpy as np

from ..model import IntArray
from .cycles import cycles
from .gaps import close_chains
from .intersect import Segments
from .outlines import Outlines, starts


def link(segments: Segments, gap_closing_radius: float) -> tuple[Outlines, IntArray]:
    """Join segments that meet on the same mesh edge into closed loops, ordered by layer.

    Args:
        segments: of all layers.
        gap_closing_radius: mm; open chains whose ends lie within twice this are closed.

    Returns:
        The loops, and (K,) the layers in which an open chain had to be left out.
    """
    successor = _successors(segments)
    open_layers = np.zeros(0, dtype=np.int64)
    if (successor < 0).any():
        closed = close_chains(segments, successor, 2 * gap_closing_radius)
        segments, successor, open_layers = closed.segments, closed.successor, closed.open_layers
    root, rank = cycles(successor)
    return _in_order(segments, root, rank), open_layers


def _successors(segments: Segments) -> IntArray:
    """(S,) the segment that goes on where each one ends, -1 where none does."""
    edges = int(max(segments.tail.max(initial=0), segments.head.max(initial=0))) + 1
    tail, head = segments.layer * edges + segments.tail, segments.layer * edges + segments.head
    by_tail, by_head = np.argsort(tail, kind="stable"), np.argsort(head, kind="stable")
    tails, heads = tail[by_tail], head[by_head]
    successor = np.full(len(tail), -1, dtype=np.int64)
    if np.array_equal(tails, heads):
        successor[by_head] = by_tail
        return successor
    # Somewhere an edge has more segments that end than that start, or the other way round: pair the k-th with the
    # k-th and leave the rest open.
    where = np.searchsorted(tails, heads) + _rank_in_group(heads)
    valid = where < len(tails)
    valid[valid] = tails[where[valid]] == heads[valid]
    successor[by_head[valid]] = by_tail[where[valid]]
    return successor


def _rank_in_group(ordered: IntArray) -> IntArray:
    index = np.arange(len(ordered))
    first = np.concatenate([[True], ordered[1:] != ordered[:-1]]) if len(ordered) else np.zeros(0, dtype=bool)
    return np.asarray(index - np.maximum.accumulate(np.where(first, index, 0)))


def _in_order(segments: Segments, root: IntArray, rank: IntArray) -> Outlines:
    roots, loop = np.unique(root, return_inverse=True)
    by_layer = np.argsort(segments.layer[roots], kind="stable")
    place = np.empty(len(roots), dtype=np.int64)
    place[by_layer] = np.arange(len(roots))
    loop = place[loop]
    count = np.bincount(loop, minlength=len(roots))
    start = starts(count)
    order = np.empty(len(root), dtype=np.int64)
    order[start[loop] + rank] = np.arange(len(root))
    return Outlines(
        segments.points[order, 0], start, segments.layer[roots][by_layer], segments.face[order], segments.carried[order]
    )
