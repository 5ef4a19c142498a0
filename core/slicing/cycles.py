"""Permutations taken apart into cycles: walks from ruler to ruler, then pointer jumping over the few rulers."""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, IntArray

_MANY = 1 << 14
_SCATTER = 0x9E3779B1  # odd, with bits all over, so that rulers do not follow the layers and faces


def cycles(successor: IntArray) -> tuple[IntArray, IntArray]:
    """Take a permutation apart into its cycles.

    Args:
        successor: (S,) a permutation.

    Returns:
        (S,) the least member of each one's cycle, and (S,) how many steps after that member it comes.
    """
    count = len(successor)
    index = np.arange(count)
    if count < _MANY:
        root, rank, _ = _jumped(successor, index, np.ones(count, dtype=np.int64))
        return root, rank
    ruler, offset, following, least, length = _walks(successor, ((index * _SCATTER) & 0xFFFFFFFF) < 1 << 28)
    first, before, size = _jumped(following, least, length)
    root = least[first][ruler]
    rank = before[ruler] + offset - offset[root]
    rank += np.where(rank < 0, size[ruler], 0)
    rest = np.flatnonzero(ruler < 0)
    if len(rest):  # cycles without a ruler are short
        index[rest] = np.arange(len(rest))
        rest_root, rank[rest], _ = _jumped(index[successor[rest]], np.arange(len(rest)), np.ones_like(rest))
        root[rest] = rest[rest_root]
    return root, rank


def _walks(successor: IntArray, is_ruler: BoolArray) -> tuple[IntArray, ...]:
    """From each of R rulers, one in sixteen of S, to the next one, all at once.

    Returns:
        (S,) the ruler before each member, -1 in cycles without, and (S,) how many steps it comes after it; of each
        ruler (R,) the one that follows, the least member on the way there and the number of steps.
    """
    rulers = np.flatnonzero(is_ruler)
    ruler, offset = np.full(len(successor), -1), np.zeros(len(successor), dtype=np.int64)
    ruler[rulers] = np.arange(len(rulers))
    following, length, least = np.empty_like(rulers), np.empty_like(rulers), rulers.copy()
    walker, at, steps = ruler[rulers], successor[rulers], 1
    while len(walker):
        arrived = is_ruler[at]
        there = walker[arrived]
        following[there], length[there] = ruler[at[arrived]], steps
        walker, at = walker[~arrived], at[~arrived]
        ruler[at], offset[at] = walker, steps
        least[walker] = np.minimum(least[walker], at)
        at, steps = successor[at], steps + 1
    return ruler, offset, following, least, length


def _jumped(successor: IntArray, value: IntArray, length: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Of N members of cycles: the one of least value in the cycle, how far each comes after it, how long the cycle is.

    Args:
        successor: (N,) a permutation.
        value: (N,) no two alike.
        length: (N,) of the steps to the successors.
    """
    low, jump = value, successor
    while True:
        # Once twice as far ahead nothing less is found, all of the cycle has been looked at.
        ahead = np.minimum(low, low[jump])
        if np.array_equal(ahead, low):
            break
        low, jump = ahead, jump[jump]
    is_first = low == value
    steps = np.where(is_first, 0, length)
    first = np.where(is_first, np.arange(len(low)), successor)
    while not is_first[first].all():
        steps = steps + steps[first]
        first = first[first]
    size = np.bincount(first, length, len(low)).astype(np.int64)[first]
    return first, np.where(is_first, 0, size - steps), size
