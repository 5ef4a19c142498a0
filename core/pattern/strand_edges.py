"""Room for the strands' width where lines step back: a calibrated tone ends where it ends in the picture."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray, IntArray
from ..settings import PrintSettings
from ..slicing.outlines import following
from .contours import Contours

_LEAST_STEP = 0.01  # mm from one point to the next; less makes no difference to be seen


def widened(lines: Contours, printed: FloatArray, set_back: FloatArray, settings: PrintSettings) -> FloatArray:
    """Set-back that begins earlier, so that the strand's front and not only its middle is back where it should be.

    A strand as wide as 2 r whose middle steps back with a slope m along the wall covers r·(√(1 + m²) − 1)/m more of
    the wall than it should: the front of all that it sweeps is a curve at the distance r. As in milling, the middle
    must go so that this front is the one wanted; between one point of the contour and the next that is a slope.

    Only black lines do. Bars of light between them, read by the instrument, lack 0.2 mm without it, and have their
    width with it. Where white lines step back, light that is lost between the black ones makes up for it by itself:
    those bars have their width within 0.05 mm as they are.

    Args:
        lines: N contour points.
        printed: (N,) tone that the pattern is modulated by.
        set_back: (N,) mm.
        settings: pattern and calibration are used; without calibration, and where there are waves, nothing is done.

    Returns:
        (N,) mm, nowhere less, and nowhere more than the neighbours' or the room.
    """
    if settings.pattern != "offset" or settings.calibration == "none":
        return set_back
    after = following(lines.start)
    step = set_back[after] - set_back
    wide = set_back.copy()
    rising, falling = np.flatnonzero(step > _LEAST_STEP), np.flatnonzero(step < -_LEAST_STEP)
    for shallow, deep in ((rising, after[rising]), (after[falling], falling)):
        black = printed[deep] > 0.5  # only then does a black line step back
        shallow, deep = shallow[black], deep[black]
        wide[shallow] = np.maximum(wide[shallow], set_back[shallow] + _ahead(lines, set_back, shallow, deep))
    return np.minimum(wide, np.maximum(lines.room_inside, set_back))


def _ahead(lines: Contours, set_back: FloatArray, shallow: IntArray, deep: IntArray) -> FloatArray:
    """(Q,) mm that a line must be farther back at some points to make room for its own width beside deeper ones."""
    radius = lines.width[shallow] / 2
    length = np.hypot(*(lines.points[deep] - lines.points[shallow]).T)
    slope = (set_back[deep] - set_back[shallow]) / np.maximum(length, 1e-9)
    touching = np.minimum(radius * slope / np.sqrt(1 + slope**2), length)
    return np.asarray(np.maximum(slope * touching - radius + np.sqrt(radius**2 - touching**2), 0.0))
