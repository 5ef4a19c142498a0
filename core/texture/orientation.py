"""Which way up a camera held a picture: stored in the file (EXIF), and left to whoever shows it."""

from __future__ import annotations

import struct
import warnings
from pathlib import Path

import numpy as np

from ..model import Float32Array, ToneImage

_TAG = 0x0112
_ON_ITS_SIDE = 5  # from here on width and height are swapped


def orientation_of_file(path: Path, size: tuple[int, int]) -> int:
    """The EXIF orientation of a picture, 1 to 8; 1 where the file tells none.

    Args:
        path: of the picture.
        size: width and height of what was read; where they are swapped already, nothing is left to be turned.
    """
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(path) as image:
                told = image.getexif().get(_TAG, 1)
                stored = image.size
    except (OSError, ValueError, SyntaxError, EOFError, struct.error, Image.DecompressionBombError):
        return 1  # a kind of file that tells nothing, or whose head is broken
    if told not in range(1, 9) or (told >= _ON_ITS_SIDE and stored != size):
        return 1
    return int(told)


def upright(image: ToneImage, orientation: int) -> ToneImage:
    """A picture the way up that it was taken; `orientation` as EXIF tells it."""
    return ToneImage(_turned(image.tone, orientation), _turned(image.alpha, orientation))


def _turned(values: Float32Array, orientation: int) -> Float32Array:
    rows = values[::-1]  # EXIF counts from the top
    if orientation >= _ON_ITS_SIDE:
        rows = rows.T
    if orientation in (3, 4, 7, 8):
        rows = rows[::-1]
    if orientation in (2, 3, 6, 7):
        rows = rows[:, ::-1]
    return np.ascontiguousarray(rows[::-1])
