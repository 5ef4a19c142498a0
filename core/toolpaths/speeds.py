"""How fast each line is printed: the speed set for its feature, within what the controller and the hot end can do.

Why the waved wall is held back twice:

*Curvature.* The firmware limits how much the speed of an axis may jump in a corner, not how fast a curve of many short
chords is taken: at 30 mm/s a crest with 0.15 mm radius would ask for 6000 mm/s², and the belts answer with ringing. So
v² / radius stays below `max_curve_acceleration`, by default what the firmware grants an axis, 1000 mm/s². This, not
`wave_speed`, decides how long a waved wall takes. Corners that the firmware does slow down for, as those of zigzags,
set no limit: the lines between them would be slow all along.

*Rate of moves.* Sailfish keeps 16 moves in its queue. The much quoted 20 ms apply to a move that meets an empty queue
(`ACCELERATION_MIN_SEGMENT_TIME`); below `ACCELERATION_SLOWDOWN_LIMIT` (4 to 8) queued moves it scales the speed down
with what is left. Neither happens as long as moves are planned faster than they are printed. The planner is a fixed
point one on a 16 MHz AVR; Marlin, whose floating point planner its authors measured to be five times slower, grants
itself 200 moves a second on the same chip. `min_move_time` defaults to 8 ms, 125 moves a second, counted over half a
queue: one short chord between longer ones does no harm.

The two belong together with the tessellation: where curvature rules, a chord with sagitta e takes √(8 e / acceleration)
whatever the radius: 8.9 ms for the default `chord_tolerance` of 0.01 mm, 15.5 ms for 0.03 mm. So finer chords would be
paid for with speed, coarser ones gain little, and 20 ms for every move would cost a sixth of the time.
"""

from __future__ import annotations

import numpy as np

from ..model import FloatArray, IntArray
from ..parallel import CHUNK_ROWS, in_chunks
from ..paths import Feature
from ..ragged import summable
from ..settings import PrintSettings
from .order import OrderedPaths

_SHORTEST_MM = 1e-9
_SLOWEST_MM_S = 1.0
_STRAIGHT = 1e-30  # a turn, which sets no limit that matters
# Speeds that a limit sets come in steps of this, so that a file need not name a new one on every line.
_STEP_MM_S = 1.0


def extrusion_speeds(
    paths: OrderedPaths, height: FloatArray, length: FloatArray, settings: PrintSettings
) -> FloatArray:
    """(N,) mm/s of the line that leaves each point of N; without a meaning at the last point of a path.

    Args:
        paths: K paths in printing order.
        height: (K,) mm, of their lines.
        length: (N,) mm from each point to the next, see `chord_lengths`.
        settings: the speeds and their limits and the greater one of the extrusion multipliers are used.
    """
    asked = feature_speeds(settings)[paths.feature]
    asked = np.where(paths.layer == 0, np.minimum(asked, settings.first_layer_speed), asked)
    fed = height * max(settings.extrusion_multipliers)
    traveled = np.zeros(len(length) + 1)
    np.cumsum(length, out=traveled[1:])
    printer, seconds = settings.printer_profile, settings.min_move_time / 1000
    queue, jump = printer.queue_moves, min(printer.max_speed_change_mm_s[:2])
    speed = np.repeat(asked, np.diff(paths.start))
    if paths.over_air is not None and settings.overhang_speed:
        np.minimum(speed, settings.overhang_speed, out=speed, where=paths.over_air)
    for begin in range(0, len(speed), CHUNK_ROWS):
        here = slice(begin, min(begin + CHUNK_ROWS, len(speed)))
        wanted, path = speed[here], _paths_of(paths.start, here)
        limit = curve_limit(paths, length, here, settings.max_curve_acceleration, jump)
        # A chord that takes its time at the speed asked for is never a burden, whatever its neighbors are.
        short = np.flatnonzero(length[here] < wanted * seconds)
        rate = move_time_limit(paths, traveled, short + begin, path[short], seconds, queue)
        limit[short] = np.minimum(limit[short], rate)
        if settings.max_volumetric_speed > 0:
            section = paths.width[here] * fed.take(path)
            much = np.flatnonzero(section * wanted > settings.max_volumetric_speed)
            limit[much] = np.minimum(limit[much], settings.max_volumetric_speed / section[much])
        slow = np.flatnonzero(limit < wanted)
        stepped = np.maximum(np.floor(limit[slow] / _STEP_MM_S + 1e-6) * _STEP_MM_S, _SLOWEST_MM_S)
        wanted[slow] = np.minimum(stepped, wanted[slow])
    return speed


