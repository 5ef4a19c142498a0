"""Connected components: which things hang together."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ..model import IntArray


def components(groups: IntArray) -> IntArray:
    """Connected components of nodes that occur together: of groups (G, k) of node numbers, each group's root (G,)."""
    columns = [np.ascontiguousarray(column) for column in groups.T]
    return np.asarray(_roots(columns, int(groups.max(initial=-1)) + 1).take(columns[0]))


def _roots(columns: list[IntArray], count: int) -> IntArray:
    """(count,) alike for nodes that are connected by links from each of some columns (K,) to the next one.

    Every node is hooked to one that it is linked to and that has a lesser number, and all paths are halved. Then the
    trees are nodes themselves, numbered the other way round: a node that has many linked to it, all of them greater
    or all of them less, does no more than one link a round in one of the two ways, but all of them in the other.
    """
    parent = np.arange(count)
    for one, other in pairwise(columns):
        parent[np.maximum(one, other)] = np.minimum(one, other)
    parent = _flattened(parent)
    links = []
    for one, other in pairwise([parent.take(column) for column in columns]):
        apart = np.flatnonzero(one != other)
        links.append((one.take(apart), other.take(apart)))
    ends = [np.concatenate(parts) for parts in zip(*links, strict=True)]
    if not len(ends[0]):
        return parent
    tree = np.cumsum((parent == np.arange(count))[::-1])[::-1] - 1
    above = _roots([tree.take(each) for each in ends], int(tree[0]) + 1)
    return np.asarray(above.take(tree.take(parent)))


def numbered(root: IntArray) -> IntArray:
    """Roots (G,) as numbers from 0."""
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
