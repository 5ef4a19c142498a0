"""Gray pictures from colored ones: channel mix, levels, automatic contrast."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..errors import TextureError
from ..model import Float32Array
from ..records import dataclass
from .decode import LUMINANCE, linear_from_srgb, srgb_from_linear

MOST_CLIPPED = 0.005
"""Share of the pixels at either end that automatic contrast may clip to black or white."""

_BAND_PIXELS = 1 << 18


@dataclass(frozen=True)
class Grade:
    """How a colored picture becomes a gray one.

    Attributes:
        mix: weights of red, green and blue in linear light; only their ratios count.
        black, white: gray values, as a picture editor shows them (0 to 1, sRGB), that become black and white.
        gamma: above 1 lightens the middle.
        auto_contrast: find black and white in the picture instead.
    """

    mix: tuple[float, float, float] = LUMINANCE
    black: float = 0.0
    white: float = 1.0
    gamma: float = 1.0
    auto_contrast: bool = True


def graded(rgba: Float32Array, grade: Grade, encoded_srgb: bool = False, premultiplied: bool = False) -> Float32Array:
    """(H, W) gray of a picture, sRGB-encoded, 0 to 1.

    Args:
        rgba: (H, W, 4) as stored; what is not painted at all does not count for automatic contrast.
        grade: channel mix, levels, gamma and contrast.
        encoded_srgb: the colors are sRGB-encoded; otherwise they are linear.
        premultiplied: they are multiplied by alpha.

    Raises:
        TextureError: the mix has no positive weight, or black is not darker than white.
    """
    weights = np.array(grade.mix, dtype=np.float64)
    if not weights.sum() > 0:
        raise TextureError("the channel mix adds up to nothing", "give red, green or blue a positive weight")
    weights = (weights / weights.sum()).astype(np.float32)
    gray = np.empty(rgba.shape[:2], dtype=np.float32)
    for band in bands(rgba):
        gray[band] = srgb_from_linear(linear_colors(rgba[band], encoded_srgb, premultiplied) @ weights)
    painted = rgba[..., 3] > 0
    black, white = grade.black, grade.white
    if grade.auto_contrast and painted.any():
        black, white = np.quantile(gray[painted], [MOST_CLIPPED, 1.0 - MOST_CLIPPED]).tolist()
        if white - black < 1 / 255:  # an even picture has no contrast to stretch
            black, white = 0.0, 1.0
    if black >= white:
        raise TextureError("the black level is not below the white level", "move the levels apart")
    for band in bands(rgba):
        gray[band] = np.clip((gray[band] - black) / (white - black), 0.0, 1.0) ** (1.0 / grade.gamma)
    return gray


def bands(pixels: Float32Array) -> Iterator[slice]:
    """Rows of a picture, so many at a time that what is computed of them takes little beside the picture itself."""
    rows = max(_BAND_PIXELS // max(pixels.shape[1], 1), 1)
    return (slice(row, row + rows) for row in range(0, len(pixels), rows))


def linear_colors(rgba: Float32Array, encoded_srgb: bool, premultiplied: bool = False) -> Float32Array:
    """(H, W, 3) linear colors, 0 to 1, of stored pixels (H, W, 4); what is not finite is black."""
    colors = np.nan_to_num(rgba[..., :3], nan=0.0, posinf=1.0, neginf=0.0)
    if premultiplied:
        colors = colors / np.maximum(rgba[..., 3:], 1e-6)
    colors = np.clip(colors, 0.0, 1.0)
    return linear_from_srgb(colors).astype(np.float32) if encoded_srgb else colors.astype(np.float32)
