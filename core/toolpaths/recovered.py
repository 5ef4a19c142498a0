"""A print recovered from a file, G-code or X3G: layers, kinds of moves and line widths follow from its numbers."""

from __future__ import annotations

import numpy as np

from ..errors import PrintError, counted
from ..model import BoolArray, FloatArray, IntArray
from ..paths import Feature
from ..records import dataclass
from ..settings import PrintSettings
from .moves import Moves

UNKNOWN = -1
_LEAST_PRIMING = 0.01  # mm of filament
_HARDLY = 1e-9  # mm of filament, for moves that need less than the file can tell
_STATED_STEP = 0.002  # mm; widths that a file names are rounded to this
_MOST = 1e6  # mm and mm/s; no printer is larger or faster
_WINDOW = 0.2  # mm to either side over which a line's width is averaged where it varies


@dataclass(frozen=True)
class ReadPrint:
    """A print that was read from a file.

    Attributes:
        name: of the object, or of the file.
        settings: those that the file names, defaults for all others.
        moves: the print, without what stands before its first layer and after its last line.
    """

    name: str
    settings: PrintSettings
    moves: Moves

    @property
    def summary(self) -> str:
        """Layers and meters of strands, nearly the same for the G-code and the X3G of a print."""
        lays = np.flatnonzero(self.moves.extrudes)
        step = self.moves.position[lays] - self.moves.position[np.maximum(lays - 1, 0)]
        meters = float(np.sqrt(np.einsum("ij,ij->i", step, step)).sum()) / 1000
        return f"{counted(len(np.unique(self.moves.layer[lays])), 'layer')}, {meters:.1f} m of strands"


def recovered_moves(
    position: FloatArray,
    tool: IntArray,
    fed: FloatArray,
    speed: FloatArray,
    feature: IntArray,
    settings: PrintSettings,
    steps: tuple[float, float],
    stated: FloatArray | None = None,
) -> Moves:
    """Recover the table of moves from the positions and the filament of a file.

    Every height at which plastic is laid down is a layer, as high as its distance from the one below. The width of a
    line follows from the filament that is fed. For short moves rounding makes it uncertain: a line whose widths agree
    within the rounding gets one width, any other line is smoothed over a few tenths of a millimeter.

    Args:
        position: (M, 3) mm, after each row.
        tool: (M,) 0 or 1.
        fed: (M,) mm of filament during each row.
        speed: (M,) mm/s.
        feature: (M,) a `Feature` for rows that extrude, `UNKNOWN` where the file does not say.
        settings: diameters of the filament, extrusion multipliers, and the width that lines usually have.
        steps: resolution of positions and filament in mm.
        stated: (M,) mm, the width that comments in the file state; it counts where the filament agrees with it.

    Raises:
        PrintError: nothing is extruded, or a number is beyond all bounds.
    """
    if any(np.abs(numbers).max(initial=0.0) > _MOST for numbers in (position, fed, speed)):
        raise PrintError("the file is damaged: a number is beyond all bounds", "export the print again")
    kept = _has_effect(position, tool, fed)
    position, fed, speed = position[kept], fed[kept], speed[kept]
    tool, feature = tool[kept], feature[kept]
    step = np.diff(position, axis=0, prepend=position[:1])
    way = np.sqrt(np.einsum("ij,ij->i", step, step))
    fed = np.where(_slips(way, step[:, 2], fed, steps[0]), _HARDLY, fed)
    kind, lays = _kinds(way, fed, feature)
    way[lays] = np.maximum(way[lays], 1e-6)
    layer, height = _layers(position[:, 2], lays)
    moves = Moves(position, tool, kind, layer, np.zeros(len(way)), height, speed, fed)
    rows = np.flatnonzero(lays)
    stated = None if stated is None else stated[kept][rows]
    moves.width[rows] = _line_widths(moves, rows, way[rows], settings, steps, stated)
    return moves.rows(slice(int(rows[-1]) + 1))


def _kinds(way: FloatArray, fed: FloatArray, feature: IntArray) -> tuple[IntArray, BoolArray]:
    """(M,) the `Feature` of each row, and (M,) which of them lay down a strand.

    Raises:
        PrintError: none does.
    """
    moving = way > 0
    # A move shorter than the file's resolution feeds without moving, less than any priming.
    lays: BoolArray = (fed > 0) & (moving | (fed < _LEAST_PRIMING))
    if not (lays & moving).any():
        raise PrintError("the file lays down no plastic", "choose the G-code of a print")
    kind = np.where(lays, np.where(feature == UNKNOWN, int(Feature.OUTER_WALL), feature), int(Feature.TRAVEL))
    kind[~lays & (fed != 0)] = Feature.RETRACT
    return kind, lays


