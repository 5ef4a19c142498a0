"""Gamut maps as a picture: one column per viewing angle, one row per tone (paper, Figure 7)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from ..model import FloatArray
from ..texture.decode import srgb_from_linear
from .sweep import Sweep

_COLUMN, _ROW, _GAP, _MARGIN, _TEXT = 14, 7, 44, 64, 15  # pixels
_TITLES = {"phi": "phi: from below to above", "theta": "theta: from left to right", "face": "face on"}


def gamut_maps(sweeps: Sequence[Sweep]) -> Image.Image:
    """All maps on one page, a row of maps per slant and a column per block of directions; brightness is sRGB.

    Args:
        sweeps: of one kind of print.
    """
    slants = sorted({sweep.slant_deg for sweep in sweeps})
    blocks = [block for block in _TITLES if any(sweep.block == block for sweep in sweeps)]
    widest = {block: max(len(s.angle_deg) for s in sweeps if s.block == block) * _COLUMN for block in blocks}
    left = {block: _MARGIN + sum(widest[other] + _GAP for other in blocks[:n]) for n, block in enumerate(blocks)}
    height = len(sweeps[0].tone) * _ROW
    size = (max(left[blocks[-1]] + widest[blocks[-1]] + _GAP, 260), 2 * _MARGIN + len(slants) * (height + _GAP))
    page = Image.new("L", size, 255)
    draw, font = ImageDraw.Draw(page), ImageFont.load_default(_TEXT)
    for block in blocks:
        draw.text((left[block], _GAP - 2 * _TEXT), _TITLES[block], fill=0, font=font)
    for sweep in sweeps:
        corner = (left[sweep.block], _MARGIN + slants.index(sweep.slant_deg) * (height + _GAP))
        page.paste(one_map(sweep), corner)
        _label(draw, font, sweep, corner, height, is_first=sweep.block == blocks[0])
    draw.text((_MARGIN, size[1] - _MARGIN), "tones from black (bottom) to white", fill=0, font=font)
    return page


def one_map(sweep: Sweep) -> Image.Image:
    """A single map: one column per viewing angle, the white tone at the top."""
    shown = srgb_from_linear(np.nan_to_num(sweep.reflectance[::-1]))
    pixels = np.rint(shown * 255).astype(np.uint8)
    return Image.fromarray(np.kron(pixels, np.ones((_ROW, _COLUMN), dtype=np.uint8)))


def _label(
    draw: ImageDraw.ImageDraw, font: ImageFont.FreeTypeFont | ImageFont.ImageFont, sweep: Sweep,
    corner: tuple[int, int], height: int, is_first: bool,
) -> None:  # fmt: skip
    x, y = corner
    for column, angle in enumerate(sweep.angle_deg.tolist()):
        if angle in (-80, -40, 0, 40, 80):
            draw.text((x + (column + 0.5) * _COLUMN, y + height + 2), f"{angle:g}°", fill=0, font=font, anchor="ma")
    low, high = _range(sweep.reflectance[:, sweep.face_on])
    draw.text((x, y - _TEXT - 4), f"face on {low:.2f} to {high:.2f}", fill=0, font=font)
    if is_first:
        draw.text((4, y + height / 2), f"{sweep.slant_deg:g}°", fill=0, font=font, anchor="lm")


def _range(column: FloatArray) -> tuple[float, float]:
    return float(np.nanmin(column)), float(np.nanmax(column))
