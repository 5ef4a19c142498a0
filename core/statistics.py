"""How long a print takes and how much filament it uses, from the moves that go into the file."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .model import BoolArray, FloatArray, IntArray
from .pattern.chunks import in_chunks
from .printer import Four, PrinterProfile
from .settings import PrintSettings
from .toolpaths.moves import Feature, Moves

_SHORTEST_MM = 1e-9


@dataclass(frozen=True)
class _Segments:
    """The rows of the moves that take time. S segments between S + 1 nodes.

    Attributes:
        row: (S,) int64, the row of the moves.
        direction: X, Y, Z and filament for each mm of length, (S,) each.
        length: (S,) float64 mm, of the way or else of the filament.
        speed: (S,) float64 mm/s that the axes allow.
        acceleration: (S,) float64 mm/s² that the axes allow.
        tool: (S,) int64.
    """

    row: IntArray
    direction: tuple[FloatArray, FloatArray, FloatArray, FloatArray]
    length: FloatArray
    speed: FloatArray
    acceleration: FloatArray
    tool: IntArray


def print_time(moves: Moves, settings: PrintSettings) -> dict[str, float]:
    """Seconds that the print moves, see `move_seconds`; heating and priming left out.

    Args:
        moves: the print.
        settings: of the print; its printer sets the limits.

    Returns:
        `total`; `tool_change`, all that is not extruded between the last strand of one tool and the first of the
        next; `tower`, the strands of the cleaning tower. All in s.
    """
    seconds = move_seconds(moves, settings.printer_profile)
    return {
        "total": float(seconds.sum()),
        "tool_change": float(seconds[tool_change_rows(moves)].sum()),
        "tower": float(seconds[moves.feature == Feature.TOWER].sum()),
    }


def move_seconds(moves: Moves, printer: PrinterProfile) -> FloatArray:
    """(M,) s that each row takes, by trapezoids as the firmware plans them.

    Speeds at the corners obey the instant speed change of each axis, that of the filament included, accelerations
    those of the axes, and the printer can always stop at the end of its queue of moves. It stands still at tool
    changes, where the carriage shifts from nozzle to nozzle. That a short queue slows the firmware down does not
    appear here: `toolpaths/speeds.py` gives every line the time that it needs to stay filled.
    """
    seconds = np.zeros(len(moves.tool))
    segments = _segments(moves, printer)
    if len(segments.row):
        u = _node_speeds_squared(segments, printer)
        (seconds[segments.row],) = in_chunks(
            _trapezoid_seconds, segments.length, segments.speed, segments.acceleration, u[:-1], u[1:]
        )
    seconds[1:][np.diff(moves.tool) != 0] += printer.nozzle_distance_mm / (printer.travel_mm_min / 60)
    return seconds


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
    passed = np.concatenate([[0.0], np.cumsum(seconds)])
    return np.asarray(passed[np.append(np.flatnonzero(layer_changes(moves.layer)), len(moves.layer))])


def filament_use(moves: Moves, settings: PrintSettings) -> dict[str, float]:
    """Filament that each tool feeds in the end, retractions balanced: `tool0_mm`, `tool1_mm`, `tool0_g`, `tool1_g`."""
    use = {}
    for tool, diameter in enumerate((settings.filament_diameter_0, settings.filament_diameter_1)):
        use[f"tool{tool}_mm"] = float(moves.filament[moves.tool == tool].sum())
        cubic_mm = use[f"tool{tool}_mm"] * np.pi / 4 * diameter**2
        use[f"tool{tool}_g"] = float(cubic_mm * settings.filament_density / 1000)
    return {name: use[name] for name in ("tool0_mm", "tool1_mm", "tool0_g", "tool1_g")}


def _segments(moves: Moves, printer: PrinterProfile) -> _Segments:
    """The rows with a way or with filament; a row before which the place is not known (the first) has no way."""
    before = np.concatenate([moves.position[:1], moves.position[:-1]])
    row = np.arange(len(moves.tool))
    columns = (row, before, moves.position, moves.filament, moves.speed, moves.tool)
    row, x, y, z, feed, length, speed, acceleration, tool = in_chunks(partial(_measured, printer), *columns)
    return _Segments(row, (x, y, z, feed), length, speed, acceleration, tool)


def _measured(
    printer: PrinterProfile,
    row: IntArray,
    before: FloatArray,
    position: FloatArray,
    filament: FloatArray,
    speed: FloatArray,
    tool: IntArray,
) -> tuple[NDArray[Any], ...]:
    """The columns of `_Segments` for some rows of the moves, without those that take no time."""
    x, y, z = (position - before).T.copy()
    length = np.sqrt(x * x + y * y + z * z)
    still = length < _SHORTEST_MM
    length[still] = np.abs(filament[still])
    kept = length >= _SHORTEST_MM
    if not kept.all():
        row, x, y, z, filament, speed = (column[kept] for column in (row, x, y, z, filament, speed))
        length, still, tool = length[kept], still[kept], tool[kept]
    x, y, z = (np.where(still, 0.0, way / length) for way in (x, y, z))
    feed = filament / length
    lift, fed, level = np.abs(z), np.abs(feed), np.maximum(np.abs(x), np.abs(y))
    with np.errstate(divide="ignore"):
        speed = np.minimum(speed, printer.max_speed_mm_s[3] / fed)
        speed = np.minimum(speed, np.minimum(printer.max_speed_mm_s[0] / level, printer.max_speed_mm_s[2] / lift))
        acceleration = np.minimum(printer.acceleration_mm_s2[0] / level, printer.acceleration_mm_s2[2] / lift)
        acceleration = np.minimum(acceleration, printer.acceleration_mm_s2[3] / fed)
    return row, x, y, z, feed, length, speed, acceleration, tool


def _node_speeds_squared(segments: _Segments, printer: PrinterProfile) -> FloatArray:
    """(S + 1,) mm²/s², squared speed u at which each node is passed.

    A segment that gains `w = 2·a·length` at most ties its ends by |u_i - u_{i+1}| ≤ w. With P the sum of the w
    before a node, u + P must not exceed any later u + P, and u - P any earlier u - P: two running minima.
    """
    gain = 2 * segments.acceleration * segments.length
    before = np.concatenate([[0.0], np.cumsum(gain)])
    u = np.zeros(len(gain) + 1)
    if len(gain) > 1:
        columns = [part for column in (segments.speed, *segments.direction) for part in (column[:-1], column[1:])]
        corner_speeds = partial(_corner_speeds_squared, printer.max_speed_change_mm_s)
        (u[1:-1],) = in_chunks(corner_speeds, segments.tool[:-1] != segments.tool[1:], *columns)
    queue = printer.queue_moves
    u[:-queue] = np.minimum(u[:-queue], before[queue:] - before[:-queue])
    u = np.minimum.accumulate((u + before)[::-1])[::-1] - before
    u = np.minimum.accumulate(u - before) + before
    bounded: FloatArray = np.maximum(u, 0.0)  # the sums round
    return bounded


def _corner_speeds_squared(
    at_once: Four, changes: BoolArray, speed: FloatArray, next_speed: FloatArray, *directions: FloatArray
) -> tuple[FloatArray]:
    """(S - 1,) mm²/s², greatest squared speed between segments and the next ones; 0 where the tool changes.

    Args:
        at_once: mm/s that each axis may change its speed by.
        changes: whether the next segment has another tool.
        speed: mm/s of the segments.
        next_speed: mm/s of the next ones.
        directions: of the segments and of the next ones, axis by axis.
    """
    limit = np.minimum(speed, next_speed)
    with np.errstate(divide="ignore"):
        for axis, change in enumerate(at_once):
            limit = np.minimum(limit, change / np.abs(directions[2 * axis + 1] - directions[2 * axis]))
    limit[changes] = 0.0
    return (limit * limit,)


def _trapezoid_seconds(
    length: FloatArray, speed: FloatArray, acceleration: FloatArray, begin: FloatArray, end: FloatArray
) -> tuple[FloatArray]:
    """(S,) s of each segment: speed up, keep the speed as long as there is way for it, slow down.

    Args:
        length: mm.
        speed: mm/s.
        acceleration: mm/s².
        begin: mm²/s², squared speed at the beginning.
        end: mm²/s², squared speed at the end.
    """
    highest = np.minimum(speed**2, (begin + end) / 2 + acceleration * length)
    top = np.sqrt(highest)
    ramps = (2 * top - np.sqrt(begin) - np.sqrt(end)) / acceleration
    ramp_length = (2 * highest - begin - end) / (2 * acceleration)
    return (ramps + np.maximum(length - ramp_length, 0.0) / top,)


def tool_change_rows(moves: Moves) -> BoolArray:
    """(M,) rows without a strand between the last strand of one tool and the first of the other."""
    strand = np.flatnonzero(moves.extrudes)
    switched = np.flatnonzero(np.diff(moves.tool)) + 1
    after = np.searchsorted(strand, switched)
    begin = np.concatenate([[-1], strand])[after] + 1
    end = np.concatenate([strand, [len(moves.tool)]])[after]
    depth = np.zeros(len(moves.tool) + 1, dtype=np.int64)
    np.add.at(depth, begin, 1)
    np.add.at(depth, end, -1)
    inside: BoolArray = np.cumsum(depth)[:-1] > 0
    return inside