def _line_widths(
    moves: Moves,
    rows: IntArray,
    way: FloatArray,
    settings: PrintSettings,
    steps: tuple[float, float],
    stated: FloatArray | None,
) -> FloatArray:
    """(K,) mm, widths of the segments of lines.

    Args:
        moves: with all but the widths.
        rows: (K,) those that lay down a strand.
        way: (K,) mm, length of each.
        settings: diameters of the filament, extrusion multipliers, and the width that lines usually have.
        steps: resolution of positions and filament in mm.
        stated: (K,) mm, widths that the file states, or None.
    """
    fed = moves.filament[rows]
    per_mm = np.array(settings.filament_sections) / settings.extrusion_multipliers
    area = fed * per_mm[moves.tool[rows]] / moves.height[rows]
    begins = np.ones(len(rows), dtype=bool)
    begins[1:] = (np.diff(rows) > 1) | (np.diff(moves.layer[rows]) != 0) | (np.diff(moves.feature[rows]) != 0)
    doubt = 1.42 * steps[0] / way + steps[1] / fed  # both ends may be off by half a diagonal
    width = _widths(area, way, doubt, begins, settings.extrusion_width)
    return width if stated is None else _stated_widths(stated, width, area, way, doubt)


def _layers(z: FloatArray, lays: BoolArray) -> tuple[IntArray, FloatArray]:
    """(M,) the layer that each row prints on or travels to, and (M,) mm its height, 0 where nothing is laid down.

    Raises:
        PrintError: a line lies below the bed.
    """
    levels, of = np.unique(np.rint(z[lays] * 1000), return_inverse=True)
    layer = _until_next(of.ravel(), lays)
    height = np.where(lays, np.diff(levels / 1000, prepend=0.0)[layer], 0.0)
    if (height[lays] <= 0).any():
        raise PrintError("the file lays down plastic below the bed", "choose the G-code of a print")
    return layer, height


def _has_effect(position: FloatArray, tool: IntArray, fed: FloatArray) -> BoolArray:
    """(M,) rows that move, feed or change the tool; the others are moves shorter than the file's resolution."""
    kept: BoolArray = fed != 0
    kept[:1] = True
    kept[1:] |= (position[1:] != position[:-1]).any(axis=1) | (tool[1:] != tool[:-1])
    return kept


def _slips(way: FloatArray, rise: FloatArray, fed: FloatArray, step: float) -> BoolArray:
    """(M,) moves within a line so short that their filament was rounded to nothing."""
    lays = (fed > 0) & (way > 0)
    slips: BoolArray = (fed == 0) & (way > 0) & (way < 2.5 * step) & (rise == 0)
    slips[:1] = slips[-1:] = False
    slips[1:-1] &= lays[:-2] & lays[2:]
    return slips


def _until_next(values: IntArray, marked: BoolArray) -> IntArray:
    """(M,) the value of the next marked row at or after each row; the last value where none follows."""
    count: IntArray = np.cumsum(marked) - marked
    return np.asarray(values[np.minimum(count, len(values) - 1)], dtype=np.int64)


def _stated_widths(
    stated: FloatArray, width: FloatArray, area: FloatArray, way: FloatArray, doubt: FloatArray
) -> FloatArray:
    """(K,) mm, the stated widths where the filament agrees with them, else the computed ones."""
    agrees = np.abs(area - stated * way) <= (doubt * stated + _STATED_STEP) * way
    return np.where(agrees, stated, width)


def _widths(area: FloatArray, way: FloatArray, doubt: FloatArray, begins: BoolArray, usual: float) -> FloatArray:
    """(K,) mm, widths of the segments of lines.

    Args:
        area: (K,) mm², what each segment covers of the bed.
        way: (K,) mm, its length.
        doubt: (K,) relative uncertainty of its width.
        begins: (K,) where a line begins.
        usual: mm; widths within 0.2 % of this are set to it.
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
    span = ways[high] - ways[low]  # 0 where a file's long ways swamp it
    around = np.divide(areas[high] - areas[low], span, out=own.copy(), where=span > 0)
    smooth = np.where(np.abs(own - around) <= around * doubt, around, own)
    width: FloatArray = np.where(even, mean, smooth)
    width[np.abs(width - usual) <= 0.002 * usual] = usual
    return width
