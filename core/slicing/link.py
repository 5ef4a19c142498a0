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
    successor = by_neighbours(segments)
    return by_sorting(segments) if successor is None else successor


def by_sorting(segments: Segments) -> IntArray:
    """(S,) the segment that starts on the edge where each one ends, the k-th of several; -1 where none does."""
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


def by_neighbours(segments: Segments) -> IntArray | None:
    """As `by_sorting` where each edge that is cut parts two faces turned alike, else None; without any sorting.

    The faces that an edge parts are cut by the same layers, and the cuts of a face stand one after the other: the cut
    that goes on is found by the face beyond the edge and the layer.
    """
    count = len(segments.face)
    if not count:
        return None
    beyond = np.zeros(int(max(segments.tail.max(), segments.head.max())) + 1, dtype=np.int64)
    beyond[segments.tail] = segments.face
    row = np.flatnonzero(np.diff(segments.face, prepend=-1))
    base = np.zeros(int(segments.face.max()) + 1, dtype=np.int64)  # the row of a face's cut by layer 0, if it had one
    base[segments.face[row]] = row - segments.layer[row]
    successor: IntArray = (base[beyond])[segments.head] + segments.layer
    if successor.min() < 0 or successor.max() >= count or not (segments.tail[successor] == segments.head).all():
        return None
    once = np.bincount(successor, minlength=count).max() == 1
    return successor if once and (segments.layer[successor] == segments.layer).all() else None


def _rank_in_group(ordered: IntArray) -> IntArray:
    index = np.arange(len(ordered))
    first = np.concatenate([[True], ordered[1:] != ordered[:-1]]) if len(ordered) else np.zeros(0, dtype=bool)
    return np.asarray(index - np.maximum.accumulate(np.where(first, index, 0)))


def _in_order(segments: Segments, root: IntArray, rank: IntArray) -> Outlines:
    roots = np.flatnonzero(root == np.arange(len(root)))
    by_layer = np.argsort(segments.layer[roots], kind="stable")
    place = np.empty(len(root), dtype=np.int64)
    place[roots[by_layer]] = np.arange(len(roots))
    loop = place[root]
    count = np.bincount(loop, minlength=len(roots))
    start = starts(count)
    order = np.empty(len(root), dtype=np.int64)
    order[start[loop] + rank] = np.arange(len(root))
    return Outlines(
        segments.points[:, 0].take(order, axis=0),
        start,
        segments.layer[roots][by_layer],
        segments.face[order],
        segments.carried.take(order, axis=0),
    )
