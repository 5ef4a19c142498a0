"""The fan that cools the print: at any speed with Marlin or Klipper firmware, on or off with MakerBot's dialect."""

from __future__ import annotations

import numpy as np

from ..paths import Feature
from ..settings import PrintSettings
from ..settings.printer import PrinterProfile
from ..toolpaths.moves import Moves
from .row_commands import RowCommands


def fan_commands(moves: Moves, settings: PrintSettings) -> RowCommands:
    """Commands of the fan.

    With Marlin they are repeated after each tool change: with a fan at each nozzle they apply to the active one.

    Args:
        moves: the print.
        settings: `fan_speed`, `bridge_fan_speed` and `disable_fan_first_layers` are used.
    """
    printer = settings.printer_profile
    cooled = moves.layer >= settings.disable_fan_first_layers
    fan = moves.tool if printer.marlin else np.zeros_like(moves.tool)
    usual, after = _blow(settings.fan_speed, printer), {}
    if settings.fan_speed:
        begins = cooled.copy()
        begins[1:] &= ~cooled[:-1] | (fan[1:] != fan[:-1])
        after = dict.fromkeys(np.flatnonzero(begins).tolist(), usual)
    bridging = _blow(settings.bridge_fan_speed, printer)
    if settings.bridge_fan_speed <= settings.fan_speed or bridging == usual:
        return RowCommands({}, after)
    strands = np.flatnonzero(cooled & moves.extrudes)
    over_air, tool = moves.feature[strands] == Feature.BRIDGE, fan[strands]
    changes = np.diff(over_air, prepend=False) | (over_air & (np.diff(tool, prepend=-1) != 0))
    if not settings.fan_speed:  # the fan of the other nozzle may still blow
        changes |= np.diff(tool, prepend=-1) != 0
    rows = zip(strands[changes].tolist(), over_air[changes].tolist(), strict=True)
    return RowCommands({row: bridging if spans else usual for row, spans in rows}, after)


def _blow(percent: float, printer: PrinterProfile) -> list[str]:
    """The line that sets the fan's speed, or switches it."""
    if printer.marlin:
        return [f"M106 S{percent * 2.55:.0f}"]
    return ["M126 T0" if percent else "M127 T0"]


def fan_off(settings: PrintSettings) -> list[str]:
    """The lines after the print: with Marlin both fans, since without a number only the active nozzle's is meant."""
    if not (settings.fan_speed or settings.bridge_fan_speed):
        return []
    return ["M107 P0", "M107 P1"] if settings.printer_profile.marlin else ["M127 T0"]
