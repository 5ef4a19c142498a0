"""Segments → closed loops, by pointer jumping over all layers at once."""

from __future__ import annotations

import numpy as np

from ..errors import MeshError
from ..model import FloatArray, IntArray
from .intersect import Segments
from .outlines import Outlines, starts


def link(segments: Segments, planes: FloatArray, gap_closing_radius: float) -> Outlines:
    """Join segments that meet on the same mesh edge into closed loops, ordered by layer.

    Args:
        segments: of all layers.
        planes: (L,) mm, for messages.
        gap_closing_radius: mm; open chains whose ends lie within twice this are closed.

    Raises:
        MeshError: the mesh is open: an outline does not close.
    """
    successor = _successors(segments)
    if (successor < 0).any():
        _close_gaps(segments, successor, planes, gap_closing_radius)
    root, rank = cycles(successor)
    return _in_order(segments, root, rank)


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


def _close_gaps(segments: Segments, successor: IntArray, planes: FloatArray, radius: float) -> None:
    """Join open chains, nearest ends first, in place.

    Raises:
        MeshError: a gap is wider than twice `radius`.
    """
    has_predecessor = np.zeros(len(successor), dtype=bool)
    has_predecessor[successor[successor >= 0]] = True
    loose_heads, loose_tails = np.flatnonzero(successor < 0), np.flatnonzero(~has_predecessor)
    for layer in np.unique(segments.layer[loose_heads]):
        heads = loose_heads[segments.layer[loose_heads] == layer]
        tails = loose_tails[segments.layer[loose_tails] == layer]
        gap = np.linalg.norm(segments.points[heads, 1][:, None] - segments.points[tails, 0][None], axis=2)
        for _ in range(len(heads)):
            i, j = np.unravel_index(np.argmin(gap), gap.shape)
            if gap[i, j] > 2 * radius:
                raise MeshError(
                    f"the mesh is open: at {planes[layer]:.2f} mm above the bed an outline does not close",
                    "fill its holes (Edit Mode, Select > All by Trait > Non Manifold, then Face > Fill)",
                )
            successor[heads[i]] = tails[j]
            gap[i, :] = gap[:, j] = np.inf


def cycles(successor: IntArray) -> tuple[IntArray, IntArray]:
    """Take a permutation apart into its cycles.

    Args:
        successor: (S,) a permutation.

    Returns:
        (S,) the least member of each one's cycle, and (S,) how many steps after that member it comes.
    """
    root = np.arange(len(successor))
    jump = successor
    while not np.array_equal(root[successor], root):
        root = np.minimum(root, root[jump])
        jump = jump[jump]
    is_root = root == np.arange(len(root))
    steps = np.where(is_root, 0, 1)
    jump = np.where(is_root, root, successor)
    while steps.size and (jump != root).any():
        steps = steps + steps[jump]
        jump = jump[jump]
    size = np.bincount(root, minlength=len(root))[root]
    return root, np.where(is_root, 0, size - steps)


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
