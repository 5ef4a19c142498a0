"""Polylines with fewer points, within a tolerance: long chords instead of many short ones, for all lines in step."""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..ragged import ranges

# Points of the pieces into which lines are cut, about, and how many of these are walked along at once.
PIECE_POINTS, PIECES_AT_ONCE = 64, 1 << 13


def chord_ends(points: FloatArray, first: IntArray, count: IntArray, last: IntArray, tolerance: float) -> BoolArray:
    """Choose the points to keep: all others are within the tolerance of the chord that replaces them.

    A chord grows point by point, as long as there is a direction that passes all of them (the sleeve of Zhao and
    Saalfeld, Linear-time sleeve-fitting polyline simplification algorithms, 1997) and they lie ahead of one another.

    Args:
        points: (2, N) mm.
        first: (L,) index of each line's first point.
        count: (L,) how many points follow there, that one included.
        last: (L,) index of the point in which it ends after these; it may be the first one.
        tolerance: mm.

    Returns:
        (N,) bool; both ends of every line remain.
    """
    keep = np.zeros(points.shape[1], dtype=bool)
    parts = -(-count // PIECE_POINTS)
    part, line = ranges(0, parts), np.repeat(np.arange(len(parts)), parts)
    count, parts, first = count[line], parts[line], first[line]
    begin, end = first + part * count // parts, first + (part + 1) * count // parts
    stop = np.where(part + 1 == parts, last[line], end)
    keep[begin] = keep[stop] = True
    order = np.argsort(begin - end, kind="stable")
    for at in range(0, len(order), PIECES_AT_ONCE):
        some = order[at : at + PIECES_AT_ONCE]
        _walk(points, begin[some], (end - begin)[some], stop[some], tolerance, keep)
    return keep


@np.errstate(divide="ignore", invalid="ignore")  # of slopes off what is not ahead, where a chord ends anyway
def _walk(
    points: FloatArray, begin: IntArray, count: IntArray, stop: IntArray, tolerance: float, keep: BoolArray
) -> None:
    """Mark the ends of chords within pieces of lines, the longest piece first; see `chord_ends`."""
    index = np.minimum(begin + np.arange(count[0] + 1)[:, None], points.shape[1] - 1)
    index[count, np.arange(len(count))] = stop
    ends = np.zeros(index.shape, dtype=bool)
    x, y = points[0].take(index), points[1].take(index)
    state = _chord(x[:2], y[:2], tolerance)
    going = np.searchsorted(-count, -np.arange(2, count[0] + 1), side="right")
    for row, pieces in enumerate(going.tolist(), 1):
        from_x, from_y, along_x, along_y, far, reach, most, least = (values[:pieces] for values in state)
        off_x, off_y = x[row + 1, :pieces] - from_x, y[row + 1, :pieces] - from_y
        ahead = off_x * along_x
        ahead += off_y * along_y
        slope = off_y * along_x
        slope -= off_x * along_y
        slope /= ahead
        ended = np.flatnonzero((ahead < far) | (slope > most) | (slope < least))
        beside = np.divide(reach, ahead, out=off_x)
        np.minimum(most, np.add(slope, beside, out=off_y), out=most)
        np.maximum(least, np.subtract(slope, beside, out=slope), out=least)
        far[:] = ahead
        begun = _chord(x[row : row + 2].take(ended, axis=1), y[row : row + 2].take(ended, axis=1), tolerance)
        for values, anew in zip(state, begun, strict=True):
            values[ended] = anew
        ends[row, ended] = True
    keep[index[ends]] = True


def _chord(x: FloatArray, y: FloatArray, tolerance: float) -> list[FloatArray]:
    """From where chords start that begin with one step (2, P), and which further ones may follow.

    Returns:
        (P,) x and y of the start, x and y of the step, how far it goes in its own direction, the tolerance, both times
        the step's length, and the greatest and the least slope off it of what may follow.
    """
    along_x, along_y = x[1] - x[0], y[1] - y[0]
    far = along_x * along_x + along_y * along_y
    far[far == 0] = np.inf  # nothing is ahead of a step that leads nowhere
    reach = tolerance * np.sqrt(far)
    most = reach / far
    return [x[0].copy(), y[0].copy(), along_x, along_y, far, reach, most, -most]
