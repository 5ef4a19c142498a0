"""How well a print shows its picture: both in linear light, at the resolution of the pattern."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np

from ..model import BoolArray, Float32Array, FloatArray
from ..pattern.modulation import PERIOD_LAYERS
from ..pattern.wave import WavedOutlines
from ..ragged import following
from ..records import dataclass
from ..settings import PrintSettings


@dataclass(frozen=True)
class PictureMatch:
    """How well the photograph of a face matches its picture.

    Attributes:
        correlation: of photograph and picture, both averaged over the pattern's own period, at least a period away
            from the edges of the face: nearer to them the window also covers the shape's rounded, lighter edges.
        face_correlation: the same up to the edges, where the window is cropped.
        texel_correlation: of the mean over each texel and that texel, for all texels.
        darkest: 1st percentile of the averaged photograph.
        brightest: 99th percentile of it.
        contrast: brightest less darkest.
        period_mm: width of a wave.
    """

    correlation: float
    face_correlation: float
    texel_correlation: float
    darkest: float
    brightest: float
    contrast: float
    period_mm: float

    def as_dict(self) -> dict[str, float]:
        """By name, four digits, JSON-ready."""
        return {name: round(value, 4) for name, value in asdict(self).items()}


def picture_match(
    photograph: Float32Array, picture: Float32Array, mm_per_pixel: float, period: tuple[float, float]
) -> PictureMatch:
    """Compare a straight photograph of a face with the picture on it.

    Args:
        photograph: (H, W) linear reflectance of exactly that face, row 0 at the top; NaN where nothing is.
        picture: (h, w) tone, row 0 at the bottom.
        mm_per_pixel: of the photograph.
        period: of the pattern, from `pattern_period`.

    Raises:
        ValueError: the face is smaller than three periods.
    """
    seen = photograph[::-1].astype(np.float64)
    wanted = enlarged(picture, seen.shape)
    window = in_pixels(period, mm_per_pixel)
    if any(size < 3 * part for size, part in zip(seen.shape, window, strict=True)):
        raise ValueError("the face is smaller than three periods of the pattern")
    # Pixels without a value are left out of both.
    smooth, target = averaged(seen, window), averaged(np.where(np.isfinite(seen), wanted, np.nan), window)
    rows, columns = (slice(size, -size) for size in window)
    inner, inner_target = smooth[rows, columns], target[rows, columns]
    texels = cell_means(seen, picture.shape)
    darkest, brightest = np.nanpercentile(inner, [1, 99])
    return PictureMatch(
        correlation=correlation(inner, inner_target),
        face_correlation=correlation(smooth, target),
        texel_correlation=correlation(texels, picture.astype(np.float64)),
        darkest=float(darkest),
        brightest=float(brightest),
        contrast=float(brightest - darkest),
        period_mm=period[1],
    )


def pattern_period(outlines: WavedOutlines, settings: PrintSettings) -> tuple[float, float]:
    """(height, width) mm of one period of the pattern: four layers, and the mean width of a wave.

    Args:
        outlines: of the print; where they have no waves the width is the setting's wavelength.
        settings: layer height and wavelength are used.
    """
    step = outlines.base[following(outlines.start)] - outlines.base
    waves = int((outlines.wave > 1 - 1e-12).sum())  # every wave begins at a sample, where it is 1
    length = float(np.hypot(step[:, 0], step[:, 1])[np.repeat(_waved(outlines), np.diff(outlines.start))].sum())
    return PERIOD_LAYERS * settings.layer_height, length / waves if waves else settings.wavelength


def _waved(outlines: WavedOutlines) -> BoolArray:
    """(M,) loops that carry waves."""
    return np.asarray(np.maximum.reduceat(np.abs(outlines.wave), outlines.start[:-1]) > 0)


def in_pixels(period: tuple[float, float], mm_per_pixel: float) -> tuple[int, int]:
    """(rows, columns) in pixels of a height and a width in mm, at least 1."""
    return max(round(period[0] / mm_per_pixel), 1), max(round(period[1] / mm_per_pixel), 1)


def averaged(values: FloatArray, window: tuple[int, int]) -> FloatArray:
    """Moving average over a window (rows, columns), without NaN and values outside; NaN where nothing is left."""
    known = np.isfinite(values)
    total, weight = (_box(np.where(known, part, 0.0), window) for part in (values, np.ones_like(values)))
    mean: FloatArray = np.divide(total, weight, out=np.full_like(total, np.nan), where=weight > 0.5)
    return mean


def cell_means(values: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """Mean (h, w) over each cell of an even grid laid over values (H, W), without NaN; NaN for cells without values."""
    row, column = (np.arange(size) * cells // size for size, cells in zip(values.shape, shape, strict=True))
    cell = (row[:, None] * shape[1] + column).ravel()
    known = np.isfinite(values).ravel()
    count = np.bincount(cell[known], minlength=shape[0] * shape[1])
    total = np.bincount(cell[known], values.ravel()[known], minlength=shape[0] * shape[1])
    mean: FloatArray = np.divide(total, count, out=np.full(len(total), np.nan), where=count > 0)
    return mean.reshape(shape)


def enlarged(picture: Float32Array, shape: tuple[int, ...]) -> FloatArray:
    """(H, W) float64, each pixel with the value of the texel that its middle lies in."""
    row, column = (
        ((np.arange(size) + 0.5) * texels / size).astype(np.int64)
        for size, texels in zip(shape, picture.shape, strict=True)
    )
    return np.asarray(picture[np.ix_(row, column)], dtype=np.float64)


def correlation(a: FloatArray, b: FloatArray) -> float:
    """Pearson's, of the places where both are known; 0 where one of them is constant."""
    known = np.isfinite(a) & np.isfinite(b)
    if not known.any():
        return 0.0
    x, y = a[known] - a[known].mean(), b[known] - b[known].mean()
    size = float(np.sqrt((x * x).sum() * (y * y).sum()))
    return float((x * y).sum() / size) if size > 0 else 0.0


def _box(values: FloatArray, window: tuple[int, int]) -> FloatArray:
    """Sums over a window around each value; values outside count as 0."""
    for axis, size in enumerate(window):
        total = np.cumsum(np.insert(values, 0, 0.0, axis=axis), axis=axis)
        here, length = np.arange(values.shape[axis]), values.shape[axis]
        low = np.clip(here - size // 2, 0, length)
        high = np.clip(here - size // 2 + size, 0, length)
        values = np.take(total, high, axis=axis) - np.take(total, low, axis=axis)
    return values
