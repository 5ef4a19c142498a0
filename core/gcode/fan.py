"""The fan that cools the print, of printers with Marlin or Klipper firmware."""

from __future__ import annotations

import numpy as np

from ..settings import PrintSettings
from ..toolpaths.moves import Moves


def fan_commands(moves: Moves, settings: PrintSettings) -> dict[int, list[str]]:
    """Commands that switch the fan on, by the row before which they stand; none for MakerBot's dialect.

    They are repeated after each tool change: with a fan at each nozzle they apply to the active one.

    Args:
        moves: the print.
        settings: `fan_speed` and `disable_fan_first_layers` are used.
    """
    if not settings.fan_speed or settings.printer_profile.marlin is None:
        return {}
    cooled = moves.layer >= settings.disable_fan_first_layers
    begins = cooled.copy()
    begins[1:] &= ~cooled[:-1] | (moves.tool[1:] != moves.tool[:-1])
    return {row: [f"M106 S{settings.fan_speed * 2.55:.0f}"] for row in np.flatnonzero(begins).tolist()}


def fan_off(settings: PrintSettings) -> list[str]:
    """The lines after the print: both fans, since without a number only that of the active nozzle is meant."""
    return ["M107 P0", "M107 P1"] if settings.fan_speed else []
