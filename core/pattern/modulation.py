"""Tone → shape: how deep each colour's wave is and how far its line is set back (paper, sections 3.1 and 5)."""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..settings import PrintSettings

PERIOD_LAYERS = 4
"""After so many layers the pattern repeats: two colours, two phases."""

_DEEPEST = 3.0  # mm, of the waves whose reach is worked out


def shape(tone: FloatArray, is_black: BoolArray, settings: PrintSettings) -> tuple[FloatArray, FloatArray]:
    """Wave depth and set-back for the tones of one or both colours.

    At tone ½ both colours stand alike. Above it the black strands are attenuated, below it the white ones: their
    wave gets shallower (`wave`), or their whole line steps back behind the surface (`offset`), or both, the line from
    the attenuation `offset_onset` on.

    Args:
        tone: (N,) 0 black to 1 white.
        is_black: (N,) whether the strand is black.
        settings: pattern, wave_depth_max, wave_depth_min, offset_max and offset_onset are used.

    Returns:
        (N,) depth in mm, peak to peak, and (N,) set-back in mm.
    """
    attenuation = 2.0 * tone - 1.0
    np.negative(attenuation, out=attenuation, where=~is_black)
    np.clip(attenuation, 0.0, 1.0, out=attenuation)
    onset = settings.offset_onset
    set_back = np.maximum(attenuation - onset, 0.0) * (settings.offset_max / (1.0 - onset))
    if settings.pattern == "offset":
        return np.zeros(tone.shape), set_back
    depth = settings.wave_depth_max - attenuation * (settings.wave_depth_max - settings.wave_depth_min)
    return depth, np.zeros_like(tone) if settings.pattern == "wave" else set_back


def supported(
    depth: FloatArray, set_back: FloatArray, slant_deg: FloatArray, settings: PrintSettings
) -> tuple[FloatArray, FloatArray]:
    """Less of both where a strand would stand out farther over the one below than `max_unsupported`.

    A set-back strand leaves the one above it standing out by as much, and so does a slope that overhangs, by its step
    from layer to layer; it is the sum that counts. Waves of opposite phase stand out less than their depth, for the
    strand below passes by on both sides (`wave_reach`).

    Args:
        depth: (N,) mm, peak to peak.
        set_back: (N,) mm.
        slant_deg: (N,) of the surface: 0 upright, towards 90 it looks up, towards -90 down.
        settings: max_unsupported, the extrusion width, the layer height and the least wavelength are used.
    """
    upright = settings.max_unsupported + settings.extrusion_width / 2
    if settings.pattern == "offset":
        # Only what overhangs farther than this has too little room.
        enough = np.degrees(np.arctan((upright - set_back.max(initial=0.0)) / settings.layer_height))
        steep = np.flatnonzero(slant_deg < -enough)
        set_back = set_back.copy()
        set_back[steep] = np.minimum(set_back[steep], _room(upright, slant_deg[steep], settings))
        return depth, set_back
    room = _room(upright, slant_deg, settings)
    depths = np.linspace(0.0, _DEEPEST, 121)
    reach = wave_reach(depths, settings.wavelength)
    depth = np.minimum(depth, np.interp(room, reach, depths))
    return depth, np.minimum(set_back, room - np.interp(depth, depths, reach))


def _room(upright: float, slant_deg: FloatArray, settings: PrintSettings) -> FloatArray:
    """(N,) mm, what slopes leave of how far strands may stand out of an upright wall."""
    step = settings.layer_height * np.tan(np.radians(np.clip(-slant_deg, -89.0, 89.0)))
    return np.asarray(np.maximum(upright - step, 0.0))


def wave_reach(depth: FloatArray, wavelength: float) -> FloatArray:
    """How far the peak of a wave lies from the wave below it, of opposite phase and any smaller depth, at most.

    Args:
        depth: (D,) mm, peak to peak, ascending from 0.
        wavelength: mm.

    Returns:
        (D,) mm, ascending; as much as the depth of a shallow wave, at most half the wavelength.
    """
    peak = depth[:, None, None] / 2
    along = np.linspace(0.0, wavelength / 2, 61)
    below = -peak * np.linspace(0.0, 1.0, 21)[:, None] * np.cos(2 * np.pi / wavelength * along)
    nearest = np.sqrt((along**2 + (peak - below) ** 2).min(axis=2))
    return np.asarray(np.maximum.accumulate(nearest.max(axis=1)))


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


def layer_sign(layer: IntArray) -> FloatArray:
    """+1 or −1 for each layer: + − − +, so that the phase flips after every pair (paper, section 3.1)."""
    return np.where((layer + 1) // 2 % 2 == 0, 1.0, -1.0)


def layer_shift(layer: IntArray, settings: PrintSettings) -> FloatArray:
    """How far the waves of each layer are shifted where white ones are shifted against black ones (paper, Figure 3c).

    Args:
        layer: numbers of layers.
        settings: phase_shift_layers, above 0, mostly_white_below and mostly_black_above are used.

    Returns:
        Radians: 0 for black layers, for white ones an eighth of a wave more in each band of so many layers.
    """
    eighths = layer // settings.phase_shift_layers % 8
    return np.where(layer_is_black(layer, settings), 0.0, eighths * (np.pi / 4))


def layer_is_black(layer: IntArray, settings: PrintSettings) -> BoolArray:
    """Whether each layer is printed with the black filament: the even ones are, or one or three of four.

    Args:
        layer: numbers of layers, the object's own first one 0.
        settings: mostly_white_below and mostly_black_above are used (paper, Figure 3a).
    """
    is_black = layer % 2 == 0
    if settings.mostly_white_below:
        is_black = is_black & ((layer >= settings.mostly_white_below) | (layer % PERIOD_LAYERS == 0))
    if settings.mostly_black_above:
        is_black = is_black | ((layer >= settings.mostly_black_above) & (layer % PERIOD_LAYERS == 3))
    return np.asarray(is_black)
