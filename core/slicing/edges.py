"""The faces on both sides of the mesh edges that planes cut."""

from __future__ import annotations

import numpy as np

from ..model import IntArray


def faces_beyond(key: IntArray, number: IntArray, slots: int) -> IntArray:
    """Which face lies beyond each edge that leads up.

    The edge that leads up in one face leads down in the other. Where an edge has several of either, as where solids
    touch, the k-th goes with the k-th.

    Args:
        key: (E,) the same for an edge and for the same edge seen from beyond.
        number: (E,) 2 f or 2 f + 1 for an edge of face f. Those of edges that lead up are distinct, and have the bit
            `slots.bit_length()` set besides.
        slots: twice the number of faces.

    Returns:
        (slots,) the face beyond each edge that leads up, by its number without that bit, -1 where there is none.
    """
    bits, beyond = slots.bit_length(), np.full(slots, -1, dtype=np.int64)
    slot_of, leads_up = (1 << bits) - 1, 1 << bits
    if int(key.max(initial=0)).bit_length() + bits < 63:
        # Sorting numbers that hold both takes a third of the time of sorting their places.
        both = key << (bits + 1)
        both |= number
        both.sort()
        down, up = both[0::2], both[1::2]
        if len(down) == len(up) and ((down ^ up) >> bits == 1).all():  # in pairs that only differ in where they lead
            beyond[up & slot_of] = (down & slot_of) >> 1
            return beyond
        key, number = both >> (bits + 1), both & (2 * leads_up - 1)
    else:
        order = np.lexsort((number, key))
        key, number = key[order], number[order]
    is_up = number >= leads_up
    up_key, up, down_key, down = key[is_up], number[is_up] & slot_of, key[~is_up], number[~is_up] >> 1
    where = np.searchsorted(down_key, up_key) + _rank_in_group(up_key)
    paired = where < len(down)
    paired[paired] = down_key[where[paired]] == up_key[paired]
    beyond[up[paired]] = down[where[paired]]
    return beyond


def _rank_in_group(ordered: IntArray) -> IntArray:
    """(N,) how many equal numbers stand before each of N sorted ones."""
    index = np.arange(len(ordered))
    fresh = np.append(True, ordered[1:] != ordered[:-1])[: len(ordered)]
    return np.asarray(index - np.maximum.accumulate(np.where(fresh, index, 0)))
