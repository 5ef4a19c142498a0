"""Stages run again on the layers whose tones have changed; all other layers keep their former results.

Each function returns what its stage returns for the whole print. `former` is the stage's last result; its inputs differ
from those of that run only on the layers that `fresh` (L,) marks.
"""

from __future__ import annotations

import numpy as np
import shapely

from ..calibration.calibrate import ToneCurve
from ..contours.contours import Contours
from ..fill.bridges import Bridges
from ..fill.paths import fill_areas, fill_lines
from ..model import BoolArray, FloatArray, IntArray, Shapes
from ..paths import Paths
from ..pattern.strand_edges import widened
from ..pattern.wave import WavedOutlines, modulated, valley_lines, waved
from ..sampling.sampling import Samples
from ..settings import PrintSettings
from ..texture.lookup import tone_at
from ..texture.pyramid import TexturePyramids
from ..toolpaths.outer_wall import inside_of_lines, inside_of_wall, straight_parts
from .layers import between, joined, runs, spliced

Areas = tuple[Shapes, ...]


def painted_tone(pyramids: TexturePyramids, lines: Contours, settings: PrintSettings) -> FloatArray:
    """(N,) tone of the pictures at every contour point."""
    return tone_at(pyramids, lines.face, lines.carried[:, :2], lines.carried[:, 2], settings.background_tone)


def painted_tone_anew(
    former: FloatArray, fresh: BoolArray, pyramids: TexturePyramids, lines: Contours, settings: PrintSettings
) -> FloatArray:
    """As `painted_tone`."""
    tone = former.copy()
    for first, last in runs(fresh):
        tone[_places(lines, first, last)[1]] = painted_tone(pyramids, between(lines, first, last), settings)
    return tone


def print_tones(tone: FloatArray, slant_deg: FloatArray, lines: Contours, curve: ToneCurve | None) -> FloatArray:
    """(N,) tones to print for those asked for."""
    return tone if curve is None else curve.printed(tone, slant_deg)


def print_tones_anew(
    former: FloatArray,
    fresh: BoolArray,
    tone: FloatArray,
    slant_deg: FloatArray,
    lines: Contours,
    curve: ToneCurve | None,
) -> FloatArray:
    """As `print_tones`."""
    if curve is None:
        return tone
    printed = former.copy()
    for first, last in runs(fresh):
        points = _places(lines, first, last)[1]
        printed[points] = curve.printed(tone[points], slant_deg[points])
    return printed


def set_back_lines(
    printed: FloatArray, lines: Contours, slant_deg: FloatArray, settings: PrintSettings
) -> tuple[FloatArray, FloatArray]:
    """(N,) depth of the waves and (N,) set-back, mm, by the tones to print (N,)."""
    depth, set_back = modulated(lines, printed, slant_deg, settings)
    return depth, widened(lines, printed, set_back, settings)


def modulated_anew(
    former: tuple[FloatArray, FloatArray],
    fresh: BoolArray,
    printed: FloatArray,
    lines: Contours,
    slant_deg: FloatArray,
    settings: PrintSettings,
) -> tuple[FloatArray, FloatArray]:
    """As `set_back_lines`."""
    depth, set_back = (column.copy() for column in former)
    for first, last in runs(fresh):
        points = _places(lines, first, last)[1]
        some = between(lines, first, last)
        depth[points], set_back[points] = set_back_lines(printed[points], some, slant_deg[points], settings)
    return depth, set_back


def waved_anew(
    former: WavedOutlines,
    fresh: BoolArray,
    lines: Contours,
    samples: Samples,
    tone: FloatArray,
    depth: FloatArray,
    set_back: FloatArray,
    settings: PrintSettings,
    swapped: BoolArray | None = None,
) -> WavedOutlines:
    """As `waved`."""
    parts = []
    for first, last in runs(fresh):
        loops, points = _places(lines, first, last)
        own = slice(*samples.start[[loops.start, loops.stop]].tolist())
        start = samples.start[loops.start : loops.stop + 1] - own.start
        some = Samples(samples.arc[own], samples.loop[own] - loops.start, start)
        own_lines, also = between(lines, first, last), None if swapped is None else swapped[points]
        parts.append(waved(own_lines, some, tone[points], depth[points], set_back[points], settings, also))
    return spliced(former, joined(parts), fresh)


def inside_anew(
    former: Shapes,
    fresh: BoolArray,
    outlines: WavedOutlines,
    lines: Contours,
    depth: FloatArray,
    set_back: FloatArray,
    island_layer: IntArray,
    tolerance: float,
) -> Shapes:
    """As `inside_of_wall`."""
    inside, count, waves = former.copy(), len(island_layer), bool(depth.any())
    for first, last in runs(fresh):
        _, points = _places(lines, first, last)
        some, wall, moved = (
            between(lines, first, last),
            between(outlines, first, last),
            (depth[points], set_back[points]),
        )
        if waves:
            found = inside_of_lines(some, valley_lines(some, *moved), count, tolerance)
        else:
            found = inside_of_wall(wall, some, *moved, count, tolerance)
        own = slice(*np.searchsorted(island_layer, (first, last)).tolist())
        inside[own] = found[own]
    return inside


def straight_anew(
    former: Shapes,
    fresh: BoolArray,
    lines: Contours,
    depth: FloatArray,
    set_back: FloatArray,
    polygons: int,
    settings: PrintSettings,
) -> Shapes:
    """As `straight_parts`."""
    straight = former.copy()
    for first, last in runs(fresh):
        loops, points = _places(lines, first, last)
        some = between(lines, first, last)
        found = straight_parts(some, depth[points], set_back[points], polygons, settings)
        own = np.unique(lines.polygon[loops])
        straight[own] = found[own]
    return straight


def areas_anew(
    former: Areas,
    fresh: BoolArray,
    inside: Shapes,
    straight: Shapes,
    island_layer: IntArray,
    solid: Shapes,
    whole: BoolArray,
    settings: PrintSettings,
) -> Areas:
    """As `fill_areas`."""
    own = np.flatnonzero(fresh[island_layer])
    found = fill_areas(inside[own], straight[own], island_layer[own], solid[own], whole[own], settings)
    areas = tuple(column.copy() for column in former)
    for column, part in zip(areas, found, strict=True):
        column[own] = part
    return areas


def filled_anew(
    former: Paths, fresh: BoolArray, areas: Areas, over_air: Bridges, island_layer: IntArray, settings: PrintSettings
) -> Paths:
    """As `fill_lines`."""
    own = fresh[island_layer]
    some = tuple(np.where(own, column, shapely.Polygon()) for column in areas)
    held = own[over_air.island]
    bridges = Bridges(over_air.regions[held], over_air.island[held], over_air.angle_deg[held])
    return Paths.joined([former.selected(~fresh[former.layer]), fill_lines(some, bridges, island_layer, settings)])


def _places(lines: Contours, first: int, last: int) -> tuple[slice, slice]:
    """The loops of layers from `first` to the one before `last`, and their points."""
    low, high = np.searchsorted(lines.layer, (first, last)).tolist()
    return slice(low, high), slice(int(lines.start[low]), int(lines.start[high]))
