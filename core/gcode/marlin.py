"""G-code for Marlin and Klipper firmware: bare `T0` and `T1`, one axis E, relative extrusion.

The lines at the start, at a tool change and at the end differ from printer to printer and come from its profile.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from ..model import IntArray
from ..settings import PrintSettings
from ..settings.printer import MarlinCommands
from ..settings.temperatures import bed_temperature, nozzle_temperature
from .fan import fan_off

FILAMENT_AXIS = "E"


def marlin_start(commands: MarlinCommands, settings: PrintSettings, hot: dict[int, float]) -> list[str]:
    """The profile's start, before the nozzles are primed.

    Args:
        commands: of the printer.
        settings: of the print.
        hot: °C of the tools that the print uses; the last one starts the print.
    """
    *_, first = hot
    printer = settings.printer_profile
    values: dict[str, float] = {"{bed}": bed_temperature(settings, 0), "{tool}": first}
    for tool in (0, 1):
        degrees = hot.get(tool, 0.0)
        values |= {f"{{nozzle_{tool}}}": degrees, f"{{warm_up_{tool}}}": min(printer.warm_up_c, degrees)}
    return _filled(commands.start, values | {"{acceleration}": min(printer.acceleration_mm_s2[:2])})


def marlin_tool_change(commands: MarlinCommands, tool: int) -> list[str]:
    """Switch the active nozzle; the firmware knows how far the nozzles are apart."""
    return [line.replace("{tool}", str(tool)) for line in commands.tool_change]


def marlin_end(commands: MarlinCommands, settings: PrintSettings, tool: int) -> list[str]:
    """Pull the filament of the active tool back, then the profile's end."""
    pull_back = f"G1 {FILAMENT_AXIS}{-settings.retract_length:.5f} F{settings.retract_speed * 60:.0f}"
    values = {f"{{nozzle_{number}}}": nozzle_temperature(settings, number, 1) for number in (0, 1)}
    values |= {"{bed}": bed_temperature(settings, 1), "{tool}": tool}
    return [pull_back, *fan_off(settings), *_filled(commands.end, values)]


def fed_by_each(counter: IntArray, tool: IntArray) -> IntArray:
    """(M,) what each row feeds: differences of its tool's counter (M,), so that rounding errors never add up."""
    fed = np.empty_like(counter)
    for number in np.unique(tool):
        rows = np.flatnonzero(tool == number)
        fed[rows] = np.diff(counter[rows], prepend=0)
    return fed


def _filled(lines: Iterable[str], values: Mapping[str, float]) -> list[str]:
    """Lines with numbers in place of names."""
    filled = []
    for line in lines:
        for name, value in values.items():
            line = line.replace(name, f"{value:.0f}")
        filled.append(line)
    return filled
