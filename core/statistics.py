"""How long a print takes and how much filament it uses, from the moves that go into the file."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .gcode.sequences import TRAVEL_F
from .model import BoolArray, FloatArray, IntArray
from .printer import REPLICATOR_2X
from .settings import PrintSettings
from .toolpaths.moves import Feature, Moves

_SHORTEST_MM = 1e-9


@dataclass(frozen=True)
class _Segments:
    """The rows of the moves that take time. S segments between S + 1 nodes.

    Attributes:
        row: (S,) int64, the row of the moves.
        direction: (S, 4) X, Y, Z and filament for each mm of length.
        length: (S,) float64 mm, of the way or else of the filament.
        speed: (S,) float64 mm/s that the axes allow.
        acceleration: (S,) float64 mm/s² that the axes allow.
    """

    row: IntArray
    direction: FloatArray
    length: FloatArray
    speed: FloatArray
    acceleration: FloatArray


def print_time(moves: Moves, settings: PrintSettings) -> dict[str, float]:
    """Seconds that the print moves, see `move_seconds`; heating and priming left out.

    Args:
        moves: the print.
        settings: of the print; none of them matters yet beyond what the moves carry.

    Returns:
        `total`; `tool_change`, all that is not extruded between the last strand of one tool and the first of the
        next; `tower`, the strands of the cleaning tower. All in s.
    """
    seconds = move_seconds(moves)
    return {
        "total": float(seconds.sum()),
        "tool_change": float(seconds[tool_change_rows(moves)].sum()),
        "tower": float(seconds[moves.feature == Feature.TOWER].sum()),
    }


def move_seconds(moves: Moves) -> FloatArray:
    """(M,) s that each row takes, by trapezoids as the firmware plans them.

    Speeds at the corners obey the instant speed change of each axis, that of the filament included, accelerations
    those of the axes, and the printer can always stop at the end of its queue of moves. It stands still at tool
    changes, where the carriage shifts from nozzle to nozzle. That a short queue slows the firmware down does not
    appear here: `toolpaths/speeds.py` gives every line the time that it needs to stay filled.
    """
    seconds = np.zeros(len(moves.tool))
    segments = _segments(moves)
    if len(segments.row):
        speeds = _node_speeds_squared(segments, moves.tool[segments.row])
        seconds[segments.row] = _trapezoid_seconds(segments, speeds)
    seconds[1:][np.diff(moves.tool) != 0] += REPLICATOR_2X.nozzle_distance_mm / (TRAVEL_F / 60)
    return seconds


def filament_use(moves: Moves, settings: PrintSettings) -> dict[str, float]:
    """Filament that each tool feeds in the end, retractions balanced: `tool0_mm`, `tool1_mm`, `tool0_g`, `tool1_g`."""
    use = {}
    for tool, diameter in enumerate((settings.filament_diameter_0, settings.filament_diameter_1)):
        use[f"tool{tool}_mm"] = float(moves.filament[moves.tool == tool].sum())
        cubic_mm = use[f"tool{tool}_mm"] * np.pi / 4 * diameter**2
        use[f"tool{tool}_g"] = float(cubic_mm * settings.filament_density / 1000)
    return {name: use[name] for name in ("tool0_mm", "tool1_mm", "tool0_g", "tool1_g")}


def _segments(moves: Moves) -> _Segments:
    """The rows with a way or with filament; a row before which the place is not known (the first) has no way."""
    step = np.zeros((len(moves.tool), 3))
    step[1:] = np.diff(moves.position, axis=0)
    length = np.sqrt(np.einsum("ij,ij->i", step, step))
    still = length < _SHORTEST_MM
    length[still] = np.abs(moves.filament[still])
    row = np.flatnonzero(length >= _SHORTEST_MM)
    step, length, still = step[row], length[row], still[row]
    direction = np.where(still[:, None], 0.0, step / length[:, None])

    printer = REPLICATOR_2X
    feed = moves.filament[row] / length
    lift = np.abs(direction[:, 2])
    level = np.maximum(np.abs(direction[:, 0]), np.abs(direction[:, 1]))
    with np.errstate(divide="ignore"):
        speed = np.minimum(moves.speed[row], printer.max_speed_mm_s[3] / np.abs(feed))
        speed = np.minimum(speed, np.minimum(printer.max_speed_mm_s[0] / level, printer.max_speed_mm_s[2] / lift))
        acceleration = np.minimum(printer.acceleration_mm_s2[0] / level, printer.acceleration_mm_s2[2] / lift)
        acceleration = np.minimum(acceleration, printer.acceleration_mm_s2[3] / np.abs(feed))
    return _Segments(row, np.column_stack([direction, feed]), length, speed, acceleration)


def _node_speeds_squared(segments: _Segments, tool: IntArray) -> FloatArray:
    """(S + 1,) mm²/s², squared speed u at which each node is passed.

    A segment that gains `w = 2·a·length` at most ties its ends by |u_i - u_{i+1}| ≤ w. With P the sum of the w
    before a node, u + P must not exceed any later u + P, and u - P any earlier u - P: two running minima.
    """
    gain = 2 * segments.acceleration * segments.length
    before = np.concatenate([[0.0], np.cumsum(gain)])
    u = np.zeros(len(gain) + 1)
    u[1:-1] = _corner_speeds(segments, tool) ** 2
    queue = REPLICATOR_2X.queue_moves
    u[:-queue] = np.minimum(u[:-queue], before[queue:] - before[:-queue])
    u = np.minimum.accumulate((u + before)[::-1])[::-1] - before
    u = np.minimum.accumulate(u - before) + before
    bounded: FloatArray = np.maximum(u, 0.0)  # the sums round
    return bounded


def _corner_speeds(segments: _Segments, tool: IntArray) -> FloatArray:
    """(S - 1,) mm/s, greatest speed between a segment and the next one."""
    speed, direction = segments.speed, segments.direction
    limit: FloatArray = np.minimum(speed[:-1], speed[1:])
    turn = np.abs(np.diff(direction, axis=0))
    with np.errstate(divide="ignore"):
        for axis, change in enumerate(REPLICATOR_2X.max_speed_change_mm_s):
            limit = np.minimum(limit, change / turn[:, axis])
    limit[tool[:-1] != tool[1:]] = 0.0
    return limit


def _trapezoid_seconds(segments: _Segments, u: FloatArray) -> FloatArray:
    """(S,) s of each segment: speed up, keep the speed as long as there is way for it, slow down."""
    begin, end, acceleration = u[:-1], u[1:], segments.acceleration
    highest = np.minimum(segments.speed**2, (begin + end) / 2 + acceleration * segments.length)
    top = np.sqrt(highest)
    ramps = (2 * top - np.sqrt(begin) - np.sqrt(end)) / acceleration
    ramp_length = (2 * highest - begin - end) / (2 * acceleration)
    seconds: FloatArray = ramps + np.maximum(segments.length - ramp_length, 0.0) / top
    return seconds


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
