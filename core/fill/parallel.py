"""Run GEOS over many shapes in threads: shapely's array functions release the interpreter lock."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

Shapes = NDArray[np.object_]

_THREADS = os.cpu_count() or 1
_CHUNKS_A_THREAD = 3  # as the layers of one part of a model cost more than those of another
_LEAST_SHAPES = 48  # in a chunk: below, numpy's calls cost more than what they call


def in_chunks(
    function: Callable[..., tuple[Shapes, ...]], *columns: NDArray[Any], chunks_a_thread: int = _CHUNKS_A_THREAD
) -> tuple[Shapes, ...]:
    """Apply a function to equal slices of several arrays in threads and put the results together again.

    Args:
        function: from slices, (n,) each, to a tuple of (n,) arrays; row i of a result may depend on row i only.
        columns: (N,) arrays of one length.
        chunks_a_thread: at most; each costs what numpy takes for its calls.

    Returns:
        The tuple that `function(*columns)` would have given.
    """
    count = len(columns[0])
    chunks = min(chunks_a_thread * _THREADS, count // _LEAST_SHAPES)
    if chunks < 2:
        return function(*columns)
    bounds = np.linspace(0, count, chunks + 1).astype(int)
    with ThreadPoolExecutor(_THREADS) as pool:
        slices = ([column[low:high] for column in columns] for low, high in pairwise(bounds))
        results = list(pool.map(lambda part: function(*part), slices))
    return tuple(np.concatenate(pieces) for pieces in zip(*results, strict=True))
