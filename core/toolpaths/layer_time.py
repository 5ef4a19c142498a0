"""Short layers are printed more slowly: what is still soft when the next layer comes deforms under it.

A layer takes the time from its beginning to that of the next one, with all travels, the tool change and the tower: the
part cools meanwhile. Where that is too short, the fastest lines are slowed first, down to one speed that is just slow
enough, so fill and tower give way before the waved wall does. Travels stay fast, since a nozzle that lingers oozes, and
bridges keep the speed at which they hold.

What a layer takes is found from its own moves alone, as if the printer stood still before and after, as it does where
the tool changes. So some layers can be made anew without the others (`job/changed_layers.py`).
"""

from __future__ import annotations

import numpy as np

from ..errors import counted
from ..model import FloatArray, IntArray
from ..paths import Feature
from ..ragged import ranges, starts
from ..settings import PrintSettings
from .move_times import layer_begins, move_seconds, shift_seconds
from .moves import Moves
from .order import OrderedPaths

# Slower lines lose less time to starts, stops and corners, so their speed is looked for again with what they lose then.
_MOST_ROUNDS = 2
_NEAR_ENOUGH = 0.99
_LEVELS = 8
_LONG_S = 1e9
_NO_TOOL = -1
_WORTH_TELLING = 0.9


def short_layers(paths: OrderedPaths, length: FloatArray, speed: FloatArray, settings: PrintSettings) -> IntArray:
    """The layers, ascending, whose lines alone, without starts and stops, take less than they should.

    Args:
        paths: in printing order.
        length: (N,) mm from each point to the next.
        speed: (N,) mm/s there.
        settings: `slowdown_below_layer_time` is used.
    """
    if not settings.slowdown_below_layer_time or not len(paths.layer):
        return np.zeros(0, dtype=np.int64)
    begins = np.flatnonzero(np.diff(paths.layer, prepend=-1))
    seconds = np.add.reduceat(length / speed, paths.start[begins])
    return np.asarray(paths.layer[begins[seconds < settings.slowdown_below_layer_time]])


def slow_short_layers(moves: Moves, layers: IntArray, settings: PrintSettings) -> None:
    """Lower the speeds, in place, of the lines of those layers that take less than `slowdown_below_layer_time`.

    Args:
        moves: the print.
        layers: (C,) ascending, of `short_layers`; all others take long enough.
        settings: slowdown_below_layer_time, min_print_speed and the printer are used.
    """
    if not len(layers):
        return
    row, part, number = _standing_alone(moves, layers)
    lines = (part.extrudes & (part.feature != Feature.BRIDGE) & (part.speed > settings.min_print_speed)).nonzero()[0]
    lines = lines[part.tool[lines] != _NO_TOOL]
    of, fastest, count = number[lines], part.speed[lines], len(layers)
    way = np.linalg.norm(part.position[lines] - part.position[lines - 1], axis=1)
    wanted, common = settings.slowdown_below_layer_time, np.full(count, np.inf)
    for _ in range(_MOST_ROUNDS):
        seconds = _layer_seconds(moves, part, row, settings)
        is_short = (seconds < _NEAR_ENOUGH * wanted) & (common > settings.min_print_speed)
        if not is_short.any():
            break
        others = seconds - np.bincount(of, way / part.speed[lines], count)
        slow = _common_speed(of, way, fastest, np.where(is_short, wanted - others, _LONG_S))
        common = np.where(is_short, np.maximum(slow, settings.min_print_speed), common)
        part.speed[lines] = np.minimum(fastest, common[of])
    moves.speed[row[lines]] = part.speed[lines]


def _standing_alone(moves: Moves, layers: IntArray) -> tuple[IntArray, Moves, IntArray]:
    """The rows of some layers (C,), before each layer that from which its first way leads, by no tool.

    Where the tool changes the printer stands still, so none of the layers depends on another.

    Returns:
        (R,) rows of the moves; the table of these; (R,) which of the layers each belongs to.
    """
    first = np.searchsorted(moves.layer, layers)
    count = np.searchsorted(moves.layer, layers, side="right") - first + 1
    row = np.maximum(ranges(first - 1, count), 0)
    part = moves.rows(row)
    part.tool[starts(count)[:-1]] = _NO_TOOL
    return row, part, np.repeat(np.arange(len(layers)), count)


def _layer_seconds(moves: Moves, part: Moves, row: IntArray, settings: PrintSettings) -> FloatArray:
    """(C,) s that each layer takes; see `_standing_alone`."""
    printer = settings.printer_profile
    seconds = move_seconds(part, printer)
    before = np.flatnonzero(part.tool == _NO_TOOL)
    seconds[before] = 0.0
    stays = moves.tool[row[before]] == part.tool[before + 1]
    seconds[before + 1] -= np.where(stays, shift_seconds(printer), 0.0)
    return np.asarray(np.add.reduceat(seconds, before))


def _common_speed(of: IntArray, way: FloatArray, speed: FloatArray, needed: FloatArray) -> FloatArray:
    """(C,) mm/s, the greatest speed of all lines of a layer at which they take the time that is needed.

    It rises from the one at which all are as slow: lines that are slower by themselves leave their time to the others.

    Args:
        of: (N,) layer of each line.
        way: (N,) mm.
        speed: (N,) mm/s, of the lines without the limit.
        needed: (C,) s, more than they take at these.
    """
    common, held = np.bincount(of, way, len(needed)) / needed, np.zeros(len(way), dtype=bool)
    for _ in range(_LEVELS):
        before, held = held, speed > common[of]
        if (held == before).all():
            break
        rest = needed - np.bincount(of[~held], (way / speed)[~held], len(needed))
        together = np.bincount(of[held], way[held], len(needed))
        np.divide(together, rest, out=common, where=together > common * rest)
    return common


def layer_time_warnings(moves: Moves, seconds: FloatArray, settings: PrintSettings) -> list[str]:
    """One sentence about layers that stay short, as even the slowest speed leaves them no time to set, or none.

    Args:
        moves: the print, or its `stretches`.
        seconds: (M,) s that its rows take.
        settings: `slowdown_below_layer_time` is read.
    """
    wanted = settings.slowdown_below_layer_time
    taken = np.diff(layer_begins(moves, seconds))
    short = int((taken < _WORTH_TELLING * wanted).sum())
    if not short:
        return []
    verb = "takes" if short == 1 else "take"
    return [
        f"{counted(short, 'layer')} {verb} less than the {wanted:g} s of slowdown_below_layer_time, the shortest "
        f"{taken.min():.1f} s, and may not set before the next: print several objects at once, or lower min_print_speed"
    ]
