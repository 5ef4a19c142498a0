"""Closes small gaps: open chains of segments, as holes, cracks and flipped faces leave them, become outlines."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely

from ..model import FloatArray, IntArray
from .cycles import cycles
from .intersect import Segments


def close_chains(segments: Segments, reach: float) -> tuple[Segments, IntArray]:
    """Join chains at ends that are near each other, nearest first, whichever way they run; leave out the rest.

    Every segment is there in both directions: number s runs as it was cut, number s + S backwards. So every chain has
    a mirror image. A loose end without a partner is joined to its own image: the chain and its image become one cycle,
    which shows that it is open, for a closed outline and its image are two.

    Args:
        segments: S of all layers.
        reach: mm, the widest gap that is closed.

    Returns:
        The segments of closed outlines, some turned round, and (K,) the layers in which a chain had to be left out,
        increasing.
    """
    count = len(segments.successor)
    points = segments.points
    going_on = _both_ways(segments.successor)
    heads = np.flatnonzero(segments.successor < 0)
    tails = np.flatnonzero(going_on[count:] < 0)
    # A loose end is the state that arrives there: heads forwards, tails backwards.
    ends = np.concatenate([heads, tails + count])
    places = np.concatenate([points[heads, 1], points[tails, 0]])
    partner = _nearest_pairs(places, segments.layer[ends % count], reach)
    mirrored = (ends + count) % (2 * count)
    going_on[ends] = np.where(partner >= 0, mirrored[partner], mirrored)
    return _one_way(segments, going_on, np.linalg.norm(points[:, 1] - points[:, 0], axis=1))


def _both_ways(successor: IntArray) -> IntArray:
    """(2S,) successors of the segments as they were cut, then of those that run backwards; -1 at loose ends."""
    count = len(successor)
    both = np.full(2 * count, -1, dtype=np.int64)
    both[:count] = successor
    linked = np.flatnonzero(successor >= 0)
    both[successor[linked] + count] = linked + count
    return both


def _nearest_pairs(points: FloatArray, layer: IntArray, reach: float) -> IntArray:
    """(E,) the loose end of the same layer that each is joined to, the nearest pairs first; -1 for none."""
    partner = np.full(len(points), -1, dtype=np.int64)
    # Layers side by side, too far apart to meet: one tree for all.
    pitch = float(np.ptp(points[:, 0])) + 4 * reach + 1 if len(points) else 1.0
    placed = shapely.points(points + np.stack([layer * pitch, np.zeros(len(layer))], axis=1))
    a, b = shapely.STRtree(placed).query(placed, predicate="dwithin", distance=reach)
    a, b = a[a < b], b[a < b]
    order = np.lexsort((b, a, np.linalg.norm(points[a] - points[b], axis=1)))
    a, b = a[order], b[order]
    while len(a):
        rank = np.arange(len(a))
        best = np.full(len(points), len(a))
        np.minimum.at(best, a, rank)
        np.minimum.at(best, b, rank)
        joined = (best[a] == rank) & (best[b] == rank)
        partner[a[joined]], partner[b[joined]] = b[joined], a[joined]
        free = (partner[a] < 0) & (partner[b] < 0)
        a, b = a[free], b[free]
    return partner


def _one_way(segments: Segments, going_on: IntArray, length: FloatArray) -> tuple[Segments, IntArray]:
    """Of each outline and its mirror image the one along which more mm of the segments (S,) run as they were cut."""
    count = len(going_on) // 2
    order, start = cycles(going_on, np.tile(segments.layer, 2))
    root = np.empty_like(order)
    root[order] = np.repeat(order[start[:-1]], np.diff(start))
    mirror_root = np.concatenate([root[count:], root[:count]])
    is_open = root == mirror_root
    forwards = np.bincount(root[:count], weights=length, minlength=2 * count)
    better = (forwards[root] > forwards[mirror_root]) | (
        (forwards[root] == forwards[mirror_root]) & (root < mirror_root)
    )
    kept = np.flatnonzero(~is_open & better)
    place = np.full(2 * count, -1, dtype=np.int64)
    place[kept] = np.arange(len(kept))
    tail = np.concatenate([segments.tail, segments.tail ^ 1])[kept]
    chosen = replace(segments, layer=segments.layer[kept % count], tail=tail, successor=place[going_on[kept]])
    return chosen, np.unique(segments.layer[is_open[:count]])
