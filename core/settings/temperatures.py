"""How hot nozzles and bed are, layer by layer."""

from __future__ import annotations

import numpy as np

from ..model import IntArray
from .print_settings import PrintSettings


def nozzle_temperature(settings: PrintSettings, tool: int, layer: int) -> float:
    """°C of a tool on a layer, counted from the bed."""
    if tool:
        usual, first = settings.nozzle_temperature_1, settings.first_layer_temperature_1
    else:
        usual, first = settings.nozzle_temperature_0, settings.first_layer_temperature_0
    return first if layer == 0 and first else usual


def bed_temperature(settings: PrintSettings, layer: int) -> float:
    """°C of the bed while a layer is printed, counted from the bed."""
    first = settings.first_layer_bed_temperature
    # Files hold whole degrees: what would be 0 there is that of the other layers, too.
    return first if layer == 0 and round(first) else settings.bed_temperature


def starting_temperatures(settings: PrintSettings, tool: IntArray, layer: IntArray) -> dict[int, float]:
    """°C of the tools that a print uses, each on the layer where it is used first.

    Args:
        settings: of the print.
        tool: (M,) of its moves, in their order.
        layer: (M,) of its moves.
    """
    first = {number: int(np.argmax(tool == number)) for number in (0, 1)}
    return {n: nozzle_temperature(settings, n, int(layer[row])) for n, row in first.items() if tool[row] == n}
