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
_FEEDRATE = words([f" F{n}" if n else " F" for n in range(100)])
_REST = words([str(n) for n in range(1000)] + [f"{n:03d}" for n in range(1000)])  # at 1000 × padded + n
_LAST = words([str(n) for n in range(10)])
_THOUSAND, _TEN = np.uint32(1000), np.uint32(10)


def coordinate_words(thousandths: NDArray[np.int32]) -> tuple[WordArray, WordArray]:
    """The text of numbers with 3 decimals, two words each.

    Args:
        thousandths: (N,) int32, the numbers times 1000, less than `COORDINATE_LIMIT` in size.
    """
    size = np.abs(thousandths).astype(np.uint32)
    whole = size // _THOUSAND
    size -= whole * _THOUSAND
    whole += _THOUSAND * (thousandths < 0)
    return _SIGNED.take(whole), _FRACTION.take(size)


def filament_words(steps: IntArray) -> tuple[WordArray, WordArray, WordArray, WordArray]:
    """The text of numbers with 5 decimals, four words each.

    Args:
        steps: (N,) int64, the numbers times 100000, less than `FILAMENT_LIMIT` in size.
    """
    size = np.abs(steps)
    whole = size // 100_000
    fraction = (size - whole * 100_000).astype(np.uint32)
    units = whole.astype(np.uint32)
    thousands = units // _THOUSAND
    units -= thousands * _THOUSAND
    units += _THOUSAND * (thousands > 0)
    thousands += _THOUSAND * (steps < 0)
    four = fraction // _TEN
    fraction -= four * _TEN
    return _SIGNED_OR_EMPTY.take(thousands), _UNITS.take(units), _FOUR.take(four), _LAST.take(fraction)


def feedrate_words(feedrate: NDArray[np.int32]) -> tuple[WordArray, WordArray]:
    """The text of whole numbers from 1 to 99999 after a blank and an F, two words each.

    Args:
        feedrate: (N,) int32, less than `FEEDRATE_LIMIT`.
    """
    thousands = feedrate.astype(np.uint32) // _THOUSAND
    rest = feedrate - thousands * _THOUSAND
    rest += _THOUSAND * (thousands > 0)
    return _FEEDRATE.take(thousands), _REST.take(rest)
