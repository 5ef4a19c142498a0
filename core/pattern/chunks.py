"""Run numpy over parts of long arrays in threads: it releases the interpreter lock, and a part stays in the cache."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..model import IntArray

CHUNK_ROWS = 1 << 14

Part = TypeVar("Part")
Result = TypeVar("Result")


def in_chunks(
    function: Callable[..., tuple[NDArray[Any], ...]],
    *columns: NDArray[Any],
    rows: int = CHUNK_ROWS,
    threads: bool = True,
) -> tuple[NDArray[Any], ...]:
    """Apply a function to equal slices of several arrays in threads and put its results together again.

    Args:
        function: from slices of the columns to a tuple of arrays, whose rows must not depend on other slices.
        columns: arrays of one length.
        rows: of a slice, at most about this many.
        threads: False where other work goes on beside this, whose threads would only wait for each other.

    Returns:
        The tuple that `function(*columns)` would have given.
    """
    parts = -(-len(columns[0]) // rows)
    if parts <= 1:
        return function(*columns)
    pieces = zip(*(np.array_split(column, parts) for column in columns), strict=True)
    results = in_threads(lambda piece: function(*piece), pieces) if threads else [function(*each) for each in pieces]
    return tuple(np.concatenate(part) for part in zip(*results, strict=True))


def runs_of_layers(layer: IntArray, start: IntArray, at_once: int) -> Iterable[tuple[int, int]]:
    """First and last loop of whole layers that are worked on at once.

    Args:
        layer: (M,) of each loop, not decreasing.
        start: (M + 1,) how much there is before each loop.
        at_once: about so much, or one layer.
    """
    begins = np.flatnonzero(np.diff(layer, prepend=-1))
    cuts = begins[np.diff(start[begins] // at_once, prepend=-1) > 0]
    return pairwise([*cuts.tolist(), len(layer)])


def in_threads(function: Callable[[Part], Result], parts: Iterable[Part]) -> list[Result]:
    """Apply a function to every part, several at a time; the results in the order of the parts."""
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        return list(pool.map(function, parts))
