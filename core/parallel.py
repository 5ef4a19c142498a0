"""Long arrays worked on in parts, in threads: numpy and GEOS release the interpreter lock."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from .model import IntArray, Shapes

CHUNK_ROWS = 1 << 14

_THREADS = os.cpu_count() or 1
_LEAST_SHAPES = 48  # for a thread: below, numpy's calls cost more than what they call

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


def product(one: NDArray[Any], other: NDArray[Any]) -> float:
    """The scalar product of two vectors, in this thread.

    With `@`, BLAS shares out 10,000 numbers and more among threads, which wait for each other longer than this takes.
    """
    return float(np.einsum("i,i", one, other))


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
    with begun(function, parts) as results:
        return results()


@contextmanager
def begun(function: Callable[[Part], Result], parts: Iterable[Part]) -> Iterator[Callable[[], list[Result]]]:
    """Let other threads begin to apply a function to every part, while this one does something else.

    Whoever calls what this gives, for the results in the order of the parts, takes the last parts over. So there are
    no more threads at work than processors, and none that holds the interpreter has to wait for one.
    """
    parts = list(parts)
    with ThreadPoolExecutor(max(_THREADS - 1, 1)) as pool:
        others = [pool.submit(function, part) for part in parts]

        def results() -> list[Result]:
            own = {k: function(parts[k]) for k in reversed(range(len(parts))) if others[k].cancel()}
            return [own[k] if k in own else other.result() for k, other in enumerate(others)]

        yield results


def even_runs(size: IntArray) -> list[slice]:
    """Runs of N rows that are as much work each, two for each thread; none where there are no rows.

    Args:
        size: (N,) how much work each row is.
    """
    count = max(min(2 * _THREADS, len(size) // _LEAST_SHAPES), 1)
    before = np.concatenate([[0], np.cumsum(size)])
    runs = runs_of_layers(np.arange(len(size)), before, int(before[-1]) // count + 1)
    return [slice(*run) for run in runs]


def geos_in_threads(function: Callable[..., tuple[Shapes, ...]], *columns: NDArray[Any]) -> tuple[Shapes, ...]:
    """Apply a function to parts of several arrays in threads and put the results together again.

    With n threads each takes every n-th row, as the layers of one end of a model cost more than those of the other.

    Args:
        function: from parts, (n,) each, to a tuple of (n,) arrays; row i of a result may depend on row i only.
        columns: (N,) arrays of one length.

    Returns:
        The tuple that `function(*columns)` would have given.
    """
    count = len(columns[0])
    chunks = min(_THREADS, count // _LEAST_SHAPES)
    if chunks < 2:
        return function(*columns)
    parts = ([column[first::chunks] for column in columns] for first in range(chunks))
    results = in_threads(lambda part: function(*part), parts)
    together = tuple(np.empty(count, dtype=column.dtype) for column in results[0])
    for first, result in enumerate(results):
        for column, part in zip(together, result, strict=True):
            column[first::chunks] = part
    return together
