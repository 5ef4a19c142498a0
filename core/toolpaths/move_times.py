"""How long each move of a print takes, as the firmware plans it, and when each layer begins."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model import BoolArray, FloatArray, IntArray
from ..parallel import in_chunks
from ..records import dataclass
from ..settings.printer import Four, PrinterProfile
from .moves import Moves

_SHORTEST_MM = 1e-9
_ROWS = 1 << 15  # worked on at once; with fewer, a thread that writes text beside this is waited for more often
_SUMMABLE = float(1 << 14)  # parts of a mm²/s²


@dataclass(frozen=True)
class _Segments:
    """The rows of the moves that take time, S of them.

    Attributes:
        takes: (M,) bool, which of the moves they are.
        length: (S,) float64 mm, of the way or else of the filament.
        speed: (S,) float64 mm/s that the axes allow.
        acceleration: (S,) float64 mm/s² that the axes allow.
        corner: (S,) float64 mm²/s², the greatest squared speed between a segment and the next one; 0 at the last.
    """

    takes: BoolArray
    length: FloatArray
    speed: FloatArray
    acceleration: FloatArray
    corner: FloatArray


def move_seconds(moves: Moves, printer: PrinterProfile) -> FloatArray:
    """(M,) s that each row takes, by trapezoids as the firmware plans them.

    Speeds at the corners obey the instant speed change of each axis, that of the filament included, accelerations
    those of the axes, and the printer can always stop at the end of its queue of moves. It stands still at tool
    changes, where the carriage shifts from nozzle to nozzle. That a short queue slows the firmware down does not
    appear here: `speeds.py` gives every line the time that it needs to stay filled.
    """
    seconds = np.zeros(len(moves.tool))
    if not len(seconds):
        return seconds
    segments = _segments(moves, printer)
    if len(segments.length):
        u = _node_speeds_squared(segments, printer)
        columns = segments.length, segments.speed, segments.acceleration, u[:-1], u[1:]
        (seconds[segments.takes],) = in_chunks(_trapezoid_seconds, *columns, rows=_ROWS, threads=False)
    seconds[1:][moves.tool[1:] != moves.tool[:-1]] += shift_seconds(printer)
    return seconds


def shift_seconds(printer: PrinterProfile) -> float:
    """s in which the carriage shifts from nozzle to nozzle at a change of the tool."""
    return printer.nozzle_distance_mm / (printer.travel_mm_min / 60)


def layer_changes(layer: IntArray) -> BoolArray:
    """(M,) rows that begin a layer; `layer` (M,) of each row does not decrease."""
    begins = np.ones(len(layer), dtype=bool)
    begins[1:] = layer[1:] != layer[:-1]
    return begins


def layer_begins(moves: Moves, seconds: FloatArray) -> FloatArray:
    """(L + 1,) s that have passed when each of the L layers begins that have moves, and in the end.

    Args:
        moves: the print.
        seconds: (M,) `move_seconds` of the moves.
    """
    if not len(seconds):
        return np.zeros(1)
    taken = np.add.reduceat(seconds, np.flatnonzero(layer_changes(moves.layer)))
    return np.concatenate([[0.0], np.cumsum(taken)])


def _segments(moves: Moves, printer: PrinterProfile) -> _Segments:
    """The rows that move or feed; the first row does not move, since nothing says where the nozzle was."""
    count, end, tips = len(moves.tool), 0, []
    takes, columns = np.empty(count, dtype=bool), np.empty((4, count))
    for row in range(0, count, _ROWS):
        here = slice(row, min(row + _ROWS, count))
        takes[here], measured, tip = _measured(moves, printer, here)
        begin, end = end, end + len(measured[0])
        for column, part in zip(columns, measured, strict=True):
            column[begin:end] = part
        tips.append(tip)
    length, speed, acceleration, corner = columns[:, :end]
    # What lies between the last segment of a chunk and the first one of the next.
    between = np.flatnonzero(np.isnan(corner))
    tool, reached, *direction = (np.concatenate(tip)[1:] for tip in zip(*tips, strict=True))
    beyond = _corner_speeds_squared(tool, reached, np.array(direction))[::2]
    corner[between] = np.append(beyond, 0.0)[: len(between)]
    return _Segments(takes, length, speed, acceleration, corner)


def _measured(
    moves: Moves, printer: PrinterProfile, here: slice
) -> tuple[BoolArray, tuple[FloatArray, ...], list[NDArray[Any]]]:
    """The columns of `_Segments` for some rows that follow each other, without those that take no time.

    The last corner is not known yet, NaN; what it takes of the first and the last segment comes after the columns,
    as for `_corner_speeds_squared`, axis by axis.
    """
    near = moves.position[max(here.start - 1, 0) : here.stop].T
    # The way along X, Y and Z and the filament, then both for each mm of length.
    direction = np.zeros((4, here.stop - here.start))
    np.subtract(near[:, 1:], near[:, :-1], out=direction[:3, max(1 - here.start, 0) :])
    direction[3] = moves.filament[here]
    length = np.sqrt(np.einsum("ij,ij->j", direction[:3], direction[:3]))
    still = np.flatnonzero(length < _SHORTEST_MM)
    direction[:3, still] = 0.0
    length[still] = np.abs(direction[3, still])
    speed, tool = moves.speed[here], moves.tool[here]
    kept = length >= _SHORTEST_MM
    if not kept.all():
        rows = np.flatnonzero(kept)
        length, speed, tool = length.take(rows), speed.take(rows), tool.take(rows)
        direction = direction.take(rows, axis=1)
    direction /= length
    shares = np.abs(direction)
    shares[1] = np.maximum(shares[0], shares[1])  # the limits of X and Y are the same
    used = shares[1:] * _inverse(printer.max_speed_mm_s)[1:]
    speed = np.minimum(speed, 1 / _greatest(used))
    acceleration = 1 / _greatest(np.multiply(shares[1:], _inverse(printer.acceleration_mm_s2)[1:], out=used))
    direction *= _inverse(printer.max_speed_change_mm_s)
    corner = np.full(len(length), np.nan)
    corner[:-1] = _corner_speeds_squared(tool, speed, direction)
    tips = [column[[0, -1]] if len(length) else column for column in (tool, speed, *direction)]
    return kept, (length, speed, acceleration, corner), tips


def _inverse(limits: Four) -> FloatArray:
    """(4, 1) of the limits of X, Y, Z and the filament."""
    return 1 / np.array(limits)[:, None]


def _greatest(shares: FloatArray) -> FloatArray:
    """(S,) maxima over the axes, of values (A, S); faster than numpy's own along a short axis."""
    greatest: FloatArray = shares[0]
    for share in shares[1:]:
        np.maximum(greatest, share, out=greatest)
    return greatest