def _paths_of(start: IntArray, here: slice) -> IntArray:
    """The path of each of some points that follow each other."""
    first, last = np.searchsorted(start, (here.start, here.stop - 1), side="right") - 1
    return np.repeat(np.arange(first, last + 1), np.diff(start[first : last + 2].clip(here.start, here.stop)))


def feature_speeds(settings: PrintSettings) -> FloatArray:
    """mm/s that the settings ask for, by `Feature`."""
    speed = np.full(len(Feature), settings.outline_speed)
    speed[Feature.OUTER_WALL] = settings.wave_speed
    speed[Feature.SKIN] = settings.skin_speed
    speed[Feature.BRIDGE] = settings.bridge_speed
    speed[Feature.INFILL] = settings.infill_speed
    speed[Feature.TOWER] = settings.tower_speed
    speed[[Feature.SUPPORT, Feature.SUPPORT_INTERFACE]] = settings.support_speed
    return speed


def chord_lengths(paths: OrderedPaths) -> FloatArray:
    """(N,) mm from each point to the next one of its path, 0 at the last."""
    length = np.zeros(len(paths.points))
    if len(length) > 1:
        (length[:-1],) = in_chunks(_distances, paths.points[:-1], paths.points[1:], threads=False)
    length[paths.start[1:] - 1] = 0.0
    return length


def _distances(near: FloatArray, far: FloatArray) -> tuple[FloatArray]:
    x, y = np.subtract(far.T, near.T, order="C")
    return (summable(np.sqrt(x * x + y * y)),)


def curve_limit(paths: OrderedPaths, length: FloatArray, here: slice, acceleration: float, jump: float) -> FloatArray:
    """(C,) mm/s at which a chord's sharper end takes all of the acceleration (mm/s²): v² · curvature = acceleration.

    The curvature at a point is the turn there over the mean of both chords. Where the speed would still jump by more
    than the firmware allows, there is no limit: the firmware slows down for that corner by itself.

    Args:
        paths: in printing order.
        length: (N,) mm from each point to the next.
        here: the points at which the chords begin.
        acceleration: mm/s².
        jump: mm/s, see `PrinterProfile.max_speed_change_mm_s`.
    """
    # A corner at both ends of every chord, and a chord on both sides of each corner.
    begin, end = here.start - 1, here.stop + 1
    inside = slice(max(begin, 0), min(end, len(length) - 1))
    corner = np.full(end - begin, np.inf)
    around = paths.points[inside.start : inside.stop + 1].T
    x, y = np.subtract(around[:, 1:], around[:, :-1], order="C")
    way = length[inside]
    dot = x[:-1] * x[1:] + y[:-1] * y[1:]
    cross = x[:-1] * y[1:] - y[:-1] * x[1:]
    turn = np.abs(np.arctan2(cross, dot, out=dot), out=dot)
    # A path's ends have no turn: they lie at rest or meet another path.
    turn[np.minimum(way[:-1], way[1:]) < _SHORTEST_MM] = 0.0
    room = acceleration / 2 * (way[:-1] + way[1:])
    turn[room * turn > jump * jump] = 0.0
    tightness = np.maximum(turn, _STRAIGHT, out=turn)
    np.divide(room, tightness, out=tightness)
    first = inside.start - begin
    corner[first : first + len(turn)] = np.sqrt(tightness, out=tightness)
    return np.asarray(np.minimum(corner[:-2], corner[1:-1]))


def move_time_limit(
    paths: OrderedPaths, traveled: FloatArray, chord: IntArray, path: IntArray, seconds: float, queue_moves: int
) -> FloatArray:
    """(C,) mm/s at which half a queue of moves around each chord takes `seconds` a move on average.

    Args:
        paths: in printing order.
        traveled: (N + 1,) mm before each point, and after the last one.
        chord: (C,) points at which the chords begin.
        path: (C,) of each.
        seconds: a move, 0 for no limit.
        queue_moves: of the printer.
    """
    if seconds <= 0:
        return np.full(len(chord), np.inf)
    reach = queue_moves // 4
    first = np.maximum(chord - reach + 1, paths.start[path])
    last = np.minimum(chord + reach + 1, paths.start[path + 1] - 1)  # the last point has no chord
    moves = np.maximum(last - first, 1)
    mean = (traveled[np.maximum(last, first)] - traveled[first]) / moves
    # A chord of its own length is never a burden.
    return np.asarray(np.maximum(mean, traveled[chord + 1] - traveled[chord]) / seconds)
