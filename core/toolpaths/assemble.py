"""Ordered paths → moves: travels, retractions, tool changes, speeds and amounts of filament."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..settings import PrintSettings
from ..slicing.outlines import starts
from ..slicing.planes import Layers
from .moves import Feature, Moves
from .order import OrderedPaths
from .speeds import extrusion_speeds

# Paths that meet within this (mm) go on without a travel.
TOUCHING = 1e-3


@dataclass(frozen=True)
class Approach:
    """How each path is reached from the one before it.

    Attributes:
        changes: (K,) the tool is changed before it.
        retracts: (K,) a long travel with retraction.
        travels: (K,) any travel; True wherever one of the others is.
    """

    changes: BoolArray
    retracts: BoolArray
    travels: BoolArray

    @property
    def rows(self) -> IntArray:
        """(K,) moves before the path's first extrusion: five for a tool change, three for a retracted travel."""
        return np.where(self.changes, 5, np.where(self.retracts, 3, self.travels.astype(np.int64))).astype(np.int64)


def assemble(paths: OrderedPaths, layers: Layers, settings: PrintSettings, single_color: bool = False) -> Moves:
    """All moves of the print.

    A tool change is: retract the old tool, hop, change and travel to the next path above the print, come down, prime.

    Args:
        paths: K paths in printing order.
        layers: the stack.
        settings: of the print.
        single_color: print all layers with tool 0, for comparison.
    """
    tool = np.zeros_like(paths.layer) if single_color else tool_of_layer(paths.layer, settings)
    approach = _approach(paths, tool, settings)
    count = np.diff(paths.start)
    # A path of n points has n - 1 extruding moves after its approach.
    first_row = starts(approach.rows + count - 1)
    table = _extrusions(paths, tool, layers, first_row, settings)
    _fill_approach(table, paths, layers, first_row[:-1], approach, settings)
    return table


def tool_of_layer(layer: IntArray, settings: PrintSettings) -> IntArray:
    """Tool that prints each layer: black on the even ones."""
    return np.where(layer % 2 == 0, settings.black_tool, 1 - settings.black_tool).astype(np.int64)


def _approach(paths: OrderedPaths, tool: IntArray, settings: PrintSettings) -> Approach:
    begin, end = paths.points[paths.start[:-1]], paths.points[paths.start[1:] - 1]
    distance = np.full(len(begin), np.inf)
    distance[1:] = np.hypot(*(begin[1:] - end[:-1]).T)
    changes = np.zeros(len(begin), dtype=bool)
    changes[1:] = tool[1:] != tool[:-1]
    rises = np.zeros(len(begin), dtype=bool)
    rises[1:] = paths.layer[1:] != paths.layer[:-1]
    retracts = (distance > settings.retract_before_travel) & ~changes
    retracts[:1] = False
    return Approach(changes, retracts, (distance > TOUCHING) | rises)


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


def _fill_approach(
    table: Moves, paths: OrderedPaths, layers: Layers, first: IntArray, approach: Approach, settings: PrintSettings
) -> None:
    """Write the rows before each path, in place: retraction, hop, travel, descent and priming."""

    def retraction(rows: IntArray, amount: float, position: FloatArray) -> None:
        table.feature[rows] = Feature.RETRACT
        table.filament[rows] = amount
        table.speed[rows] = settings.retract_speed
        table.position[rows] = position

    last_point = np.column_stack([paths.points[paths.start[1:] - 1], layers.top[paths.layer]])
    first_point = np.column_stack([paths.points[paths.start[:-1]], layers.top[paths.layer]])
    changed = np.flatnonzero(approach.changes)
    row, left, reached = first[changed], last_point[changed - 1], first_point[changed]
    retraction(row, -settings.retract_length_toolchange, left)
    lift = np.array([0.0, 0.0, settings.z_hop])
    table.position[row + 1] = np.maximum(left, [-np.inf, -np.inf, 0]) + lift
    for leaving in (row, row + 1):
        table.tool[leaving] = table.tool[np.maximum(row - 1, 0)]
        table.layer[leaving] = paths.layer[changed - 1]
    table.position[row + 2] = reached + np.maximum(lift, 0)
    table.position[row + 3] = reached
    retraction(row + 4, settings.retract_length_toolchange, reached)

    retracted = np.flatnonzero(approach.retracts)
    row = first[retracted]
    retraction(row, -settings.retract_length, last_point[retracted - 1])
    table.position[row + 1] = first_point[retracted]
    retraction(row + 2, settings.retract_length, first_point[retracted])
