"""Sound files, damaged in the ways that find what a reader takes for granted."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

_NUMBER = re.compile(rb"-?\d+\.?\d*")


def mutated(data: bytes, others: Sequence[bytes], words: Sequence[bytes], random: np.random.Generator) -> bytes:
    """The file after one to eight damages; it grows to twice its size at most."""
    most = 2 * len(data) + 1000
    for _ in range(int(random.integers(1, 9))):
        kind = int(random.integers(0, 8))
        here = int(random.integers(0, len(data) + 1))
        there = min(here + int(random.geometric(0.02)), len(data))
        if kind == 0 and data:
            at = min(here, len(data) - 1)
            data = data[:at] + bytes([data[at] ^ (1 << int(random.integers(0, 8)))]) + data[at + 1 :]
        elif kind == 1:
            data = data[:here] + data[there:]
        elif kind == 2:
            data = data[:here] + data[here:there] * int(random.integers(2, 5)) + data[there:]
        elif kind == 3:
            data = data[:here] + words[int(random.integers(0, len(words)))] + data[here:]
        elif kind == 4:
            data = data[:here] + words[int(random.integers(0, len(words)))] + data[there:]
        elif kind == 5:
            other = others[int(random.integers(0, len(others)))]
            begin = int(random.integers(0, len(other) + 1))
            data = data[:here] + other[begin : begin + int(random.geometric(0.005))] + data[there:]
        elif kind == 6:
            data = data[:here] + random.integers(0, 256, there - here, dtype=np.uint8).tobytes() + data[there:]
        else:
            found = _NUMBER.search(data, here)
            if found:
                data = data[: found.start()] + words[int(random.integers(0, len(words)))] + data[found.end() :]
    return data[: here if random.random() < 0.05 else most]
