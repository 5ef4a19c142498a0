"""The waved outlines as paths, and the area that they leave for inner walls and fill."""

from __future__ import annotations

import numpy as np
import shapely

from ..contours.contours import Contours
from ..model import BoolArray, FloatArray, IntArray, Shapes
from ..parallel import geos_in_threads
from ..paths import Feature, Paths
from ..pattern.wave import WavedOutlines, valley_lines
from ..ragged import ahead, following, preceding, ranges, starts, sums
from ..settings import PrintSettings
from ..slicing.regions import gathered, ring_polygons

_TOLERANCE_MM = 0.03  # by which what lies inside the wall may differ from the true area
_HARDLY_A_WAVE = 1.0  # line widths deep: the strand covers what a straight one would


def outer_wall_paths(waved: WavedOutlines) -> Paths:
    """One closed path per outline, or several open ones if two tools share it; its island is the region it bounds."""
    if waved.swapped is not None:
        return _shared(waved, waved.swapped)
    return Paths.alike(
        waved.points,
        waved.start,
        waved.layer,
        feature=Feature.OUTER_WALL,
        island=waved.polygon,
        closed=True,
        width=waved.width,
    )


def _shared(waved: WavedOutlines, swapped: BoolArray) -> Paths:
    """The outlines cut where the tool changes; each piece ends where the next one begins.

    Args:
        waved: the outlines, N points.
        swapped: (N,) bool, points whose line the other tool prints.
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
    waved: WavedOutlines,
    lines: Contours,
    depth: FloatArray,
    set_back: FloatArray,
    polygons: int,
    settings: PrintSettings,
) -> Shapes:
    """(I,) what lies inside the innermost line of the outer wall of each sliced region; empty where nothing does.

    Args:
        waved: the outlines.
        lines: contours that they swing about.
        depth: (N,) mm, of the wave at each contour point.
        set_back: (N,) mm.
        polygons: number of sliced regions, I.
        settings: tell whether there are waves.
    """
    if settings.wave_crest:
        return inside_of_lines(lines, valley_lines(lines, depth, set_back), polygons, _TOLERANCE_MM)
    return _inside(waved.base, waved.points, waved.start, waved.polygon, polygons, _TOLERANCE_MM)


def inside_of_lines(lines: Contours, moved: FloatArray, polygons: int, tolerance: float) -> Shapes:
    """(I,) what lies inside contours whose points were moved, empty where nothing does.

    Args:
        lines: N contour points.
        moved: (N, 2) mm, where they are now.
        polygons: number of sliced regions, I.
        tolerance: mm, by which the result may be simplified.
    """
    return _inside(lines.points, moved, lines.start, lines.polygon, polygons, tolerance)


def straight_parts(
    lines: Contours, depth: FloatArray, set_back: FloatArray, polygons: int, settings: PrintSettings
) -> Shapes:
    """(I,) MultiLineStrings: parts with hardly any wave of outer walls that have waves elsewhere.

    Args:
        lines: contours that the outlines swing about.
        depth: (N,) mm, of the wave at each contour point.
        set_back: (N,) mm.
        polygons: number of sliced regions, I.
        settings: tell whether there are waves at all, without which no part is found.
    """
    found = np.full(polygons, shapely.MultiLineString(), dtype=object)
    if not settings.wave_crest:
        return found
    flat = depth < _HARDLY_A_WAVE * lines.width
    going_on = flat & flat[following(lines.start)]
    points = lines.points - set_back[:, None] * lines.normal
    # A piece for each line of a contour: buffers unite them.
    near, far = points[going_on], ahead(points, lines.start)[going_on]
    pieces = shapely.linestrings(np.stack([near, far], axis=1))
    owner = lines.polygon[lines.loop[going_on]]
    order = np.argsort(owner, kind="stable")
    rows, row = np.unique(owner[order], return_inverse=True)
    if len(rows):
        found[rows] = shapely.multilinestrings(pieces[order], indices=row)
    return found


def _inside(
    before: FloatArray, after: FloatArray, start: IntArray, polygon: IntArray, polygons: int, tolerance: float
) -> Shapes:
    """(polygons,) what the loops of each region bound after their points have moved; `polygon` (M,) is that region."""
    area, area_after = _signed_area(before, start), _signed_area(after, start)
    # A line that turned inside out has no inside left; a hole that did is gone the other way and stays a hole.
    shells, holes = np.flatnonzero((area > 0) & (area_after > 0)), np.flatnonzero((area <= 0) & (area_after != 0))
    inside = np.full(polygons, shapely.Polygon(), dtype=object)
    if len(shells) == 0:
        return inside
    inside[polygon[shells]] = _rings(after, start, shells, tolerance)
    parts, hole = shapely.get_parts(_rings(after, start, holes, tolerance), return_index=True)
    return _pierced(inside, parts, polygon[holes][hole])


def _pierced(regions: Shapes, holes: Shapes, owner: IntArray) -> Shapes:
    """(I,) Polygons or MultiPolygons without the holes (H,) of their owners (H,)."""
    single = (shapely.get_type_id(regions) == shapely.GeometryType.POLYGON) & ~shapely.is_empty(regions)
    pierced = np.unique(owner)
    # Most holes lie clear of all else, and are rings of their region: testing that is faster than cutting them out.
    shells, clear = pierced[single[pierced]], np.flatnonzero(single[owner])
    rings = shapely.get_exterior_ring(np.concatenate([regions[shells], holes[clear]]))
    of_ring = np.concatenate([shells, owner[clear]])
    order = np.argsort(of_ring, kind="stable")
    found = regions.copy()
    found[shells] = shapely.polygons(rings[order], indices=np.searchsorted(shells, of_ring[order]))
    rest = pierced[~(single[pierced] & shapely.is_valid(found[pierced]))]
    if len(rest):
        cut_out = shapely.buffer(gathered(holes, owner, len(regions))[rest], 0)
        found[rest] = shapely.difference(regions[rest], cut_out)
    return found


def _rings(points: FloatArray, start: IntArray, loops: IntArray, tolerance: float) -> Shapes:
    """(K,) simplified regions that K of the loops bound, holes as well.

    Folds of loops that cross themselves run backwards around nothing; simplifying leaves them out.
    """
    rings = ring_polygons(points, start, loops, np.arange(len(loops) + 1))
    return geos_in_threads(lambda some: (shapely.simplify(some, tolerance, preserve_topology=False),), rings)[0]


def _signed_area(points: FloatArray, start: IntArray) -> FloatArray:
    """(M,) mm², of closed loops; below 0 where they run clockwise."""
    x, y = points.T
    return sums(x * ahead(y, start) - y * ahead(x, start), start) / 2
