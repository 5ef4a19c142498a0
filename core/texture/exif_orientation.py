"""Which way up a camera was held: the EXIF orientation, which pixels do not show and viewers must apply."""

from __future__ import annotations

import struct
import warnings
from pathlib import Path

import numpy as np

from ..model import Float32Array, ToneImage

_TAG = 0x0112
_ON_ITS_SIDE = 5  # from this orientation on, width and height are swapped


def orientation_of_file(path: Path, size: tuple[int, int]) -> int:
    """The EXIF orientation of a picture, 1 to 8; 1 if the file has none.

    Args:
        path: of the picture.
        size: width and height of the decoded picture; if they are swapped already, it must not be turned again.
    """
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(path) as image:
                found = image.getexif().get(_TAG, 1)
                stored = image.size
    except (OSError, ValueError, SyntaxError, EOFError, struct.error, Image.DecompressionBombError):
        return 1  # a kind of file without EXIF, or with a broken head
    if found not in range(1, 9) or (found >= _ON_ITS_SIDE and stored != size):
        return 1
    return int(found)


def upright(image: ToneImage, orientation: int) -> ToneImage:
    """A picture turned the way up that it was taken; `orientation` is that of EXIF."""
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
