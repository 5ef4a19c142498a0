"""Pictures of a print: from which sides, what an eye at some distance sees of them, and a sheet of several."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..model import FloatArray
from ..records import dataclass
from ..texture.decode import linear_from_srgb, srgb_from_linear

Picture = NDArray[np.uint8]
"""(H, W, 3), sRGB-encoded, row 0 at the top."""

VIEWS = {
    "three-quarter": (-30.0, 18.0),
    "front": (0.0, 8.0),
    "back": (180.0, 8.0),
    "left": (-90.0, 8.0),
    "right": (90.0, 8.0),
}
"""Azimuth and elevation of the camera, degrees: azimuth 0 is in front of the object (-Y), 90 to its right (+X)."""

TURNTABLE = "turntable"
"""All around: one file with several frames."""

USUAL_VIEW = "three-quarter"

DISTANCES_MM = {"hand": 300.0, "desk": 700.0, "shelf": 2000.0}
"""Distance of the eye from an object in the hand, on the desk, and on a shelf across the room, mm."""

_ARC_MINUTE_RAD = math.radians(1 / 60)
_SIGMA_OF_FWHM = 1 / math.sqrt(8 * math.log(2))
_MARGIN, _TEXT_HEIGHT, _LEAST_TEXT = 12, 18, 5
_PAPER, _INK = (255, 255, 255), (40, 40, 40)


@dataclass(frozen=True)
class PictureOptions:
    """How pictures are taken.

    Attributes:
        azimuth_deg: the side of the object that is its front: 0 is -Y, 90 is +X.
        distance: a key of `DISTANCES_MM`; detail too fine for the eye at that distance is left out; "" shows all.
        resolution: width and height in pixels; those of a turntable are at most 480.
        samples: of each pixel at most.
        whole_plate: with tower, skirt and supports.
    """

    azimuth_deg: float = 0.0
    distance: str = ""
    resolution: tuple[int, int] = (900, 900)
    samples: int = 64
    whole_plate: bool = False


def view_files(path: Path, views: Iterable[str]) -> dict[str, Path]:
    """The file of each view: `path` itself for the usual view if none is named, otherwise `<stem>_<view>`."""
    named = {
        view: path.with_name(f"{path.stem}_{view}{'.gif' if view == TURNTABLE else path.suffix}") for view in views
    }
    return named or {USUAL_VIEW: path}


def resolution_mm(distance_mm: float) -> float:
    """The finest detail, mm, that a good eye tells apart at a distance: one arc minute."""
    return distance_mm * _ARC_MINUTE_RAD


def seen_from(picture: Picture, mm_per_pixel: float, distance_mm: float) -> Picture:
    """A picture without the detail that is too fine for the eye at a distance, in the same size.

    Light that reaches the eye from a point spreads over about an arc minute: a Gaussian of that width at half its
    height, applied to linear light. Beyond its edges the picture is taken to be mirrored.

    Args:
        picture: (H, W, 3) uint8, sRGB-encoded.
        mm_per_pixel: on the object.
        distance_mm: of the eye from the object.
    """
    sigma = resolution_mm(distance_mm) * _SIGMA_OF_FWHM / mm_per_pixel
    light = linear_from_srgb(np.arange(256) / 255.0)[picture]
    for axis in (0, 1):
        light = blurred(light, sigma, axis)
    return encoded(light)


def encoded(light: FloatArray) -> Picture:
    """Linear light, 0 to 1, as sRGB in 8 bits (IEC 61966-2-1)."""
    return np.asarray(np.rint(srgb_from_linear(light) * 255), dtype=np.uint8)


def encoded_tone(light: float) -> float:
    """One value of linear light as sRGB, both from 0 to 1."""
    return float(encoded(np.array([light]))[0]) / 255


def png(picture: Picture) -> bytes:
    """The contents of a PNG file of a picture."""
    from PIL import Image

    data = BytesIO()
    Image.fromarray(picture).save(data, "PNG")
    return data.getvalue()


def contact_sheet(rows: Sequence[Sequence[Picture]], labels: Sequence[str]) -> Picture:
    """Pictures of one size in rows, with a line of text over each column.

    Args:
        rows: of one length each.
        labels: of the columns.
    """
    from PIL import Image, ImageDraw, ImageFont

    height, width = rows[0][0].shape[:2]
    across, down = width + _MARGIN, height + _MARGIN
    head = _MARGIN + _TEXT_HEIGHT + _MARGIN // 2
    sheet = Image.new("RGB", (_MARGIN + across * len(labels), head + down * len(rows)), _PAPER)
    pen = ImageDraw.Draw(sheet)
    size = int(_TEXT_HEIGHT * 0.8)
    font = ImageFont.load_default(size)
    while size > _LEAST_TEXT and max(map(font.getlength, labels)) > width:
        size -= 1  # a small picture's title would run into the next one
        font = ImageFont.load_default(size)
    for column, label in enumerate(labels):
        left = _MARGIN + column * across
        pen.text((left, _MARGIN // 2), label, _INK, font)
        for number, row in enumerate(rows):
            sheet.paste(Image.fromarray(row[column]), (left, head + number * down))
    return np.asarray(sheet)


def blurred(light: FloatArray, sigma: float, axis: int) -> FloatArray:
    """Convolved with a Gaussian of `sigma` pixels along an axis; mirrored beyond the edges."""
    length = light.shape[axis]
    pad = min(math.ceil(4 * sigma), length)
    wide = np.pad(light, [(pad, pad) if each == axis else (0, 0) for each in range(light.ndim)], "symmetric")
    frequency = np.fft.rfftfreq(length + 2 * pad)
    passed = np.exp(-2 * (np.pi * frequency * sigma) ** 2)
    shape = [-1 if each == axis else 1 for each in range(light.ndim)]
    blurred = np.fft.irfft(np.fft.rfft(wide, axis=axis) * passed.reshape(shape), length + 2 * pad, axis=axis)
    return np.asarray(np.take(blurred, range(pad, pad + length), axis=axis))
