"""Connected components of a graph."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from ..model import IntArray
from ..parallel import CHUNK_ROWS


def components(groups: IntArray) -> IntArray:
    """Connected components, where the nodes of a group are connected.

    Args:
        groups: (G, k) nodes from 0 on; k nodes in each group.

    Returns:
        (G,) the root of each group's component: one of its nodes, the same for all of its groups.
    """
    return np.asarray(_roots(groups, int(groups.max(initial=-1)) + 1).take(groups[:, 0]))


def connected(count: int, first: IntArray, second: IntArray) -> IntArray:
    """(count,) number of each node's component, from 0 on, where edges lead from nodes (E,) to nodes (E,)."""
    every = np.arange(count)
    pairs = np.stack([np.append(every, first), np.append(every, second)], axis=1)
    return numbered(components(pairs)[:count])


def _roots(groups: IntArray, count: int) -> IntArray:
    """(count,) the root of each node, where groups (G, k) are linked.

    Union-find for all links at once: every node is hooked to a linked node of a lesser number, and every path is
    flattened to its root. Then the trees become the nodes, numbered in reverse, and so on. The reversal matters for a
    node with many links to greater numbers only, or to lesser ones only: hooking one way resolves one of them a round,
    hooking the other way all of them.
    """
    parent = np.arange(count)
    for one, other in _links(groups):
        parent[np.maximum(one, other)] = np.minimum(one, other)
    parent = _flattened(parent)
    links = []
    for one, other in _links(groups):
        one, other = parent.take(one), parent.take(other)
        apart = np.flatnonzero(one != other)
        links.append(np.stack([one.take(apart), other.take(apart)], axis=1))
    between = np.concatenate([*links, groups[:0, :2]])
    if not len(between):
        return parent
    tree = np.cumsum((parent == np.arange(count))[::-1])[::-1] - 1
    above = _roots(tree.take(between), int(tree[0]) + 1)
    return np.asarray(above.take(tree.take(parent)))


def _links(groups: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Both ends of links from each node of a group to the next one, so many at a time that they stay in the cache."""
    for begin in range(0, len(groups), CHUNK_ROWS):
        yield from pairwise(np.ascontiguousarray(groups[begin : begin + CHUNK_ROWS].T))


def numbered(root: IntArray) -> IntArray:
    """(G,) roots renumbered from 0, in increasing order."""
    is_root = np.zeros(root.max(initial=-1) + 1, dtype=bool)
    is_root[root] = True
    return np.asarray((np.cumsum(is_root) - 1).take(root))


def _flattened(parent: IntArray) -> IntArray:
    """Every node's root."""
    while True:
        above = parent.take(parent)
        if np.array_equal(above, parent):
            return parent
        parent = above
