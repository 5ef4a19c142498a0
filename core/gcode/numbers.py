"""Fixed-point numbers as text in bulk: every number becomes three or four table look-ups of four characters each.

A line of text is a row of 32-bit words; bytes that stay 0 are deleted at the end, which takes care of leading
zeros, missing signs and words that a line does not have.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..model import IntArray

WordArray = NDArray[np.uint32]

COORDINATE_LIMIT = 10**6  # in steps of 0.001 mm
FILAMENT_LIMIT = 10**10  # in steps of 0.00001 mm
FEEDRATE_LIMIT = 10**5


def word(text: str) -> np.uint32:
    """Up to four characters as one word, filled up with zero bytes."""
    return np.uint32(np.frombuffer(text.encode("ascii").ljust(4, b"\0"), dtype=np.uint32)[0])


def words(texts: list[str]) -> WordArray:
    """(N,) texts of up to four characters as words."""
    return np.array(texts, dtype="S4").view(np.uint32)


_SIGNED = words([sign + str(n) for sign in ("", "-") for n in range(1000)])  # at 1000 × negative + n
_SIGNED_OR_EMPTY = words([sign + (str(n) if n else "") for sign in ("", "-") for n in range(1000)])
_FRACTION = words([f".{n:03d}" for n in range(1000)])
_UNITS = words([f"{n}." for n in range(1000)] + [f"{n:03d}." for n in range(1000)])  # at 1000 × padded + n
_FOUR = words([f"{n:04d}" for n in range(10000)])
_PADDED = words([f"{n:03d}" for n in range(1000)])
_LEADING = words([str(n) if n else "" for n in range(1000)])
_LAST = words([str(n) for n in range(10)])


def coordinate_words(thousandths: IntArray) -> tuple[WordArray, WordArray]:
    """The text of numbers with 3 decimals, two words each.

    Args:
        thousandths: (N,) int64, the numbers times 1000, less than `COORDINATE_LIMIT` in size.
    """
    size = np.abs(thousandths).astype(np.uint32)
    whole = size // np.uint32(1000)
    return _SIGNED[whole + np.uint32(1000) * (thousandths < 0)], _FRACTION[size - whole * np.uint32(1000)]


def filament_words(steps: IntArray) -> tuple[WordArray, WordArray, WordArray, WordArray]:
    """The text of numbers with 5 decimals, four words each.

    Args:
        steps: (N,) int64, the numbers times 100000, less than `FILAMENT_LIMIT` in size.
    """
    size = np.abs(steps)
    whole = size // 100_000
    fraction = (size - whole * 100_000).astype(np.uint32)
    units = whole.astype(np.uint32)
    thousands = units // np.uint32(1000)
    units -= thousands * np.uint32(1000)
    four = fraction // np.uint32(10)
    return (
        _SIGNED_OR_EMPTY[thousands + np.uint32(1000) * (steps < 0)],
        _UNITS[units + np.uint32(1000) * (thousands > 0)],
        _FOUR[four],
        _LAST[fraction - four * np.uint32(10)],
    )


def feedrate_words(feedrate: IntArray) -> tuple[WordArray, WordArray]:
    """The text of whole numbers from 1 to 99999, two words each.

    Args:
        feedrate: (N,) int64, less than `FEEDRATE_LIMIT`.
    """
    thousands = feedrate // 1000
    units = feedrate - thousands * 1000
    low = np.where(thousands > 0, _PADDED[units], _SIGNED[units])
    return _LEADING[thousands], low
