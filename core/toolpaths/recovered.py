"""Moves from what a printer is told: layers, features and line widths are found again from the numbers."""

from __future__ import annotations

import numpy as np

from ..errors import PrintError
from ..model import BoolArray, FloatArray, IntArray
from ..settings import PrintSettings
from .moves import Feature, Moves

UNKNOWN = -1
_LEAST_PRIMING = 0.01  # mm of filament
_WINDOW = 0.3  # mm to either side over which a line's width is averaged where it varies


def recovered_moves(
    position: FloatArray,
    tool: IntArray,
    fed: FloatArray,
    speed: FloatArray,
    feature: IntArray,
    settings: PrintSettings,
    steps: tuple[float, float],
) -> Moves:
    """The table of moves of a file.

    A layer is a height at which plastic is laid down; it is as high as its distance from the layer below. A line's
    width follows from the filament fed. Rounding makes it uncertain for short moves, so a line whose widths agree
    within that has one width, and elsewhere it is averaged over a few tenths of a millimetre.

    Args:
        position: (M, 3) mm, after each row.
        tool: (M,) 0 or 1.
        fed: (M,) mm of filament during each row.
        speed: (M,) mm/s.
        feature: (M,) a `Feature` for rows that extrude, `UNKNOWN` where the file does not tell.
        settings: diameters of the filament, and the width that lines usually have.
        steps: resolution of positions and filament in mm.

    Raises:
        PrintError: nothing is extruded.
    """
    way = np.zeros(len(tool))
    step = np.diff(position, axis=0)
    way[1:] = np.sqrt(np.einsum("ij,ij->i", step, step))
    moving = way > 0
    # A move shorter than the file's resolution feeds without moving, less than any priming.
    lays = (fed > 0) & (moving | (fed < _LEAST_PRIMING))
    if not (lays & moving).any():
        raise PrintError("the file lays down no plastic", "choose the G-code of a print")
    last = int(np.flatnonzero(lays)[-1]) + 1
    kind = np.where(lays, np.where(feature == UNKNOWN, int(Feature.OUTER_WALL), feature), int(Feature.TRAVEL))
    kind[~lays & (fed != 0)] = Feature.RETRACT
    way[lays] = np.maximum(way[lays], 1e-6)
    levels, of = np.unique(np.rint(position[lays, 2] * 1000), return_inverse=True)
    layer = _until_next(of.ravel(), lays)
    height = np.where(lays, np.diff(levels / 1000, prepend=0.0)[layer], 0.0)
    if (height[lays] <= 0).any():
        raise PrintError("the file lays down plastic below the bed", "choose the G-code of a print")
    diameter = np.where(tool == 0, settings.filament_diameter_0, settings.filament_diameter_1)
    section = fed * (np.pi / 4 / settings.extrusion_multiplier) * diameter**2
    rows = np.flatnonzero(lays)
    width = np.zeros(len(tool))
    doubt = 0.8 * steps[0] / way[rows] + steps[1] / fed[rows]
    begins = np.ones(len(rows), dtype=bool)
    begins[1:] = (np.diff(rows) > 1) | (np.diff(layer[rows]) != 0) | (np.diff(kind[rows]) != 0)
    width[rows] = _widths(section[rows] / height[rows], way[rows], doubt, begins, settings.extrusion_width)
    end = slice(last)
    return Moves(position[end], tool[end], kind[end], layer[end], width[end], height[end], speed[end], fed[end])


def _until_next(values: IntArray, marked: BoolArray) -> IntArray:
    """(M,) the value of the next marked row, of the last one after that."""
    count: IntArray = np.cumsum(marked) - marked
    return np.asarray(values[np.minimum(count, len(values) - 1)], dtype=np.int64)


def _widths(area: FloatArray, way: FloatArray, doubt: FloatArray, begins: BoolArray, usual: float) -> FloatArray:
    """(K,) mm, widths of the segments of lines.

    Args:
        area: (K,) mm², what each segment covers of the bed.
        way: (K,) mm, its length.
        doubt: (K,) relative uncertainty of its width.
        begins: (K,) where a line begins.
        usual: mm, what widths that are as good as this one are set to.
    """
    first = np.flatnonzero(begins)
    counts = np.diff(np.append(first, len(begins)))
    own = area / way
    mean = np.repeat(np.add.reduceat(area, first) / np.add.reduceat(way, first), counts)
    agrees = np.abs(own - mean) <= mean * doubt + 1e-4
    even = np.repeat(np.logical_and.reduceat(agrees, first), counts)
    # Where the width varies: what lies within the window, of the same line.
    ends = np.cumsum(way)
    middle = ends - way / 2
    line_first = np.repeat(first, counts)
    line_last = line_first + np.repeat(counts, counts)
    low = np.maximum(np.searchsorted(middle, middle - _WINDOW), line_first)
    high = np.minimum(np.searchsorted(middle, middle + _WINDOW, side="right"), line_last)
    areas = np.concatenate([[0.0], np.cumsum(area)])
    ways = np.concatenate([[0.0], ends])
    around = (areas[high] - areas[low]) / (ways[high] - ways[low])
    smooth = np.where(np.abs(own - around) <= around * doubt, around, own)
    width: FloatArray = np.where(even, mean, smooth)
    width[np.abs(width - usual) <= 0.002 * usual] = usual
    return width
