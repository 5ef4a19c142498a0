"""From the temperatures of the first layer to those of the others."""

from __future__ import annotations

import numpy as np

from ..settings import PrintSettings
from ..settings.temperatures import bed_temperature, nozzle_temperature
from ..toolpaths.moves import Moves
from .row_commands import RowCommands
from .standby import Standby


def after_first_layer(moves: Moves, settings: PrintSettings, resting: Standby | None) -> RowCommands:
    """Commands of the heaters where the second layer begins, after its tool change.

    Args:
        moves: the print.
        settings: of the print.
        resting: when nozzles are cooled; one that is gets its other temperature when it is heated again. None if they
            never are.
    """
    row = int(np.searchsorted(moves.layer, 0, side="right"))
    if row == len(moves.layer):
        return RowCommands({}, {})
    lines = []
    bed, first_bed = bed_temperature(settings, 1), bed_temperature(settings, 0)
    if bed != first_bed:
        lines.append(f"M140 S{bed:.0f}" if settings.printer_profile.marlin else f"M109 S{bed:.0f} T0")
    for tool in np.unique(moves.tool[:row]).tolist():
        hot = nozzle_temperature(settings, tool, 1)
        cooled = resting is not None and bool(
            ((resting.tool == tool) & (resting.cool <= row) & (row < resting.use)).any()
        )
        if hot != nozzle_temperature(settings, tool, 0) and not cooled:
            lines.append(f"M104 S{hot:.0f} T{tool}")
    return RowCommands({}, {row: lines} if lines else {})
