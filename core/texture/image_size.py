"""The size that a picture claims to have, read from the head of its file before anything is decoded."""

from __future__ import annotations

import struct
import warnings
from pathlib import Path
from typing import BinaryIO

from ..errors import TextureError

MOST_TEXELS = 1 << 27
"""A picture of 16384 by 8192 texels; decoded it takes 2 GB."""
_EXR = b"\x76\x2f\x31\x01"
_EXR_WINDOW = b"dataWindow\0box2i\0\x10\0\0\0"
_HEAD_BYTES = 1 << 16


def check_texels(name: str, count: int) -> None:
    """Refuse a picture that would take too much memory.

    Raises:
        TextureError: it has too many texels.
    """
    if count > MOST_TEXELS:
        hint = f"scale it down to {MOST_TEXELS // 1_000_000} million or fewer"
        raise TextureError(f"the image {name} has {count / 1e6:,.0f} million texels", hint)


def texels_of_file(path: Path) -> int:
    """See `texels`.

    Raises:
        OSError: the file cannot be read.
    """
    with path.open("rb") as file:
        return texels(file)


def texels(file: BinaryIO) -> int:
    """Width times height according to the head of a picture, 0 for unknown kinds of file."""
    from PIL import Image

    head = file.read(_HEAD_BYTES)
    file.seek(0)
    if head.startswith(_EXR):
        return _exr_texels(head)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(file) as image:
                return image.width * image.height
    except Image.DecompressionBombError:
        return MOST_TEXELS * 1000
    except (OSError, ValueError, SyntaxError, EOFError, struct.error):  # what Pillow raises for broken heads
        return 0


def _exr_texels(head: bytes) -> int:
    at = head.find(_EXR_WINDOW) + len(_EXR_WINDOW)
    if at < len(_EXR_WINDOW) or at + 16 > len(head):
        return 0
    left, top, right, bottom = struct.unpack_from("<4i", head, at)
    return max(int(right) - int(left) + 1, 0) * max(int(bottom) - int(top) + 1, 0)
