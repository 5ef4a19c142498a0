"""Run GEOS over many shapes in threads: shapely's array functions release the interpreter lock."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

Shapes = NDArray[np.object_]

_THREADS = os.cpu_count() or 1
_LEAST_SHAPES = 48  # for a thread: below, numpy's calls cost more than what they call


def in_chunks(function: Callable[..., tuple[Shapes, ...]], *columns: NDArray[Any]) -> tuple[Shapes, ...]:
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
    with ThreadPoolExecutor(chunks) as pool:
        parts = ([column[first::chunks] for column in columns] for first in range(chunks))
        results = list(pool.map(lambda part: function(*part), parts))
    together = tuple(np.empty(count, dtype=column.dtype) for column in results[0])
    for first, result in enumerate(results):
        for column, part in zip(together, result, strict=True):
            column[first::chunks] = part
    return together
