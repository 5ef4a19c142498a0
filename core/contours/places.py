"""Places on the contours, by their arcs, and averages along them."""

from __future__ import annotations

import numpy as np

from ..lookup import Lookup
from ..model import BoolArray, FloatArray, IntArray
from ..ragged import ranges
from .along_loops import box, filtered
from .contours import Contours


def on_loop(arc: FloatArray, loop: IntArray, arc_start: FloatArray) -> FloatArray:
    """Move arcs at the very end of their loop to its beginning, the same place: rounding puts them on the next loop.

    The arcs themselves are changed.
    """
    over = np.flatnonzero(arc >= arc_start.take(loop + 1) - 1e-9)
    arc[over] = arc_start[loop[over]]
    return arc


def loop_of(lines: Contours, arc: FloatArray) -> IntArray:
    """(Q,) the contour on which each place lies."""
    return np.maximum(Lookup(lines.arc_start[:-1]).before(arc), 0)


def long_enough(length: FloatArray, wavelength: float) -> BoolArray:
    """(M,) which lines of these lengths, mm, hold the pattern: two samples at least."""
    return np.asarray(length >= 2 * wavelength)


def average_along_wall(values: FloatArray, lines: Contours, window: float) -> FloatArray:
    """Average values (N,), such as tones, along each contour over about `window` mm."""
    step = lines.length / np.maximum(np.diff(lines.start), 1)
    usual = float(np.median(step)) if len(step) else 1.0
    reach = round((window / usual - 1) / 2)
    if reach < 1:
        return values
    return filtered(values, lines.start, box(reach))


def places(lines: Contours, spacing: float) -> tuple[FloatArray, IntArray]:
    """Evenly spaced places on all contours, about `spacing` mm apart: their arcs (Q,) and loops (Q,)."""
    count = np.maximum(np.round(lines.length / spacing), 1).astype(np.int64)
    loop = np.repeat(np.arange(len(count)), count)
    step = ranges(0, count)
    return lines.arc_start[loop] + (step + 0.5) * (lines.length / count)[loop], loop
