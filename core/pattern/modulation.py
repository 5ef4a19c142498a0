"""Tone → shape: how deep each colour's wave is and how far its line is set back (paper, sections 3.1 and 5)."""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, FloatArray
from ..settings import PrintSettings


def shape(tone: FloatArray, is_black: BoolArray, settings: PrintSettings) -> tuple[FloatArray, FloatArray]:
    """Wave depth and set-back for the tones of one or both colours.

    At tone ½ both colours stand alike. Above it the black strands are attenuated, below it the white ones: their
    wave gets shallower (`wave`), or their whole line steps back behind the surface (`offset`), or both.

    Args:
        tone: (N,) 0 black to 1 white.
        is_black: (N,) whether the strand is black.
        settings: pattern, wave_depth_max, wave_depth_min and offset_max are used.

    Returns:
        (N,) depth in mm, peak to peak, and (N,) set-back in mm.
    """
    attenuation = np.clip(np.where(is_black, 2 * tone - 1, 1 - 2 * tone), 0.0, 1.0)
    set_back = attenuation * settings.offset_max
    if settings.pattern == "offset":
        return np.zeros_like(tone), set_back
    depth = settings.wave_depth_max - attenuation * (settings.wave_depth_max - settings.wave_depth_min)
    return depth, np.zeros_like(tone) if settings.pattern == "wave" else set_back


def faded(
    depth: FloatArray, set_back: FloatArray, room_inside: FloatArray, room_outside: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Less of both where a wave would meet itself, the opposite wall or its neighbour.

    Args:
        depth: (N,) mm, peak to peak.
        set_back: (N,) mm.
        room_inside: (N,) mm that the line can move inwards.
        room_outside: (N,) mm that it can move outwards.

    Returns:
        depth and set-back with depth / 2 <= room_outside and depth / 2 + set_back <= room_inside.
    """
    set_back = np.minimum(set_back, room_inside)
    return np.minimum(depth, 2 * np.minimum(room_outside, room_inside - set_back)), set_back


def layer_sign(layer: np.ndarray[tuple[int, ...], np.dtype[np.int64]]) -> FloatArray:
    """+1 or −1 for each layer: + − − +, so that the phase flips after every pair (paper, section 3.1)."""
    return np.where((layer + 1) // 2 % 2 == 0, 1.0, -1.0)


def layer_is_black(layer: np.ndarray[tuple[int, ...], np.dtype[np.int64]]) -> BoolArray:
    """Whether each layer is printed with the black filament: the even ones are."""
    return np.asarray(layer % 2 == 0)
