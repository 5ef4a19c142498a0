"""The faces on both sides of the mesh edges that planes cut."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model import IntArray
from ..pattern.chunks import in_chunks


def faces_beyond(faces: IntArray, levels: NDArray[np.int32], vertices: int) -> IntArray:
    """The face across each edge that leads up, seen from its own face.

    An edge is a corner 3 f + k: it leads from corner k of face f to the next one. The edge that leads up in one face
    leads down in the other. Where an edge has several of either, as where solids touch, the k-th goes with the k-th.

    Args:
        faces: (F, 3) vertices.
        levels: (F, 3) how many planes lie at each corner or below it.
        vertices: how many there are.

    Returns:
        (3F,) the face beyond each edge, -1 where there is none and for all edges that do not lead up past a plane.
    """

    def chunk(faces: IntArray, levels: NDArray[np.int32], edge: IntArray) -> tuple[IntArray, ...]:
        """Numbers that faces share of the edges of some faces that lead up, these edges, and likewise down."""
        start, here, edges = faces.ravel(), levels.ravel(), edge.ravel()
        end, there = _of_next_corner(start), _of_next_corner(here)
        up, down = np.flatnonzero(here < there), np.flatnonzero(here > there)
        return (
            start.take(up) * vertices + end.take(up), edges.take(up),
            end.take(down) * vertices + start.take(down), edges.take(down),
        )  # fmt: skip

    up_key, up, down_key, down = in_chunks(chunk, faces, levels, np.arange(faces.size).reshape(-1, 3))
    up_key, up = _sorted(up_key, up, vertices)
    down_key, down = _sorted(down_key, down, vertices)
    beyond = np.full(faces.size, -1, dtype=np.int64)
    if np.array_equal(up_key, down_key):
        beyond[up] = down // 3
        return beyond
    where = np.searchsorted(down_key, up_key) + _rank_in_group(up_key)
    paired = where < len(down)
    paired[paired] = down_key[where[paired]] == up_key[paired]
    beyond[up[paired]] = down[where[paired]] // 3
    return beyond


def _of_next_corner(values: NDArray[Any]) -> NDArray[Any]:
    """(3F,) what the next corner of the same face has."""
    turned = np.empty_like(values)
    turned[:-1] = values[1:]
    turned[2::3] = values[0::3]
    return turned


def _sorted(key: IntArray, edge: IntArray, vertices: int) -> tuple[IntArray, IntArray]:
    """Both sorted by key (less than vertices²), edges of one key in increasing order as they come."""
    bits = int(edge[-1]).bit_length() if len(edge) else 0
    if 2 * (vertices - 1).bit_length() + bits > 63:
        order = np.argsort(key, kind="stable")
        return key[order], edge[order]
    # Sorting numbers that hold both takes a third of the time of sorting their places.
    both = key << bits
    both |= edge
    both.sort()
    return both >> bits, both & ((1 << bits) - 1)


def _rank_in_group(ordered: IntArray) -> IntArray:
    """(N,) how many equal ones come before each of some sorted numbers."""
    index = np.arange(len(ordered))
    fresh = np.append(True, ordered[1:] != ordered[:-1])[: len(ordered)]
    return np.asarray(index - np.maximum.accumulate(np.where(fresh, index, 0)))
