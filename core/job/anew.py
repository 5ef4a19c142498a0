"""Some layers made anew where the tone has changed, and put in the place of the former ones.

Each function gives what its stage gives for the whole print: `former` is what it has given last, and only on the layers
that `fresh` (L,) marks does anything that it is made from differ.
"""

from __future__ import annotations

import numpy as np
import shapely

from ..fill.bridges import Bridges
from ..fill.paths import fill_areas, fill_lines
from ..model import BoolArray, FloatArray, IntArray, Shapes
from ..paths import Paths
from ..pattern.contours import Contours
from ..pattern.sampling import Samples
from ..pattern.wave import WavedOutlines, valley_lines, waved
from ..settings import PrintSettings
from ..toolpaths.outer_wall import inside_of_lines, inside_of_wall
from .layers import between, joined, runs, spliced

Areas = tuple[Shapes, ...]


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


def areas_anew(
    former: Areas,
    fresh: BoolArray,
    inside: Shapes,
    island_layer: IntArray,
    solid: Shapes,
    whole: BoolArray,
    settings: PrintSettings,
) -> Areas:
    """As `fill_areas`."""
    own = np.flatnonzero(fresh[island_layer])
    found = fill_areas(inside[own], island_layer[own], solid[own], whole[own], settings)
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
