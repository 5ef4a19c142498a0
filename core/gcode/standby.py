"""Standby: the idle nozzle is cooled while the other one prints, and heated again in time."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray, IntArray
from ..records import dataclass
from ..settings import PrintSettings
from ..settings.temperatures import nozzle_temperature
from ..statistics.breakdown import NOZZLE_C_PER_S
from ..toolpaths.moves import Moves
from .row_commands import LinesByRow, RowCommands

# A nozzle is cooled only if it is idle for at least this many times its heating time.
_LEAST_IDLE = 2.0


@dataclass(frozen=True)
class Standby:
    """The times that a nozzle is idle and cooled, S of them.

    Attributes:
        tool: (S,) int64, the nozzle that is cooled.
        cool: (S,) int64, row of the tool change that makes it idle.
        heat: (S,) int64, row before which it is heated again; as many as the moves have if it is not used any more.
        use: (S,) int64, row of the tool change that needs it again, or as `heat`.
        short: how many times a nozzle is idle too briefly and stays hot.
    """

    tool: IntArray
    cool: IntArray
    heat: IntArray
    use: IntArray
    short: int


def standby(moves: Moves, seconds: FloatArray, settings: PrintSettings) -> Standby:
    """When to cool and when to heat.

    Args:
        moves: the print.
        seconds: (M,) `move_times.move_seconds` of the moves.
        settings: standby_temperature_delta and preheat_time are used.
    """
    change = np.flatnonzero(np.diff(moves.tool)) + 1
    passed = np.concatenate([[0.0], np.cumsum(seconds)])
    use = np.append(change[1:], len(moves.tool))[: len(change)]
    idle = np.where(use < len(moves.tool), passed[use] - passed[change], np.inf)
    long = idle >= _LEAST_IDLE * preheat_seconds(settings)
    cool, use = change[long], use[long]
    heat = np.searchsorted(passed, passed[use] - preheat_seconds(settings), side="right") - 1
    heat = np.where(use < len(moves.tool), np.maximum(heat, cool + 1), use)
    return Standby(moves.tool[cool - 1], cool, heat, use, int((~long).sum()))


def preheat_seconds(settings: PrintSettings) -> float:
    """How long before its use a cooled nozzle is heated: `preheat_time`, or longer if it would not be hot by then."""
    return max(settings.preheat_time, settings.standby_temperature_delta / NOZZLE_C_PER_S)


def standby_commands(moves: Moves, found: Standby, settings: PrintSettings) -> RowCommands:
    """Commands of the idle nozzle: it is cooled after a tool change, heated in time, and waited for where it is needed.

    Args:
        moves: the print.
        found: when to cool and when to heat.
        settings: of the print.
    """
    marlin = settings.printer_profile.marlin is not None
    before: LinesByRow = {}
    after: LinesByRow = {}
    columns = (found.tool, found.cool, found.heat, found.use)
    for tool, cool, heat, use in zip(*(column.tolist() for column in columns), strict=True):
        warm = nozzle_temperature(settings, tool, int(moves.layer[cool])) - settings.standby_temperature_delta
        after[cool] = [f"M104 S{max(warm, 0.0):.0f} T{tool}"]
        if use < len(moves.tool):
            hot = nozzle_temperature(settings, tool, int(moves.layer[use]))
            before.setdefault(heat, []).append(f"M104 S{hot:.0f} T{tool}")
            wait = f"M109 S{hot:.0f} T{tool}" if marlin else f"M133 T{tool}"
            before.setdefault(use, []).append(wait)
    return RowCommands(before, after)


def standby_warnings(moves: Moves, seconds: FloatArray, settings: PrintSettings) -> list[str]:
    """Warns that the idle nozzle stays hot although it should be cooled."""
    if not settings.standby_temperature_delta:
        return []
    found = standby(moves, seconds, settings)
    if not found.short:
        return []
    least = _LEAST_IDLE * preheat_seconds(settings)
    times = found.short + len(found.tool)
    return [
        f"the idle nozzle stays hot {found.short} of {times} times, as it is idle for less than "
        f"{least:.0f} s; lower standby_temperature_delta or preheat_time, or print several objects"
    ]
