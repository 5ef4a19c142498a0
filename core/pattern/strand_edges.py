"""Room for the strands' width where lines step back, so that a calibrated tone ends where it ends in the picture."""

from __future__ import annotations

import numpy as np

from ..contours.along_loops import steps
from ..contours.contours import Contours
from ..model import FloatArray
from ..ragged import following
from ..settings import PrintSettings

_LEAST_STEP = 0.01  # mm from one point to the next; less makes no visible difference


def widened(lines: Contours, printed: FloatArray, set_back: FloatArray, settings: PrintSettings) -> FloatArray:
    """Set-back that begins earlier, so that the strand's front edge, not only its middle, is back where it should be.

    A strand of width 2 r whose middle steps back with a slope m along the wall covers r·(√(1 + m²) − 1)/m more of the
    wall than it should, since its edge is a curve at the distance r. As with a milling cutter, the middle must go so
    that this edge is the one wanted; between one contour point and the next the edge is a slope.

    This is done for black lines only. Without it, bars of light between them are 0.2 mm too narrow; with it they have
    the right width. Where white lines step back, light lost between the black ones compensates: dark bars have the
    right width within 0.05 mm as they are.

    Args:
        lines: N contour points.
        printed: (N,) tone that the pattern is modulated by.
        set_back: (N,) mm.
        settings: pattern and calibration are used; without calibration, or with waves, nothing is changed.

    Returns:
        (N,) mm, nowhere less than before, and nowhere more than that of the neighbors or the room.
    """
    if settings.pattern != "offset" or settings.calibration == "none":
        return set_back
    after, step = following(lines.start), steps(set_back, lines.start)
    segment = np.flatnonzero((step > _LEAST_STEP) | (step < -_LEAST_STEP))
    rises = step.take(segment) > 0
    beyond = after.take(segment)
    # Black lines step back only where the print is to be lighter.
    black = np.flatnonzero(printed.take(np.where(rises, beyond, segment)) > 0.5)
    segment, shallow = segment.take(black), np.where(rises, segment, beyond).take(black)
    ahead = _ahead(lines.width.take(shallow) / 2, np.abs(step.take(segment)), lines.step.take(segment))
    back, wide = set_back.take(shallow), set_back.copy()
    np.maximum.at(wide, shallow, np.minimum(back + ahead, np.maximum(lines.room_inside.take(shallow), back)))
    return wide


def _ahead(radius: FloatArray, step: FloatArray, length: FloatArray) -> FloatArray:
    """(Q,) mm by which lines must be farther back at points beside deeper ones, to make room for their own width.

    Args:
        radius: (Q,) mm, half of the line's width.
        step: (Q,) mm, how much farther back it is at the deeper point.
        length: (Q,) mm, how far away that is along the line.
    """
    slope = step / np.maximum(length, 1e-9)
    touching = np.minimum(radius * slope / np.sqrt(1 + slope**2), length)
    return np.asarray(np.maximum(slope * touching - radius + np.sqrt(radius**2 - touching**2), 0.0))
