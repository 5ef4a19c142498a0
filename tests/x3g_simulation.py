"""How long a printer takes for an X3G file: a planner of its own, one command after the other.

It shares nothing with the program's estimate but the limits of the printer. A window of 16 moves slides over the file:
each move is begun only as fast as the 15 behind it allow the printer to stop in; then it is driven and forgotten.
"""

from collections import deque
from dataclasses import dataclass
from math import inf, sqrt

from dualcolor.core.x3g.commands import Command

STEPS_PER_MM = (88.888889, 88.888889, 400.0, 96.2752, 96.2752)
ACCELERATION = (1000.0, 1000.0, 150.0, 2000.0, 2000.0)
SPEED_CHANGE = (15.0, 15.0, 10.0, 20.0, 20.0)
NOZZLE_DISTANCE = 35.0
WINDOW = 16


@dataclass
class Block:
    direction: tuple
    length: float
    speed: float
    acceleration: float
    entry: float  # mm/s, greatest at which it may be entered, whatever follows


def block(way_steps, length, speed, before):
    direction = tuple(steps / per_mm / length for steps, per_mm in zip(way_steps, STEPS_PER_MM, strict=True))
    acceleration = min(
        (most / abs(part) for most, part in zip(ACCELERATION, direction, strict=True) if part), default=inf
    )
    return Block(direction, length, speed, acceleration, corner_speed(before, direction, speed))


def corner_speed(before, direction, speed):
    """The speed that both moves may have without any axis changing its own by more than it can at once."""
    if before is None:
        return 0.0
    fastest = min(before.speed, speed)
    for change, old, new in zip(SPEED_CHANGE, before.direction, direction, strict=True):
        if old != new:
            fastest = min(fastest, change / abs(new - old))
    return fastest


def entry_of_second(window):
    """The speed at which the window's second move may begin so that the last one can still end at rest."""
    speed = 0.0
    for index in range(len(window) - 1, 0, -1):
        move = window[index]
        speed = min(move.entry, sqrt(speed * speed + 2 * move.acceleration * move.length))
    return speed


def drive(move, begin, end):
    """Seconds from one speed to another, and the speed that is really reached at the end."""
    a, way = move.acceleration, move.length
    end = min(end, sqrt(begin * begin + 2 * a * way))
    peak = min(move.speed, sqrt((begin * begin + end * end + 2 * a * way) / 2))
    peak = max(peak, begin, end)
    ramps = (2 * peak * peak - begin * begin - end * end) / (2 * a)
    return (2 * peak - begin - end) / a + max(way - ramps, 0.0) / peak, end


def seconds_of(blocks):
    """Seconds of moves that are planned together, from rest to rest."""
    window, speed, total = deque(), 0.0, 0.0
    for move in blocks:
        window.append(move)
        if len(window) == WINDOW:
            spent, speed = drive(window[0], speed, entry_of_second(window))
            total += spent
            window.popleft()
    while window:
        spent, speed = drive(window[0], speed, entry_of_second(window))
        total += spent
        window.popleft()
    return total


def simulated_seconds(commands, first=0, last=None):
    """Seconds that the commands from `first` up to `last` move; the printer rests at every tool change."""
    way = commands.way
    total, blocks = 0.0, []
    for row in range(first, len(commands.code) if last is None else last):
        code = commands.code[row]
        if code == Command.MOVE:
            blocks.append(
                block(way[row].tolist(), commands.distance[row], commands.speed[row], blocks[-1] if blocks else None)
            )
        elif code == Command.CHANGE_TOOL:
            total += seconds_of(blocks)
            blocks = []
        elif code == Command.MOVE_UNPLANNED:  # to where the nozzle is, but as seen from the other one
            interval_us = int.from_bytes(commands.data[commands.offset[row] + 21 :][:4].tobytes(), "little")
            total += NOZZLE_DISTANCE * STEPS_PER_MM[0] * interval_us / 1e6
    return total + seconds_of(blocks)
