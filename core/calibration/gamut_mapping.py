"""From a picture's tones to what a wall can show, and to the tones to print for that (paper, section 6.2)."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray
from ..records import dataclass
from ..settings import PrintSettings
from .table import ToneTable, slope_shares

WHOLE_RANGE = (0.0, 1.0)
_SPECK_MM2, _SPECK_SHARE = 1.0, 0.001
_RANGE_STEPS = 256  # of the darkest and the lightest tone
_LEAST_SHARED = 0.75  # least share of a slope's range, or of the target range if that is smaller, that is used


@dataclass(frozen=True)
class PrintableTones:
    """Tables from the tones asked for to target, printed and seen ones. S slopes, K tones.

    Attributes:
        tone: (K,) asked for.
        slant_deg: (S,) slope of the wall, 0 upright.
        target: (S, K) linear reflectance wanted, which may be out of the wall's reach.
        printed: (S, K) tone that the pattern is modulated by, 0 to 1; what `modulation.shape` takes.
        seen: (S, K) linear reflectance of the printed wall, face on.
    """

    tone: FloatArray
    slant_deg: FloatArray
    target: FloatArray
    printed: FloatArray
    seen: FloatArray


def printable_tones(
    tones: FloatArray,
    slant_deg: FloatArray,
    table: ToneTable,
    image_range: tuple[float, float],
    settings: PrintSettings,
) -> PrintableTones:
    """What the job makes of tones on walls of some slopes, as tables to interpolate.

    To predict a print, take `calibrate.table_for(settings)`, the `image_range` of the tones on the surface, and evenly
    spaced tones and slopes, and interpolate `seen` between its four nearest entries. The job interpolates `printed` in
    the same way.

    Args:
        tones: (K,) asked for, 0 black to 1 white.
        slant_deg: (S,) of the walls, 0 upright, 90 looking up; overhangs count as upright.
        table: of the pattern.
        image_range: from `image_range`, of everything printed together.
        settings: calibration and gamut_mapping are used; with `none` the tones are printed as they are.
    """
    slants = np.clip(np.asarray(slant_deg, dtype=np.float64), table.slant_deg[0], table.slant_deg[-1])
    tones = np.asarray(tones, dtype=np.float64)
    known = table.upright if settings.calibration == "upright" else table
    target = targets(known, settings.gamut_mapping, tones, image_range)
    printed = np.tile(tones, (len(target), 1)) if settings.calibration == "none" else known.printed(target)
    shares = slope_shares(known.slant_deg, slants)
    target, printed = shares @ target, shares @ printed
    return PrintableTones(tones, slants, target, printed, table.seen(printed, slants))


def image_range(tone: FloatArray, area_mm2: FloatArray | float) -> tuple[float, float]:
    """The darkest and the lightest tone of a picture on a surface, specks left out.

    At least a square millimeter of the surface, or a thousandth of it if that is less, is as dark or as light: a broken
    or blown-out pixel does not count, a word of fine print does. Both are told in steps of 1/256, outwards, so that a
    stroke somewhere hardly ever changes the tones of all the rest.

    Args:
        tone: (N,) asked for at points all over the surface.
        area_mm2: (N,) of the surface that each point stands for, or one for all.

    Returns:
        Both, the darkest first; `WHOLE_RANGE` if there are no places.
    """
    if not len(tone):
        return WHOLE_RANGE
    if isinstance(area_mm2, np.ndarray):
        order = np.argsort(tone)
        covered = np.cumsum(area_mm2[order])
        speck = min(_SPECK_MM2, _SPECK_SHARE * float(covered[-1]))
        low, high = np.searchsorted(covered, [speck, covered[-1] - speck], side="left")
        ends = tone[order[[min(low, len(order) - 1), min(high, len(order) - 1)]]]
    else:
        speck = min(_SPECK_MM2 / area_mm2, _SPECK_SHARE * len(tone))
        rank = [int(speck), len(tone) - 1 - int(speck)]
        ends = np.partition(tone, rank)[rank]
    low_step, high_step = np.clip(ends, 0.0, 1.0) * _RANGE_STEPS
    darkest, lightest = float(np.floor(low_step)) / _RANGE_STEPS, float(np.ceil(high_step)) / _RANGE_STEPS
    return darkest, max(darkest, lightest)


def targets(table: ToneTable, mapping: str, tone: FloatArray, image_range: tuple[float, float]) -> FloatArray:
    """(S, K) the reflectance wanted for each tone asked for, on each slope of the table.

    `compress` maps the picture's darkest and lightest tone, and all others evenly between them, to the darkest and
    lightest that an upright wall can print, so that equal tones look equal on every slope as far as possible. It never
    stretches: contrast is at most that of the plastics themselves, and a picture with less contrast than the wall can
    show keeps its relative position between dark and light. On a slope with another range all tones are made lighter
    or darker, just enough to use most of that range. `clip` takes tones as reflectances between those of the
    plastics. Targets out of reach print as the nearest tone.

    Args:
        table: of which the least slope sets the printable range.
        mapping: "compress" or "clip".
        tone: (K,) 0 to 1.
        image_range: the picture's darkest and lightest tone, for `compress`; `WHOLE_RANGE` spreads all tones evenly.
    """
    plastic_black, plastic_white = table.provenance.reflectance["Black"], table.provenance.reflectance["White"]
    if mapping == "clip":
        return np.tile(plastic_black + tone * (plastic_white - plastic_black), (len(table.slant_deg), 1))
    low, high = table.reflectance[:, :1], table.reflectance[:, -1:]
    room = float(high[0, 0] - low[0, 0])
    darkest, lightest = image_range
    span = min(room, (lightest - darkest) * (plastic_white - plastic_black))
    rest = 1.0 - (lightest - darkest)
    black = float(low[0, 0]) + (darkest / rest * (room - span) if rest > 0 else 0.0)
    place = (np.clip(tone, darkest, lightest) - darkest) / max(lightest - darkest, 1e-9)
    shared = _LEAST_SHARED * np.minimum(span, high - low)
    lighter = np.maximum(low + shared - (black + span), 0.0)
    darker = np.maximum(black + shared - high, 0.0)
    return np.asarray(black + place * span + lighter - darker)
