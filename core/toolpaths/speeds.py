"""How fast each line is printed: what its feature asks for, and what this controller and this hot end can keep up.

Why the waved wall is held back twice:

*Curvature.* The firmware limits how much the speed of an axis may jump in a corner, not how fast a curve of many short
chords is taken: at 30 mm/s a crest with 0.15 mm radius would ask for 6000 mm/s², and the belts answer with ringing. So
v² / radius stays below `max_curve_acceleration`, by default what the firmware grants an axis, 1000 mm/s². This, not
`wave_speed`, decides how long a waved wall takes.

*Rate of moves.* Sailfish keeps 16 moves in its queue. The much quoted 20 ms apply to a move that meets an empty queue
(`ACCELERATION_MIN_SEGMENT_TIME`); below `ACCELERATION_SLOWDOWN_LIMIT` (4 to 8) queued moves it scales the speed down
with what is left. Neither happens as long as moves are planned faster than they are printed. The planner is a fixed
point one on a 16 MHz AVR; Marlin, whose floating point planner its authors measured to be five times slower, grants
itself 200 moves a second on the same chip. `min_move_time` defaults to 8 ms, 125 moves a second, counted over half a
queue: one short chord between longer ones starves nobody.

The two belong together with the tessellation: where curvature rules, a chord with sagitta e takes √(8 e / acceleration)
whatever the radius: 8.9 ms for the default `chord_tolerance` of 0.01 mm, 15.5 ms for 0.03 mm. So finer chords would be
paid for with speed, coarser ones gain little, and 20 ms for every move would cost a sixth of the time.
"""

from __future__ import annotations

import numpy as np

from ..model import FloatArray
from ..settings import PrintSettings
from ..slicing.planes import Layers
from .moves import Feature
from .order import OrderedPaths

_SHORTEST_MM = 1e-9
_SLOWEST_MM_S = 1.0
# Speeds that a limit sets come in steps of this, so that a file need not name a new one on every line.
_STEP_MM_S = 1.0


def extrusion_speeds(paths: OrderedPaths, layers: Layers, settings: PrintSettings) -> FloatArray:
    """(N,) mm/s of the line that leaves each point of N; without a meaning at the last point of a path.

    Args:
        paths: K paths in printing order.
        layers: the stack.
        settings: the speeds and their limits and extrusion_multiplier are used.
    """
    path = np.repeat(np.arange(len(paths.layer)), np.diff(paths.start))
    layer = paths.layer[path]
    asked = feature_speeds(settings)[paths.feature[path]]
    asked = np.where(layer == 0, np.minimum(asked, settings.first_layer_speed), asked)
    length = chord_lengths(paths)
    queue = settings.printer_profile.queue_moves
    curve = curve_limit(paths, length, settings.max_curve_acceleration)
    limit = np.minimum(curve, move_time_limit(paths, length, settings.min_move_time / 1000, queue))
    if settings.max_volumetric_speed > 0:
        section = paths.width * layers.height[layer] * settings.extrusion_multiplier
        limit = np.minimum(limit, settings.max_volumetric_speed / np.maximum(section, _SHORTEST_MM))
    stepped = np.maximum(np.floor(np.minimum(limit, asked) / _STEP_MM_S + 1e-6) * _STEP_MM_S, _SLOWEST_MM_S)
    return np.where(limit < asked, np.minimum(stepped, asked), asked)


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
    step = np.diff(paths.points, axis=0)
    length[:-1] = np.sqrt(np.einsum("ij,ij->i", step, step))
    length[paths.start[1:] - 1] = 0.0
    return length


def curve_limit(paths: OrderedPaths, length: FloatArray, acceleration: float) -> FloatArray:
    """(N,) mm/s at which a chord's sharper end takes all of the acceleration (mm/s²): v² · curvature = acceleration.

    The curvature at a point is the turn there over the mean of both chords, so a corner between long lines, which the
    firmware slows down for by itself, hardly counts.
    """
    limit = np.full(len(length), np.inf)
    if len(length) < 3:
        return limit
    step = np.diff(paths.points, axis=0)
    dot = np.einsum("ij,ij->i", step[:-1], step[1:])
    cross = step[:-1, 0] * step[1:, 1] - step[:-1, 1] * step[1:, 0]
    turn = np.abs(np.arctan2(cross, dot))
    # A path's ends have no turn: they lie at rest or meet another path.
    turn[(length[:-2] < _SHORTEST_MM) | (length[1:-1] < _SHORTEST_MM)] = 0.0
    mean = (length[:-2] + length[1:-1]) / 2
    corner = np.full(len(length), np.inf)
    corner[1:-1] = np.where(turn > 0, np.sqrt(acceleration * mean / np.where(turn > 0, turn, 1.0)), np.inf)
    limit[:-1] = np.minimum(corner[:-1], corner[1:])
    return limit


def move_time_limit(paths: OrderedPaths, length: FloatArray, seconds: float, queue_moves: int) -> FloatArray:
    """(N,) mm/s at which half a queue of moves around each chord takes `seconds` a move on average."""
    limit = np.full(len(length), np.inf)
    if seconds <= 0 or not len(length):
        return limit
    reach = queue_moves // 4
    travelled = np.concatenate([[0.0], np.cumsum(length)])
    path = np.repeat(np.arange(len(paths.layer)), np.diff(paths.start))
    chord = np.arange(len(length))
    first = np.maximum(chord - reach + 1, paths.start[path])
    last = np.minimum(chord + reach + 1, paths.start[path + 1] - 1)  # the last point has no chord
    moves = np.maximum(last - first, 1)
    mean = (travelled[np.maximum(last, first)] - travelled[first]) / moves
    # A chord of its own length is never a burden.
    return np.asarray(np.maximum(mean, length) / seconds)
