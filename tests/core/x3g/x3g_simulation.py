"""How long a printer takes for an X3G file: a planner of its own, one command after the other.

It shares nothing with the program's estimate but the limits of the printer. A window of 16 moves slides over the file:
each move is begun only as fast as the 15 behind it allow the printer to stop in; then it is driven and forgotten.
"""

from math import sqrt

import numpy as np
from dualcolor.core.x3g.commands import Command

STEPS_PER_MM = np.array([88.888889, 88.888889, 400.0, 96.2752, 96.2752])
ACCELERATION = np.array([1000.0, 1000.0, 150.0, 2000.0, 2000.0])
SPEED_CHANGE = np.array([15.0, 15.0, 10.0, 20.0, 20.0])
NOZZLE_DISTANCE = 35.0
WINDOW = 16
PRIMED_Y = -71.9  # nothing that a test prints lies so far in front


def print_seconds(commands):
    """Seconds from the first move behind the priming lines to the end, where the filaments' motors are let go."""
    end = int(np.flatnonzero(commands.code == Command.SWITCH_AXES)[0])
    in_front = commands.moves & (commands.steps[:, 1] / STEPS_PER_MM[1] < PRIMED_Y)
    return simulated_seconds(commands, int(np.flatnonzero(in_front[:end])[-1]) + 1, end)


def simulated_seconds(commands, first=0, last=None):
    """Seconds that the commands from `first` up to `last` move; the printer rests at every tool change."""
    rows = np.arange(first, len(commands.code) if last is None else last)
    changes = rows[commands.code[rows] == Command.CHANGE_TOOL]
    total = 0.0
    for part in np.split(rows, np.searchsorted(rows, changes)):
        total += seconds_of(*blocks(commands, part[commands.code[part] == Command.MOVE]))
    for row in rows[commands.code[rows] == Command.MOVE_UNPLANNED].tolist():
        # To where the nozzle is, but as seen from the other one.
        interval_us = int.from_bytes(commands.data[commands.offset[row] + 21 :][:4].tobytes(), "little")
        total += NOZZLE_DISTANCE * float(STEPS_PER_MM[0]) * interval_us / 1e6
    return total


def blocks(commands, rows):
    """For moves that are planned together: mm, mm/s, mm/s² and the speed at which each may be entered at most."""
    length, speed = commands.distance[rows], commands.speed[rows]
    direction = commands.way[rows] / STEPS_PER_MM / length[:, None]
    with np.errstate(divide="ignore"):
        acceleration = (ACCELERATION / np.abs(direction)).min(axis=1)
        # In a corner no axis may change its own speed by more than it can at once.
        corner = (SPEED_CHANGE / np.abs(np.diff(direction, axis=0))).min(axis=1)
    entry = np.zeros(len(rows))
    entry[1:] = np.minimum(corner, np.minimum(speed[1:], speed[:-1]))
    return [column.tolist() for column in (length, speed, acceleration, entry)]


def seconds_of(length, speed, acceleration, entry):
    """Seconds of moves that are planned together, from rest to rest."""
    count, now, total = len(length), 0.0, 0.0
    gain = [2 * a * way for a, way in zip(acceleration, length, strict=True)]
    for move in range(count):
        # The speed at which the next move may begin so that the last one in the window can still end at rest.
        following = 0.0
        for index in range(min(move + WINDOW, count) - 1, move, -1):
            following = min(entry[index], sqrt(following * following + gain[index]))
        spent, now = drive(length[move], speed[move], acceleration[move], now, following)
        total += spent
    return total


def drive(way, speed, a, begin, end):
    """Seconds from one speed to another, and the speed that is really reached at the end."""
    end = min(end, sqrt(begin * begin + 2 * a * way))
    peak = min(speed, sqrt((begin * begin + end * end + 2 * a * way) / 2))
    peak = max(peak, begin, end)
    ramps = (2 * peak * peak - begin * begin - end * end) / (2 * a)
    return (2 * peak - begin - end) / a + max(way - ramps, 0.0) / peak, end
