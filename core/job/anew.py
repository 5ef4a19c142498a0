"""Stages run again on the layers whose tones have changed; all other layers keep their former results.

Each `…_anew` returns what its stage returns for the whole print, or None where that may differ on other layers too.
`former` is the stage's last result; its inputs differ from those of that run only on layers that `fresh` (L,) marks.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
import shapely

from ..calibration.calibrate import ToneCurve
from ..contours.contours import Contours
from ..fill.bridges import Bridges
from ..fill.paths import fill_lines
from ..model import BoolArray, FloatArray, IntArray, Shapes
from ..paths import Paths
from ..pattern.strand_edges import widened
from ..pattern.wave import WavedOutlines, modulated, valley_lines
from ..ragged import runs
from ..sampling.samples import Samples
from ..settings import PrintSettings
from ..texture.lookup import tone_at
from ..texture.pyramid import TexturePyramids
from ..toolpaths.outer_wall import inside_of_lines, inside_of_wall
from .layers import between, joined, spliced

Areas = tuple[Shapes, ...]
Result = TypeVar("Result")


def along_lines(whole: Callable[..., Result]) -> Callable[..., Result]:
    """Another function that makes some layers anew of what this one makes loop by loop.

    Args:
        whole: gives columns (N,) of the contour points, columns (I,) of the islands, or outlines. Of the contours among
            its arguments, and of what goes with them (outlines, samples, columns of the points), it is handed those of
            the layers in question; all else as it is.
    """

    def anew(former: Result, fresh: BoolArray, *arguments: Any) -> Result:
        lines = next(given for given in arguments if isinstance(given, Contours))
        parts = [whole(*(_of_layers(given, lines, first, last) for given in arguments)) for first, last in runs(fresh)]
        made: Result = _put(former, parts, fresh, lines)
        return made

    return anew


def _of_layers(given: Any, lines: Contours, first: int, last: int) -> Any:
    """What of an argument belongs to the layers from `first` to the one before `last`."""
    loops, points = _places(lines, first, last)
    if isinstance(given, Contours):
        return between(given, first, last)
    if isinstance(given, WavedOutlines):
        return between(given, first, last)
    if isinstance(given, Samples):
        own = slice(*given.start[[loops.start, loops.stop]].tolist())
        start = given.start[loops.start : loops.stop + 1] - own.start
        return Samples(given.arc[own], given.loop[own] - loops.start, start)
    return given[points] if isinstance(given, np.ndarray) and len(given) == len(lines.points) else given


def _put(former: Any, parts: list[Any], fresh: BoolArray, lines: Contours) -> Any:
    """What a function has given last, with what it gives for each run of fresh layers put in its place."""
    if isinstance(former, tuple):
        columns = zip(former, zip(*parts, strict=True), strict=True)
        return tuple(_put(column, list(made), fresh, lines) for column, made in columns)
    if not isinstance(former, np.ndarray):
        return spliced(former, joined(parts), fresh)
    column = former.copy()
    for (first, last), part in zip(runs(fresh), parts, strict=True):
        loops, points = _places(lines, first, last)
        if len(column) == len(lines.points):
            column[points] = part
        else:
            islands = np.unique(lines.polygon[loops])
            column[islands] = part[islands]
    return column


def painted_tone(pyramids: TexturePyramids, lines: Contours, settings: PrintSettings) -> FloatArray:
    """(N,) tone of the pictures at every contour point."""
    own = lines.carried[:, 2] if lines.carried.shape[1] > 2 else None
    return tone_at(pyramids, lines.face, lines.carried[:, :2], own, settings.background_tone)


def print_tones(tone: FloatArray, slant_deg: FloatArray, lines: Contours, curve: ToneCurve | None) -> FloatArray:
    """(N,) tones to print for those asked for."""
    return tone if curve is None else curve.printed(tone, slant_deg)


def set_back_lines(
    printed: FloatArray, lines: Contours, slant_deg: FloatArray, settings: PrintSettings
) -> tuple[FloatArray, FloatArray]:
    """(N,) depth of the waves and (N,) set-back, mm, by the tones to print (N,)."""
    depth, set_back = modulated(lines, printed, slant_deg, settings)
    return depth, widened(lines, printed, set_back, settings)


def inside_lines(
    outlines: WavedOutlines,
    lines: Contours,
    depth: FloatArray,
    set_back: FloatArray,
    waves: bool,
    polygons: int,
    tolerance: float,
) -> Shapes:
    """As `inside_of_wall`; `waves` tells whether there are any on the whole print."""
    if waves:
        return inside_of_lines(lines, valley_lines(lines, depth, set_back), polygons, tolerance)
    return inside_of_wall(outlines, lines, depth, set_back, polygons, tolerance)


def by_islands(whole: Callable[..., Areas], island_layer: IntArray) -> Callable[..., Areas]:
    """Another function that makes some layers anew of what this one makes island by island.

    Args:
        whole: gives columns (I,) of the islands. Of the columns among its arguments it is handed the rows of the
            islands in question; all else as it is.
        island_layer: (I,) layer of each island.
    """

    def anew(former: Areas, fresh: BoolArray, *arguments: Any) -> Areas:
        own = np.flatnonzero(fresh[island_layer])
        found = whole(*(given[own] if isinstance(given, np.ndarray) else given for given in arguments))
        areas = tuple(column.copy() for column in former)
        for column, part in zip(areas, found, strict=True):
            column[own] = part
        return areas

    return anew


def filled_anew(
    former: Paths,
    fresh: BoolArray,
    walls: Areas,
    fill: Areas,
    over_air: Bridges,
    island_layer: IntArray,
    settings: PrintSettings,
) -> Paths:
    """As `fill_lines`."""
    own = fresh[island_layer]
    walls, fill = (tuple(np.where(own, column, shapely.Polygon()) for column in areas) for areas in (walls, fill))
    held = own[over_air.island]
    bridges = Bridges(over_air.regions[held], over_air.island[held], over_air.angle_deg[held])
    return Paths.joined(
        [former.selected(~fresh[former.layer]), fill_lines(walls, fill, bridges, island_layer, settings)]
    )


def _places(lines: Contours, first: int, last: int) -> tuple[slice, slice]:
    """The loops of layers from `first` to the one before `last`, and their points."""
    low, high = np.searchsorted(lines.layer, (first, last)).tolist()
    return slice(low, high), slice(int(lines.start[low]), int(lines.start[high]))
