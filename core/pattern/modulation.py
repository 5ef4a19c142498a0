"""Tone → shape: how deep each color's wave is and how far its line is set back (paper, sections 3.1 and 5)."""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..settings import PrintSettings

PERIOD_LAYERS = 4
"""Layers after which the pattern repeats: two colors times two phases."""

_DEEPEST = 3.0  # mm, deepest wave in the table of reaches


def shape(tone: FloatArray, is_black: BoolArray, settings: PrintSettings) -> tuple[FloatArray, FloatArray]:
    """Wave depth and set-back for the tones of one or both colors.

    At tone ½ both colors have the same shape. Above it the black strands are attenuated, below it the white ones:
    their wave gets shallower (`wave`), or their whole line is set back behind the surface (`offset`), or both
    (`wave_offset`), where the set-back begins at the attenuation `offset_onset`.

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
    """Reduce both where a strand would protrude over the one below by more than `max_unsupported`.

    The strand above a set-back one protrudes by the set-back, a strand on an overhanging slope by the step from layer
    to layer; their sum counts. Waves of opposite phase protrude by less than their depth, since the strand below
    passes by on both sides (`wave_reach`).

    Args:
        depth: (N,) mm, peak to peak.
        set_back: (N,) mm.
        slant_deg: (N,) of the surface: 0 upright, towards 90 it looks up, towards -90 down.
        settings: max_unsupported, the extrusion width, the layer height and the least wavelength are used.
    """
    upright = settings.max_unsupported + settings.extrusion_width / 2
    if settings.pattern == "offset":
        # Only steeper overhangs than this have too little room.
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
    """(N,) mm that strands may protrude on slopes, where `upright` is allowed on an upright wall."""
    step = settings.layer_height * np.tan(np.radians(np.clip(-slant_deg, -89.0, 89.0)))
    return np.asarray(np.maximum(upright - step, 0.0))


def wave_reach(depth: FloatArray, wavelength: float) -> FloatArray:
    """Greatest distance of a wave's peak from the wave below it, which has the opposite phase and any smaller depth.

    Args:
        depth: (D,) mm, peak to peak, ascending from 0.
        wavelength: mm.

    Returns:
        (D,) mm, ascending; the depth itself for shallow waves, at most half the wavelength.
    """
    peak = depth[:, None, None] / 2
    along = np.linspace(0.0, wavelength / 2, 61)
    below = -peak * np.linspace(0.0, 1.0, 21)[:, None] * np.cos(2 * np.pi / wavelength * along)
    nearest = np.sqrt((along**2 + (peak - below) ** 2).min(axis=2))
    return np.asarray(np.maximum.accumulate(nearest.max(axis=1)))


def faded(
    depth: FloatArray, set_back: FloatArray, room_inside: FloatArray, room_outside: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Reduce both where a wave would meet itself, the opposite wall or its neighbor.

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
        Radians: 0 for black layers, for white ones another eighth of a wave in each band of `phase_shift_layers`.
    """
    eighths = layer // settings.phase_shift_layers % 8
    return np.where(layer_is_black(layer, settings), 0.0, eighths * (np.pi / 4))


def layer_is_black(layer: IntArray, settings: PrintSettings) -> BoolArray:
    """Whether each layer is printed with the black filament: even layers, or one or three out of four.

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
