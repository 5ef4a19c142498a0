"""Ordered paths → moves: travels, retractions, tool changes, speeds and amounts of filament."""

from __future__ import annotations

import numpy as np

from ..model import IntArray
from ..settings import PrintSettings
from ..slicing.outlines import starts
from ..slicing.planes import Layers
from .approach import approaches, fill_approaches
from .moves import Feature, Moves
from .order import OrderedPaths
from .speeds import extrusion_speeds


def assemble(paths: OrderedPaths, layers: Layers, settings: PrintSettings, single_color: bool = False) -> Moves:
    """All moves of the print.

    A tool change is: pull the old filament back, lift, change and travel to the next path above the print, come down,
    prime.

    Args:
        paths: K paths in printing order.
        layers: the stack.
        settings: of the print.
        single_color: print all layers with tool 0, for comparison.
    """
    tool = np.zeros_like(paths.layer) if single_color else tool_of_layer(paths.layer, settings)
    approach = approaches(paths, tool, settings)
    count = np.diff(paths.start)
    # A path of n points has n - 1 extruding moves after its approach.
    first_row = starts(approach.rows + count - 1)
    table = _extrusions(paths, tool, layers, first_row, settings)
    fill_approaches(table, paths, layers, first_row[:-1], approach, settings)
    return table


def tool_of_layer(layer: IntArray, settings: PrintSettings) -> IntArray:
    """Tool that prints each layer: black on the object's even ones, and on the raft, which needs no tool change."""
    own = np.maximum(layer - settings.raft_layers, 0)
    return np.where(own % 2 == 0, settings.black_tool, 1 - settings.black_tool).astype(np.int64)


def _extrusions(
    paths: OrderedPaths, tool_of_path: IntArray, layers: Layers, first_row: IntArray, settings: PrintSettings
) -> Moves:
    """The table with all extruding rows filled in; approach rows are travels that do not move yet."""
    total = int(first_row[-1])
    path = np.repeat(np.arange(len(paths.layer)), np.diff(first_row))
    row_in_path = np.arange(total) - first_row[path]
    count = np.diff(paths.start)
    step = row_in_path - (np.diff(first_row) - (count - 1))[path]
    extrudes = step >= 0
    tail = paths.start[path] + np.maximum(step, 0)
    point = np.where(extrudes, tail + 1, paths.start[path])
    layer = paths.layer[path]
    tool = tool_of_path[path]
    width = np.where(extrudes, paths.width[tail], 0.0)
    height = np.where(extrudes, layers.height[layer], 0.0)
    along = np.diff(paths.points, axis=0)
    length = np.where(extrudes, np.append(np.hypot(along[:, 0], along[:, 1]), 0.0)[tail], 0.0)
    diameter = np.where(tool == 0, settings.filament_diameter_0, settings.filament_diameter_1)
    filament = length * width * height * settings.extrusion_multiplier / (np.pi / 4 * diameter**2)
    return Moves(
        position=np.column_stack([paths.points[point], layers.top[layer]]),
        tool=tool,
        feature=np.where(extrudes, paths.feature[path], int(Feature.TRAVEL)),
        layer=layer,
        width=width,
        height=height,
        speed=np.where(extrudes, extrusion_speeds(paths, layers, settings)[tail], settings.travel_speed),
        filament=filament,
    )
