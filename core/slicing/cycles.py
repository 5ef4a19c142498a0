"""Permutations taken apart into cycles: walks from ruler to ruler, then pointer jumping over the few rulers."""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, IntArray

_MANY = 1 << 14
_STRIDE = 4  # steps until those that have arrived are sorted out
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
    is_ruler = ((index * _SCATTER) & 0xFFFFFFFF) < 1 << 28
    ruler, offset, following = _walks(successor, is_ruler)
    length = np.bincount(ruler + 1, minlength=len(following) + 1)[1:]
    least = np.empty(len(following) + 1, dtype=np.int64)  # the last place is for members without a ruler
    least[ruler[::-1]] = index[::-1]  # what is written last stays
    first, before, size = _jumped(following, least[:-1], length)
    root = least[first][ruler]
    rank = before[ruler] + offset - offset[root]
    rank += np.where(rank < 0, size[ruler], 0)
    rest = np.flatnonzero(ruler < 0)
    if len(rest):  # cycles without a ruler are short
        index[rest] = np.arange(len(rest))
        rest_root, rank[rest], _ = _jumped(index[successor[rest]], np.arange(len(rest)), np.ones_like(rest))
        root[rest] = rest[rest_root]
    return root, rank


def _walks(successor: IntArray, is_ruler: BoolArray) -> tuple[IntArray, IntArray, IntArray]:
    """From each of R rulers, one in sixteen of S, to the next one, all at once.

    Returns:
        (S,) the ruler before each member, -1 in cycles without, and (S,) how many steps it comes after it; (R,) the
        ruler that follows each one.
    """
    rulers = np.flatnonzero(is_ruler)
    onwards = successor.copy()
    onwards[rulers] = rulers  # who has arrived stays
    visit = np.full(len(successor), -1)
    arrival = np.empty_like(rulers)
    own = np.arange(len(rulers)) << 32  # the ruler, with the steps in the lower half
    at, mark = successor[rulers], own + 1
    while len(at):
        for _ in range(_STRIDE):
            visit[at] = mark
            at = onwards.take(at)
            mark += 1
        arrived = is_ruler[at]
        arrival[mark[arrived] >> 32] = at[arrived]
        at, mark = at[~arrived], mark[~arrived]
    visit[rulers] = own
    return visit >> 32, visit & 0xFFFFFFFF, visit[arrival] >> 32


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
