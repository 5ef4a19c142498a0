"""From pictures of a tile to one number per tone: local averages over whole periods of the pattern (paper, 6.1)."""

from __future__ import annotations

import numpy as np

from ..model import Float32Array, FloatArray


def read_tones(
    first: Float32Array, second: Float32Array, mm_per_pixel: float, place: FloatArray, window: float
) -> tuple[FloatArray, FloatArray]:
    """The reflectance read for each tone, and its standard error.

    All rows count the same, as the picture is whole periods high. Along the layers triangular weights as wide as the
    window, two periods or more, remove the pattern's own wavelength and shorter ones.

    Args:
        first: (H, W) linear, foreshortening undone; NaN where there is nothing.
        second: the same with other noise.
        mm_per_pixel: along the rows.
        place: (T,) mm from the middle of the picture, to the right.
        window: mm.

    Returns:
        (T,) mean of both pictures, NaN where there is nothing to read, and (T,) its standard error from the noise.
    """
    pixels = first.shape[1]
    at = (np.arange(pixels) + 0.5 - pixels / 2) * mm_per_pixel
    weight = np.clip(1.0 - np.abs(at - place[:, None]) / (window / 2), 0.0, None)
    both = (first.astype(np.float64) + second) / 2
    seen = np.isfinite(both)
    rows = seen.sum(axis=0)
    total = np.where(seen, both, 0.0).sum(axis=0)
    noise = np.where(seen, first.astype(np.float64) - second, 0.0) ** 2 / 4
    count = weight @ rows
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(count > 0, (weight @ total) / count, np.nan)
        error = np.where(count > 0, np.sqrt(weight**2 @ noise.sum(axis=0)) / count, np.nan)
    return mean, error
