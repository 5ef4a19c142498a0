"""Ragged arrays: groups of members one after the other in a flat array, with the offsets at which the groups start.

A group is a loop of points, a polyline, the corners of a polygon. In a closed (cyclic) one the first member follows the
last.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from .model import BoolArray, FloatArray, IntArray

Number = TypeVar("Number", bound=np.generic)

_SUMMABLE = float(1 << 26)  # parts of a millimeter


def starts(count: IntArray | BoolArray) -> IntArray:
    """(M + 1,) offsets of groups with `count` (M,) members each."""
    return np.concatenate([[0], np.cumsum(count)]).astype(np.int64)


def ranges(first: IntArray | int, count: IntArray) -> IntArray:
    """The integers first[k], first[k] + 1, … (count[k] of them) for every k, or all k from one `first` on."""
    offsets = starts(count)
    return np.asarray(np.arange(offsets[-1]) + np.repeat(first - offsets[:-1], count))


def runs(marked: BoolArray) -> list[tuple[int, int]]:
    """The first of each run of members marked (N,), and the one after its last."""
    changes = np.diff(marked.astype(np.int8), prepend=0, append=0)
    return [(first, end) for first, end in np.flatnonzero(changes).reshape(-1, 2).tolist()]


def following(start: IntArray) -> IntArray:
    """(N,) index of the next member in a cyclic group; `start` (M + 1,) are offsets, empty groups allowed."""
    index = np.arange(1, start[-1] + 1, dtype=np.int64)
    filled = start[1:] > start[:-1]
    index[start[1:][filled] - 1] = start[:-1][filled]
    return index


def ahead(values: NDArray[Number], start: IntArray) -> NDArray[Number]:
    """(N, …) the value of the next member in a cyclic group, as `values[following(start)]` but in half the time."""
    moved = np.empty_like(values)
    moved[:-1] = values[1:]
    filled = start[1:] > start[:-1]
    moved[start[1:][filled] - 1] = values[start[:-1][filled]]
    return moved


def preceding(start: IntArray) -> IntArray:
    """(N,) index of the previous member in a cyclic group, the inverse of `following`."""
    index = np.arange(-1, start[-1] - 1, dtype=np.int64)
    filled = start[1:] > start[:-1]
    index[start[:-1][filled]] = start[1:][filled] - 1
    return index


def sums(values: FloatArray, start: IntArray) -> FloatArray:
    """(M,) sum of the values of each group; 0 for an empty one."""
    if len(values) and (np.diff(start) > 0).all():
        return np.add.reduceat(values, start[:-1])
    total = np.concatenate([[0.0], np.cumsum(values)])
    return np.asarray(total[start[1:]] - total[start[:-1]])


def summable(lengths: FloatArray) -> FloatArray:
    """Lengths in mm, rounded in place so that sums of up to 100 km are exact.

    What lies between two places is then the same number whatever lies before them, so that some layers of a print can
    be made anew without the others.
    """
    lengths *= _SUMMABLE
    np.rint(lengths, out=lengths)
    lengths /= _SUMMABLE
    return lengths
