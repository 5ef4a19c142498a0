"""The fan that cools the print, of printers with Marlin or Klipper firmware."""

from __future__ import annotations

import numpy as np

from ..paths import Feature
from ..settings import PrintSettings
from ..toolpaths.moves import Moves


def fan_commands(moves: Moves, settings: PrintSettings) -> tuple[dict[int, list[str]], dict[int, list[str]]]:
    """Commands of the fan by row: before it, and after its tool change; none for MakerBot's dialect.

    They are repeated after each tool change: with a fan at each nozzle they apply to the active one.

    Args:
        moves: the print.
        settings: `fan_speed`, `bridge_fan_speed` and `disable_fan_first_layers` are used.
    """
    if settings.printer_profile.marlin is None:
        return {}, {}
    cooled = moves.layer >= settings.disable_fan_first_layers
    usual, after = _blow(settings.fan_speed), {}
    if settings.fan_speed:
        begins = cooled.copy()
        begins[1:] &= ~cooled[:-1] | (moves.tool[1:] != moves.tool[:-1])
        after = dict.fromkeys(np.flatnonzero(begins).tolist(), usual)
    if settings.bridge_fan_speed <= settings.fan_speed:
        return {}, after
    strands = np.flatnonzero(cooled & moves.extrudes)
    over_air, tool = moves.feature[strands] == Feature.BRIDGE, moves.tool[strands]
    changes = np.diff(over_air, prepend=False) | (over_air & (np.diff(tool, prepend=-1) != 0))
    if not settings.fan_speed:  # the fan of the other nozzle may still blow
        changes |= np.diff(tool, prepend=-1) != 0
    rows = zip(strands[changes].tolist(), over_air[changes].tolist(), strict=True)
    return {row: _blow(settings.bridge_fan_speed) if spans else usual for row, spans in rows}, after


def _blow(percent: float) -> list[str]:
    return [f"M106 S{percent * 2.55:.0f}"]


def fan_off(settings: PrintSettings) -> list[str]:
    """The lines after the print: both fans, since without a number only that of the active nozzle is meant."""
    return ["M107 P0", "M107 P1"] if settings.fan_speed or settings.bridge_fan_speed else []