def _corner_speeds_squared(tool: IntArray, speed: FloatArray, direction: FloatArray) -> FloatArray:
    """(S - 1,) mm²/s², greatest squared speed between S segments that follow each other; 0 where the tool changes.

    Args:
        tool: (S,).
        speed: (S,) mm/s.
        direction: (4, S), for each mm of length, in units of what each axis may change its speed by at once, mm/s.
    """
    change = direction[:, 1:] - direction[:, :-1]
    limit = _greatest(np.abs(change, out=change))
    with np.errstate(divide="ignore"):
        np.divide(1, limit, out=limit)
    np.minimum(limit, speed[1:], out=limit)
    np.minimum(limit, speed[:-1], out=limit)
    limit[tool[1:] != tool[:-1]] = 0.0
    limit *= limit
    return limit


def _node_speeds_squared(segments: _Segments, printer: PrinterProfile) -> FloatArray:
    """(S + 1,) mm²/s², squared speed u at which each node is passed.

    A segment that gains `w = 2·a·length` at most ties its ends by |u_i - u_{i+1}| ≤ w. With P the sum of the w
    before a node, u + P must not exceed any later u + P, and u - P any earlier u - P: two running minima. All sums are
    exact, so that between two stops a print takes as long whatever came before.
    """
    before = np.zeros(len(segments.length) + 1)
    np.multiply(segments.acceleration, segments.length, out=before[1:])
    before *= 2 * _SUMMABLE
    np.floor(before, out=before)
    np.cumsum(before, out=before)
    u = np.append(0.0, segments.corner)
    u *= _SUMMABLE
    np.floor(u, out=u)
    queue = printer.queue_moves
    np.minimum(u[:-queue], before[queue:] - before[:-queue], out=u[:-queue])
    u += before
    np.minimum.accumulate(u[::-1], out=u[::-1])
    u -= before
    u -= before
    np.minimum.accumulate(u, out=u)
    u += before
    u /= _SUMMABLE
    return np.maximum(u, 0.0, out=u)  # the sums round


def _trapezoid_seconds(
    length: FloatArray, speed: FloatArray, acceleration: FloatArray, begin: FloatArray, end: FloatArray
) -> tuple[FloatArray]:
    """(S,) s of each segment: accelerate, cruise where it is long enough, decelerate.

    Args:
        length: mm.
        speed: mm/s.
        acceleration: mm/s².
        begin: mm²/s², squared speed at the beginning.
        end: mm²/s², squared speed at the end.
    """
    both = begin + end
    highest = np.minimum(speed * speed, both / 2 + acceleration * length)
    top = np.sqrt(highest)
    ramps = (2 * top - np.sqrt(begin) - np.sqrt(end)) / acceleration
    ramp_length = (highest - both / 2) / acceleration
    return (ramps + np.maximum(length - ramp_length, 0.0) / top,)
