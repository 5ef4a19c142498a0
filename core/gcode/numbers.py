"""Fixed-point numbers as text in bulk: every number becomes a few table look-ups of four or eight characters each.

A line of text is a row of such words; bytes that stay 0 are deleted at the end, which takes care of leading zeros,
missing signs and words that a line does not have.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from ..model import IntArray

WordArray = NDArray[np.uint32]
TextArray = NDArray[np.uint64]

COORDINATE_LIMIT = 10**6  # in steps of 0.001 mm
FILAMENT_LIMIT = 10**10  # in steps of 0.00001 mm
BACKWARDS_LIMIT = 10**9  # the same, below 0
FEEDRATE_LIMIT = 10**5


def word(text: str) -> np.uint32:
    """Up to four characters as one word, filled up with zero bytes."""
    return np.uint32(np.frombuffer(text.encode("ascii").ljust(4, b"\0"), dtype=np.uint32)[0])


def words(texts: list[str]) -> WordArray:
    """(N,) texts of up to four characters as words."""
    return np.array(texts, dtype="S4").view(np.uint32)


def _four_digits() -> WordArray:
    """(10000,) the numbers from 0 on in four digits; without Python's texts, which would take a while."""
    digits = np.arange(10_000)[:, None] // (1000, 100, 10, 1) % 10 + ord("0")
    found: WordArray = digits.astype(np.uint8).view(np.uint32)[:, 0]
    return found


FOUR_DIGITS = _four_digits()
_SIGNED = words([sign + str(n) for sign in ("", "-") for n in range(1000)])  # at 1000 × negative + n
_SIGNED_OR_EMPTY = words([sign + (str(n) if n else "") for sign in ("", "-") for n in range(1000)])
_FRACTION = words([f".{n:03d}" for n in range(1000)])
_UNITS = words([f"{n}." for n in range(1000)] + [f"{n:03d}." for n in range(1000)])  # at 1000 × padded + n
_FEEDRATE = words([f" F{n}" if n else " F" for n in range(100)])
_REST = words([f"{n}\n" for n in range(1000)] + [f"{n:03d}\n" for n in range(1000)])  # at 1000 × padded + n
_LAST = words([str(n) for n in range(10)])
_THOUSAND, _TEN = np.uint32(1000), np.uint32(10)


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
    return _SIGNED_OR_EMPTY.take(thousands), _UNITS.take(units), FOUR_DIGITS.take(four), _LAST.take(fraction)


def feedrate_words(feedrate: NDArray[np.int32]) -> tuple[WordArray, WordArray]:
    """The text of whole numbers from 1 to 99999 after a blank and an F and before the line's end, two words each.

    Args:
        feedrate: (N,) int32, less than `FEEDRATE_LIMIT`.
    """
    thousands = feedrate.astype(np.uint32) // _THOUSAND
    rest = feedrate - thousands * _THOUSAND
    rest += _THOUSAND * (thousands > 0)
    return _FEEDRATE.take(thousands), _REST.take(rest)


def coordinate_texts(low: int, high: int) -> tuple[TextArray, int]:
    """Numbers with 3 decimals, at least those from low to high, in thousandths, and the place of 0 among them."""
    below, above = (
        _paired(np.repeat(texts[: most // 1000 + 1], 1000), np.tile(_FRACTION, most // 1000 + 1))
        for texts, most in ((_SIGNED[1000:], max(-low, 0)), (_SIGNED, max(high, 0)))
    )
    return np.concatenate([below[:0:-1], above]), len(below) - 1


def whole_texts(letters: list[str], most: int) -> TextArray:
    """(L, most + 1) the whole numbers from 0 to `most`, each after a letter and a sign and before a decimal point.

    Args:
        letters: L texts of two characters, or of three where no number has five digits.
        most: less than 100,000.
    """
    thousands, units = np.divmod(np.arange(most + 1), 1000)
    units += 1000 * (thousands > 0)
    upper = [words([f"{letter}{n or ''}" for n in range(int(thousands[-1]) + 1)]) for letter in letters]
    return np.stack([_paired(column[thousands], _UNITS[units]) for column in upper])


@cache
def five_decimals() -> TextArray:
    """(100000,) the numbers from 0 on in five digits."""
    return _paired(np.repeat(FOUR_DIGITS, 10), np.tile(_LAST, len(FOUR_DIGITS)))


def feedrate_texts(most: int) -> TextArray:
    """(most + 1,) the feedrates up to `most`, as of `feedrate_words`."""
    return _paired(*feedrate_words(np.arange(most + 1, dtype=np.int32)))


def _paired(first: WordArray, second: WordArray) -> TextArray:
    """(N,) eight characters of four and four."""
    pairs: TextArray = np.stack([first, second], axis=1).view(np.uint64)[:, 0]
    return pairs
