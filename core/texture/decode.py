"""Pixels and color attributes into tone: linear-light luminance, with alpha kept separately."""

from __future__ import annotations

import numpy as np

from ..errors import TextureError
from ..model import Float32Array, FloatArray, ToneImage

LUMINANCE = (0.2126, 0.7152, 0.0722)
"""Weights of linear red, green and blue in luminance (Rec. 709, which shares its primaries with sRGB)."""

_CHUNK_PIXELS = 1 << 16  # a chunk's intermediate arrays stay in the cache
_BYTE_TOLERANCE = 1e-3  # of a step of 1/255: float32 represents bytes within this


def linear_from_srgb(encoded: FloatArray) -> FloatArray:
    """Linear light of sRGB-encoded values, any shape; both sides 0 to 1 (IEC 61966-2-1, the piecewise curve)."""
    curved = ((np.maximum(encoded, 0.04045) + 0.055) / 1.055) ** 2.4
    linear: FloatArray = np.where(encoded <= 0.04045, encoded / 12.92, curved)
    return linear


def srgb_from_linear(linear: FloatArray) -> FloatArray:
    """The sRGB encoding of linear light, any shape; both sides 0 to 1, what lies outside is clipped."""
    light = np.clip(linear, 0.0, 1.0)
    encoded: FloatArray = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return encoded


def tone_image(pixels: Float32Array, encoded_srgb: bool, premultiplied: bool = False) -> ToneImage:
    """The tone of a picture.

    Colors are decoded to linear light before anything is averaged; alpha is never encoded. Values outside 0 to 1
    are clipped, pixels that are not finite count as unpainted.

    Args:
        pixels: (H, W, 4) red, green, blue, alpha, row 0 at the bottom.
        encoded_srgb: colors are sRGB-encoded; otherwise they are linear.
        premultiplied: the colors, as stored, were multiplied with alpha.

    Raises:
        TextureError: the picture has no pixels.
    """
    if pixels.ndim != 3 or pixels.shape[2] != 4 or not pixels.size:
        raise TextureError("a texture has no pixels", "load the picture again or choose another one")
    height, width = pixels.shape[:2]
    flat = pixels.reshape(-1, 4)
    tone = np.empty(height * width, dtype=np.float32)
    alpha = np.empty_like(tone)
    tables = _pair_tables() if encoded_srgb else None
    for start in range(0, len(flat), _CHUNK_PIXELS):
        part = slice(start, start + _CHUNK_PIXELS)
        tone[part], alpha[part] = _decoded(flat[part], tables, premultiplied)
    return ToneImage(tone.reshape(height, width), alpha.reshape(height, width))


def color_tone(rgba: FloatArray | Float32Array, background_tone: float) -> FloatArray:
    """Tone (N,) of linear colors (N, 4): luminance, blended by alpha over the background.

    Values outside 0 to 1 are clipped, colors that are not finite are the background.
    """
    colors = np.asarray(rgba, dtype=np.float64)
    finite = np.isfinite(colors).all(axis=1)
    colors = np.clip(np.where(finite[:, None], colors, 0.0), 0.0, 1.0)
    alpha = colors[:, 3]
    tone: FloatArray = colors[:, :3] @ np.array(LUMINANCE) * alpha + background_tone * (1 - alpha)
    return tone


def _pair_tables() -> tuple[Float32Array, Float32Array]:
    """Luminance (65536,) of each pair of 8-bit red and green, and (65536,) of blue for any alpha.

    A pair is the 16-bit number of its two bytes in native order; two look-ups per pixel instead of three.
    """
    pairs = np.arange(65536, dtype=np.uint16).view(np.uint8).reshape(-1, 2)
    red, green, blue = np.array(LUMINANCE)[:, None] * linear_from_srgb(np.arange(256) / 255.0)
    red_green: Float32Array = (red[pairs[:, 0]] + green[pairs[:, 1]]).astype(np.float32)
    blue_alpha: Float32Array = blue[pairs[:, 0]].astype(np.float32)
    return red_green, blue_alpha


def _decoded(
    pixels: Float32Array, tables: tuple[Float32Array, Float32Array] | None, premultiplied: bool
) -> tuple[Float32Array, Float32Array]:
    """Tone and alpha (n,) of pixels (n, 4); `tables` are given for sRGB-encoded ones."""
    if tables is not None and not premultiplied:
        tone = _byte_luminance(pixels, tables)
        if tone is not None:
            return tone, np.clip(pixels[:, 3], 0.0, 1.0)
    finite = np.isfinite(pixels).all(axis=1)
    pixels = np.where(finite[:, None], pixels, np.float32(0.0))
    alpha = np.clip(pixels[:, 3], 0.0, 1.0)
    colors = pixels[:, :3]
    if premultiplied:
        with np.errstate(over="ignore"):  # clipped below
            colors = colors / np.where(alpha > 0, alpha, 1.0)[:, None]
    red, green, blue = np.clip(colors, 0.0, 1.0).T
    if tables is not None:
        red, green, blue = (linear_from_srgb(channel.astype(np.float64)) for channel in (red, green, blue))
    tone = LUMINANCE[0] * red + LUMINANCE[1] * green + LUMINANCE[2] * blue
    return tone.astype(np.float32, copy=False), alpha


def _byte_luminance(pixels: Float32Array, tables: tuple[Float32Array, Float32Array]) -> Float32Array | None:
    """Luminance (n,) of encoded pixels (n, 4) that are all whole multiples of 1/255, None where any is not."""
    with np.errstate(over="ignore"):  # an infinite number of steps is no byte either
        steps = np.multiply(pixels, np.float32(255.0), order="C")
    if not (steps.min() > -_BYTE_TOLERANCE and steps.max() < 255.0 + _BYTE_TOLERANCE):  # false for NaN as well
        return None
    nearest = np.rint(steps)
    steps -= nearest
    if max(steps.max(), -steps.min()) > _BYTE_TOLERANCE:
        return None
    pairs = nearest.astype(np.uint8).view(np.uint16)
    luminance: Float32Array = tables[0][pairs[:, 0]]
    luminance += tables[1][pairs[:, 1]]
    return luminance
