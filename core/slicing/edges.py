"""The faces on both sides of the mesh edges that planes cut."""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, IntArray

LEADS_UP = 1 << 62
"""Bit that marks edges that lead up."""

_SCATTER = (0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB)  # odd, with bits all over
_ROOM = 1.2  # cells of the table, for each key


def faces_beyond(key: IntArray, number: IntArray, slots: int) -> IntArray:
    """Which face lies beyond each edge that leads up.

    The edge that leads up in one face leads down in the other. Where an edge has several of either, as where solids
    touch, the k-th goes with the k-th.

    Args:
        key: (E,) the same for an edge and for the same edge seen from beyond.
        number: (E,) 2 f or 2 f + 1 for an edge of face f. Those of edges that lead up are distinct, and have the bit
            `LEADS_UP` set besides.
        slots: twice the number of faces.

    Returns:
        (slots,) the face beyond each edge that leads up, by its number without that bit, -1 where there is none.
    """
    beyond = np.full(slots, -1, dtype=np.int64)
    # Nearly all edges meet in tables of scattered keys, in half the time of sorting; what is left is sorted.
    for scatter in _SCATTER:
        up, down, left = _met(key, number >= LEADS_UP, scatter)
        beyond[number.take(up) ^ LEADS_UP] = number.take(down) >> 1
        key, number = key.take(left), number.take(left)
    order = np.lexsort((number, key))
    key, number = key[order], number[order]
    is_up = number >= LEADS_UP
    up_key, up, down_key, down = key[is_up], number[is_up] ^ LEADS_UP, key[~is_up], number[~is_up] >> 1
    where = np.searchsorted(down_key, up_key) + _rank_in_group(up_key)
    paired = where < len(down)
    paired[paired] = down_key[where[paired]] == up_key[paired]
    beyond[up[paired]] = down[where[paired]]
    return beyond


def _met(key: IntArray, leads_up: BoolArray, scatter: int) -> tuple[IntArray, IntArray, IntArray]:
    """Edges that lead up (P,), the same edges leading down (P,), and all that share a cell with another edge (R,)."""
    bits, index = int(_ROOM * len(key)).bit_length(), np.arange(len(key), dtype=np.int32)
    cell = (key.view(np.uint64) * np.uint64(scatter) >> np.uint64(64 - bits)).view(np.int64)
    place = cell << 1 | leads_up  # each cell has room for an edge that leads up and one that leads down
    table = np.full(2 << bits, -1, dtype=np.int32)
    table[place] = index
    crowded = np.zeros(1 << bits, dtype=bool)
    crowded[cell.take(np.flatnonzero(table.take(place) != index))] = True
    alone = ~crowded.take(cell)
    up = np.flatnonzero(alone & leads_up)
    down = table.take(place.take(up) - 1)
    met = np.flatnonzero((down >= 0) & (key.take(down, mode="wrap") == key.take(up)))
    return up.take(met), down.take(met).astype(np.int64), np.flatnonzero(~alone)


def _rank_in_group(ordered: IntArray) -> IntArray:
    """(N,) how many equal numbers stand before each of N sorted ones."""
    index = np.arange(len(ordered))
    fresh = np.append(True, ordered[1:] != ordered[:-1])[: len(ordered)]
    return np.asarray(index - np.maximum.accumulate(np.where(fresh, index, 0)))
