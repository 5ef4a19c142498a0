"""Pictures printed in several patterns, side by side: a sheet of pictures and a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ..model import Float32Array, FloatArray
from ..pattern.modulation import PERIOD_LAYERS
from ..settings import PrintSettings
from .match import PictureMatch, averaged, enlarged, in_pixels
from .viewing import Picture, contact_sheet, encoded

_SHEET_MM_PER_PIXEL = 0.1
_HEAD = """# Pictures on plates

Each picture is cut to {size} mm and filtered by Lanczos to {texels} texels, one per pair of layers, {layers} layers in
all.{tones} The plates are printed in each pattern (`wave` with the preset `paper`, `wave_offset` with
`waves_set_back`, `offset` with `set_back`) with calibrated tones, predicted strand by strand, and photographed straight
from the front in even white light. Photograph and picture are compared in linear light:

- *r*: both averaged over the pattern's own period, a wave wide and {period:g} mm high, at least a period from the
  edges;
- *r to the edges*: the same all over the face. The edges of a plate are lighter than its middle, whatever the picture,
  since no strand beyond them takes light away;
- *r by texel*: the mean over each texel, with nothing left out;
- *contrast*: the 99th less the 1st percentile of the averaged photograph's reflectance.

In the pictures the upper row is texture and prints, the lower row the same, averaged over a period and stretched from
black to white. Made by

    {command}

| picture | pattern | r | r to the edges | r by texel | darkest | brightest | contrast | wave, mm |
|---|---|---|---|---|---|---|---|---|
"""


def sheet(
    picture: Float32Array,
    photographs: Mapping[str, Float32Array],
    periods: Mapping[str, tuple[float, float]],
    mm_per_pixel: float,
) -> Picture:
    """The texture beside its prints; below, all of them averaged over the pattern's period.

    Args:
        picture: (h, w) tone, row 0 at the bottom.
        photographs: (H, W) by pattern, row 0 at the top.
        periods: (height, width) mm to average each of them over; the texture has the narrowest.
        mm_per_pixel: of the photographs.
    """
    size = next(iter(photographs.values())).shape
    texture = enlarged(picture, size)[::-1]
    windows = [in_pixels(period, mm_per_pixel) for period in (min(periods.values()), *periods.values())]
    views = [texture, *(np.nan_to_num(seen.astype(np.float64)) for seen in photographs.values())]
    soft = [_stretched(averaged(view, window)) for view, window in zip(views, windows, strict=True)]
    step = max(round(_SHEET_MM_PER_PIXEL / mm_per_pixel), 1)
    rows = [[_shown(view, step) for view in row] for row in (views, soft)]
    return contact_sheet(rows, ["texture", *photographs])


def table(
    rows: Sequence[tuple[str, str, PictureMatch]],
    shape: tuple[float, float, int, int],
    settings: PrintSettings,
    auto_contrast: bool,
    command: str,
) -> str:
    """Markdown.

    Args:
        rows: picture, pattern and match.
        shape: width and height in mm, columns and rows in texels.
        settings: layer height is used.
        auto_contrast: whether the tones were stretched.
        command: that makes the table.
    """
    width, height, columns, pairs = shape
    text = _HEAD.format(
        size=f"{width:g} × {height:g}",
        texels=f"{columns} × {pairs}",
        layers=2 * pairs,
        tones=" Its tones are stretched from black to white." if auto_contrast else "",
        period=PERIOD_LAYERS * settings.layer_height,
        command=command,
    )
    for name, pattern, match in rows:
        figures = (match.correlation, match.face_correlation, match.texel_correlation)
        cells = [f"{value:.3f}" for value in figures]
        cells += [f"{value:.2f}" for value in (match.darkest, match.brightest, match.contrast, match.period_mm)]
        text += f"| {name} | `{pattern}` | {' | '.join(cells)} |\n"
    return text


def pictures_of(sheets: Mapping[str, Path]) -> str:
    """Markdown that shows the sheets, whose paths are relative to the text."""
    return "".join(
        f"\n## {name}\n\n![Texture and prints of {name}]({path.as_posix()})\n" for name, path in sheets.items()
    )


def _stretched(light: FloatArray) -> FloatArray:
    low, high = np.nanpercentile(light, [1, 99])
    return np.asarray(np.clip((light - low) / max(high - low, 1e-6), 0.0, 1.0))


def _shown(light: FloatArray, step: int) -> Picture:
    """Linear light (H, W) with `step` × `step` pixels averaged into one, encoded."""
    height, width = (size // step * step for size in light.shape)
    blocks = light[:height, :width].reshape(height // step, step, width // step, step)
    return np.repeat(encoded(blocks.mean(axis=(1, 3)))[..., None], 3, axis=2)
