"""Ordered paths → moves: travels, retractions, tool changes, speeds and amounts of filament."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray, IntArray
from ..paths import Feature
from ..ragged import ranges, starts
from ..settings import PrintSettings
from ..slicing.planes import Layers
from .approach import approaches, fill_approaches
from .layer_time import short_layers, slow_short_layers
from .moves import Moves
from .order import OrderedPaths
from .raft import strand_heights
from .speeds import chord_lengths, extrusion_speeds
from .tool_turns import tool_of_paths
from .travels import Rooms, travels


def assemble(
    paths: OrderedPaths,
    layers: Layers,
    settings: PrintSettings,
    within: Rooms | None = None,
    single_color: bool = False,
) -> Moves:
    """All moves of the print.

    At a tool change the old filament is pulled back and the nozzle lifted; the new tool travels to the next path above
    the print, comes down and primes.

    Args:
        paths: K paths in printing order.
        layers: the stack.
        settings: of the print.
        within: the rooms inside which travels stay unseen; None if all travels are straight.
        single_color: print all layers with tool 0, for comparison.
    """
    tool = np.zeros_like(paths.layer) if single_color else tool_of_paths(paths.layer, paths.swapped, settings)
    height = strand_heights(paths.layer, paths.feature, layers, settings)
    ways = travels(paths, within, settings)
    length = chord_lengths(paths)
    speed = extrusion_speeds(paths, height, length, settings)
    short = short_layers(paths, length, speed, settings)
    approach = approaches(paths, tool, length, ways, settings)
    filament = _filament(paths, tool, height, length, settings)
    top = layers.top[paths.layer]
    table, first_row = _extrusions(paths, approach.rows, tool, top, height, speed, filament, settings)
    fill_approaches(table, paths, layers, first_row, approach, length, settings)
    slow_short_layers(table, short, settings)
    return table


def _extrusions(
    paths: OrderedPaths,
    approach: IntArray,
    tool: IntArray,
    top: FloatArray,
    height: FloatArray,
    speed: FloatArray,
    filament: FloatArray,
    settings: PrintSettings,
) -> tuple[Moves, IntArray]:
    """The table with all extruding rows filled in, and (K,) the row at which each path's approach begins.

    Args:
        paths: K, in printing order.
        approach: (K,) rows before each path's first extrusion; here they are travels to its first point.
        tool: (K,) that prints each.
        top: (K,) mm, Z at which the nozzle prints each.
        height: (K,) mm, of its lines.
        speed: (N,) mm/s, of the line that leaves each point.
        filament: (N,) mm that this line takes.
        settings: `travel_speed` is used.
    """
    rows = approach + np.diff(paths.start) - 1  # a path of n points has n - 1 extruding moves after its approach
    first_row = starts(rows)
    before = ranges(first_row[:-1], approach)
    point = _arriving_at(paths, approach, first_row, before)
    table = Moves.blank(len(point))
    table.position[:, :2] = paths.points.take(point, axis=0)
    of_paths = (
        (table.position[:, 2], top),
        (table.height, height),
        (table.tool, tool),
        (table.feature, paths.feature),
        (table.layer, paths.layer),
    )
    for column, of_path in of_paths:
        column[:] = np.repeat(of_path, rows)
    point -= 1  # the point that the line leaves
    for column, of_point in ((table.width, paths.width), (table.speed, speed), (table.filament, filament)):
        column[:] = of_point.take(point)
    table.feature[before], table.speed[before] = int(Feature.TRAVEL), settings.travel_speed
    for column in (table.width, table.height, table.filament):
        column[before] = 0.0
    return table, first_row[:-1]


def _filament(
    paths: OrderedPaths, tool: IntArray, height: FloatArray, length: FloatArray, settings: PrintSettings
) -> FloatArray:
    """(N,) mm of filament that the line of `length` (N,) takes that leaves each point; the rest as in `_extrusions`."""
    factor = np.array(settings.extrusion_multipliers) / settings.filament_sections
    filament = length * paths.width
    filament *= np.repeat(height * factor[tool], np.diff(paths.start))
    return filament


def _arriving_at(paths: OrderedPaths, approach: IntArray, first_row: IntArray, before: IntArray) -> IntArray:
    """(M,) the point at which each row's move arrives; those of an approach arrive at the first point of its path.

    Args:
        paths: K, in printing order.
        approach: (K,) rows before each path's first extrusion.
        first_row: (K + 1,) where each path's rows start.
        before: the rows of all approaches.
    """
    point = np.arange(int(first_row[-1]))
    point += np.repeat(paths.start[:-1] - first_row[:-1] - approach + 1, np.diff(first_row))
    point[before] = np.repeat(paths.start[:-1], approach)
    return point
