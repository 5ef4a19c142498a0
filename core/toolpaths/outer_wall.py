"""The waved outlines as paths, and the room that they leave for what lies behind them."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from ..fill.parallel import in_chunks
from ..model import BoolArray, FloatArray, IntArray
from ..pattern.contours import Contours
from ..pattern.wave import WavedOutlines, valley_lines
from ..slicing.outlines import ahead, preceding, ranges, starts, sums
from ..slicing.regions import ring_polygons
from .moves import Feature, Paths


def outer_wall_paths(waved: WavedOutlines) -> Paths:
    """One closed path an outline, or open ones where two tools share it; the island is the region that it bounds."""
    if waved.swapped is not None:
        return _shared(waved, waved.swapped)
    loops = len(waved.layer)
    return Paths(
        points=waved.points,
        start=waved.start,
        layer=waved.layer,
        feature=np.full(loops, int(Feature.OUTER_WALL), dtype=np.int64),
        island=waved.polygon,
        closed=np.ones(loops, dtype=bool),
        width=waved.width,
    )


def _shared(waved: WavedOutlines, swapped: BoolArray) -> Paths:
    """The outlines cut where the tool changes; each piece ends where the next one begins.

    Args:
        waved: the outlines, N points.
        swapped: (N,) bool, what the other tool prints.
    """
    start, count = waved.start, np.diff(waved.start)
    begins = swapped != swapped[preceding(start)]
    cut = np.bincount(np.repeat(np.arange(len(count)), count), begins, minlength=len(count)) > 0
    begins[start[:-1][~cut]] = True
    # The points of each loop from its first beginning on.
    loop = np.repeat(np.arange(len(count)), count)
    first = np.flatnonzero(begins)
    first = first[np.searchsorted(first, start[:-1])] - start[:-1]
    point = start[loop] + (np.arange(start[-1]) - start[loop] + first[loop]) % count[loop]
    piece = np.flatnonzero(begins[point])
    of = loop[piece]
    length = np.diff(np.append(piece, len(point)))
    place = ranges(piece, length + cut[of])
    last = np.cumsum(length + cut[of]) - 1
    wraps = last[cut[of] & (piece + length == start[of + 1])]
    place[wraps] = start[loop[place[wraps] - 1]]
    return Paths(
        points=waved.points[point[place]],
        start=starts(length + cut[of]),
        layer=waved.layer[of],
        feature=np.full(len(piece), int(Feature.OUTER_WALL), dtype=np.int64),
        island=waved.polygon[of],
        closed=~cut[of],
        width=waved.width[point[place]],
        swapped=swapped[point[piece]],
    )


def inside_of_wall(
    lines: Contours, depth: FloatArray, set_back: FloatArray, polygons: int, tolerance: float
) -> NDArray[np.object_]:
    """(I,) what lies inside the innermost line of the outer wall of each sliced region; empty where nothing does.

    Args:
        lines: contours; their `polygon` is one of the I regions.
        depth: (N,) mm, of the wave at each contour point.
        set_back: (N,) mm.
        polygons: I.
        tolerance: mm, by which the result may be simplified.
    """
    valleys = valley_lines(lines, depth, set_back)
    before, after = _signed_area(lines.points, lines.start), _signed_area(valleys, lines.start)
    outer = before > 0
    # A line that turned inside out has no inside left; a hole that did is gone the other way and stays a hole.
    usable = np.where(outer, after > 0, np.abs(after) > 0)
    inside = np.full(polygons, shapely.Polygon(), dtype=object)
    shells = np.flatnonzero(outer & usable)
    if len(shells) == 0:
        return inside
    rings = _rings(valleys, lines.start, tolerance)
    inside[lines.polygon[shells]] = rings[shells]
    holes = np.flatnonzero(~outer & usable)
    parts, hole = shapely.get_parts(rings[holes], return_index=True)
    of_part = lines.polygon[holes][hole]
    order = np.argsort(of_part, kind="stable")
    pierced, group = np.unique(of_part[order], return_inverse=True)
    if len(pierced):
        gathered = shapely.buffer(shapely.multipolygons(parts[order], indices=group), 0)
        inside[pierced] = shapely.difference(inside[pierced], gathered)
    return inside


def _rings(points: FloatArray, start: IntArray, tolerance: float) -> NDArray[np.object_]:
    """(M,) simplified regions that loops bound, holes as well.

    Where a loop folds over itself, the folds go, which run backwards around nothing: simplifying mends what it returns.
    """
    loops = np.arange(len(start))
    rings = ring_polygons(points, start, loops[:-1], loops)
    return in_chunks(lambda some: (shapely.simplify(some, tolerance, preserve_topology=False),), rings)[0]


def _signed_area(points: FloatArray, start: IntArray) -> FloatArray:
    x, y = points.T
    return sums(x * ahead(y, start) - y * ahead(x, start), start) / 2
