"""G-code for Marlin and Klipper firmware: bare `T0` and `T1`, one axis E, relative extrusion.

The lines at the start, at a tool change and at the end differ from printer to printer and come from its profile.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..model import IntArray
from ..settings import PrintSettings
from ..settings.printer import MarlinCommands
from .fan import fan_off

FILAMENT_AXIS = "E"


def marlin_start(
    commands: MarlinCommands, settings: PrintSettings, tools: tuple[int, ...], retracted: tuple[float, float]
) -> list[str]:
    """The profile's start, then each tool pulled back as far as the print expects it; the last one starts the print.

    Args:
        commands: of the printer.
        settings: of the print.
        tools: that the print uses.
        retracted: mm of filament that each tool is left pulled back.
    """
    lines = _filled(commands.start, settings, tools[-1])
    for tool in tools:
        lines += marlin_tool_change(commands, tool)
        if retracted[tool] > 0:
            lines.append(f"G1 {FILAMENT_AXIS}{-retracted[tool]:.5f} F{settings.retract_speed * 60:.0f}")
    return lines


def marlin_tool_change(commands: MarlinCommands, tool: int) -> list[str]:
    """Switch the active nozzle; the firmware knows how far the nozzles are apart."""
    return [line.replace("{tool}", str(tool)) for line in commands.tool_change]


def marlin_end(commands: MarlinCommands, settings: PrintSettings, tool: int) -> list[str]:
    """Pull the filament of the active tool back, then the profile's end."""
    pull_back = f"G1 {FILAMENT_AXIS}{-settings.retract_length:.5f} F{settings.retract_speed * 60:.0f}"
    return [pull_back, *fan_off(settings), *_filled(commands.end, settings, tool)]


def fed_by_each(counter: IntArray, tool: IntArray) -> IntArray:
    """(M,) what each row feeds: differences of its tool's counter (M,), so that rounding errors never add up."""
    fed = np.empty_like(counter)
    for number in np.unique(tool):
        rows = np.flatnonzero(tool == number)
        fed[rows] = np.diff(counter[rows], prepend=0)
    return fed


def _filled(lines: Iterable[str], settings: PrintSettings, tool: int) -> list[str]:
    values = {
        "{bed}": settings.bed_temperature,
        "{nozzle_0}": settings.nozzle_temperature_0,
        "{nozzle_1}": settings.nozzle_temperature_1,
        "{tool}": tool,
    }
    filled = []
    for line in lines:
        for name, value in values.items():
            line = line.replace(name, f"{value:.0f}")
        filled.append(line)
    return filled
