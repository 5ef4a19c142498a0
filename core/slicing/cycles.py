"""The cycles of a permutation, found for all cycles at once by list ranking with a ruling set.

A sixteenth of the members are rulers. From every ruler one walks to the next one, all walks in step. Then only the
rulers are left to be ranked, by pointer jumping: each looks twice as far ahead in every round.
"""

from __future__ import annotations

import numpy as np

from ..model import IntArray
from ..ragged import starts
from ..records import dataclass

_MANY = 1 << 14
_STRIDE = 8  # steps until those that have arrived are sorted out
_APART = 16  # from ruler to ruler, as a rule
_SCATTER = 0x9E3779B1  # odd, with bits all over, so that rulers do not follow the layers and faces


@dataclass(frozen=True)
class _Walks:
    """R walks along the permutation, each from one ruler to the next.

    Attributes:
        ruler: (R,) the member at which each walk begins.
        following: (R,) the walk that begins where each one ends.
        length: (R,) steps.
        least: (R,) the least member that each passes, its ruler included.
        strides: a pair for each eight steps: (n,) the walks that have not ended before them, and (8, n) the members
            that these pass, step by step; numbers from S on once a walk has ended.
    """

    ruler: IntArray
    following: IntArray
    length: IntArray
    least: IntArray
    strides: list[tuple[IntArray, IntArray]]


def cycles(successor: IntArray, layer: IntArray) -> tuple[IntArray, IntArray]:
    """Take a permutation apart into its cycles.

    Args:
        successor: (S,) a permutation.
        layer: (S,) one number for all members of a cycle.

    Returns:
        (S,) the members cycle by cycle, each cycle from its least member on, and (M + 1,) where each of M cycles
        starts. Cycles are ordered by layer, those of a layer by their least members.
    """
    count = len(successor)
    walks = _walks(successor, _rulers(count))
    first, before, size = _jumped(walks.following, walks.least, walks.length)
    chief = np.flatnonzero(first == np.arange(len(first)))
    chief = chief[np.lexsort((walks.least[chief], layer[walks.least[chief]]))]
    start = starts(size[chief])
    # A cycle begins within the walk that passes its least member; what is passed before comes last.
    late, begin = _steps_to_least(walks, chief), np.empty_like(first)
    begin[chief] = start[:-1]
    place = begin[first] + before - late[first]
    order = np.empty(count + 1, dtype=np.int64)  # with a dummy place at the end
    for number, (walker, members) in enumerate(walks.strides):
        step = _STRIDE * number + 1 + np.arange(_STRIDE)[:, None]
        at = place.take(walker) + step
        some = np.flatnonzero(late.take(walker))
        at[:, some] += np.where(step < late[walker[some]], size[walker[some]], 0)
        np.copyto(at, count, where=members >= count)
        order[at] = members
    order[place + np.where(late > 0, size, 0)] = walks.ruler
    return order[:count], start


def _rulers(count: int) -> IntArray:
    """(R,) members to be rulers: one of each sixteen in a row, scattered; all members if there are few."""
    if count < _MANY:
        return np.arange(count, dtype=np.int64)
    number = np.arange(count // _APART, dtype=np.int64)
    return _APART * number + (((number * _SCATTER) & 0xFFFFFFFF) >> 28)


def _walks(successor: IntArray, ruler: IntArray) -> _Walks:
    """Walk from each ruler to the next one, all at once; members of cycles without a ruler become rulers too."""
    count = len(successor)
    name = np.arange(count, dtype=np.int64)
    name[ruler] = count + np.arange(len(ruler))
    onwards = np.concatenate([name.take(successor), name[ruler]])  # who has arrived stays
    following, length, least = np.empty_like(ruler), np.ones_like(ruler), ruler.copy()
    walker, at, strides = np.arange(len(ruler)), onwards[ruler], []
    while len(walker):
        members = np.empty((_STRIDE + 1, len(at)), dtype=np.int64)
        members[0] = at
        for step in range(_STRIDE):
            onwards.take(members[step], out=members[step + 1], mode="clip")
        passed, at = members[:-1], members[-1]
        strides.append((walker, passed))
        least[walker] = np.minimum(least[walker], passed.min(axis=0))
        length[walker] += (passed < count).sum(axis=0)
        there, on = np.flatnonzero(at >= count), np.flatnonzero(at < count)  # indices: masks take three times as long
        following[walker.take(there)] = at.take(there) - count
        walker, at = walker.take(on), at.take(on)
    if length.sum() == count:
        return _Walks(ruler, following, length, least, strides)
    alone = np.ones(count + len(ruler), dtype=bool)
    for _, passed in strides:
        alone[passed] = False
    alone[ruler], alone[count:] = False, False
    rest = np.flatnonzero(alone)
    alone_following = len(ruler) + np.searchsorted(rest, successor[rest])
    return _Walks(
        np.append(ruler, rest),
        np.append(following, alone_following),
        np.append(length, np.ones_like(rest)),
        np.append(least, rest),
        strides,
    )


def _steps_to_least(walks: _Walks, chief: IntArray) -> IntArray:
    """(R,) the step at which each of the walks `chief` passes its least member; 0 for all other walks."""
    steps = np.zeros_like(walks.ruler)
    wanted = np.full_like(walks.ruler, -1)
    wanted[chief] = walks.least[chief]
    wanted[wanted == walks.ruler] = -1
    for number, (walker, members) in enumerate(walks.strides):
        some = np.flatnonzero(wanted.take(walker) >= 0)
        step, column = np.nonzero(members[:, some] == wanted[walker[some]])
        steps[walker[some[column]]] = _STRIDE * number + 1 + step
    return steps


def _jumped(successor: IntArray, value: IntArray, length: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Rank the members of all cycles of a permutation by pointer jumping.

    Args:
        successor: (N,) a permutation.
        value: (N,) distinct numbers; the least of each cycle marks its first member.
        length: (N,) of the step from each member to its successor.

    Returns:
        (N,) the first member of each one's cycle, (N,) the length from there to each, and (N,) the cycle's length.
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
