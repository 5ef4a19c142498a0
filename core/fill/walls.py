"""The straight walls behind the waved outline, and the region that they leave to be filled."""

from __future__ import annotations

import numpy as np
import shapely

from ..model import FloatArray, IntArray, Shapes
from ..paths import Feature, Paths
from ..ragged import starts
from ..settings import PrintSettings
from .mitres import MITRE_LIMIT, Moved, moved

_SIMPLIFY_MM = 0.04  # a tenth of a line, and less than what fill overlaps walls by
_NARROWEST = 0.7  # line widths between the lines on both sides of a neck
_TIP = 0.2  # line widths, squared: sharp corners are no necks
_APART_MM = 1e-3  # overlays of edges that lie on one another take several times as long and leave slivers


def simplified(shapes: Shapes, tolerance_mm: float) -> Shapes:
    """Polygons with fewer vertices, valid ones whatever came in.

    Args:
        shapes: (N,) Polygon or MultiPolygon, None, empty or not quite valid.
        tolerance_mm: the boundary moves by no more than this.

    Returns:
        (N,) valid Polygon or MultiPolygon, maybe empty.
    """
    shapes = np.where(shapely.is_missing(shapes), shapely.Polygon(), shapes)
    result: Shapes = np.asarray(shapely.simplify(shapes, tolerance_mm, preserve_topology=False), dtype=object)
    # It mends what it returns, but may have cut a neck then and lost what hangs on it; the area betrays it.
    lost = np.abs(shapely.area(result) - shapely.area(shapes)) > tolerance_mm * shapely.length(shapes)
    if lost.any():
        sound = shapely.buffer(shapely.make_valid(shapes[lost]), 0.0)
        result[lost] = shapely.simplify(sound, tolerance_mm, preserve_topology=True)
    return result


def offset(shapes: Shapes, distance_mm: float | FloatArray) -> Shapes:
    """Polygons grown (or, below 0, shrunk) by a distance or (N,) distances, with corners kept sharp; (N,) to (N,)."""
    grown: Shapes = shapely.buffer(shapes, distance_mm, join_style="mitre", mitre_limit=MITRE_LIMIT)
    return grown


def offset_outlines(shapes: Shapes, distance_mm: FloatArray) -> Shapes:
    """As `offset`, in half the time for many valid polygons of many corners of which few split or meet."""
    return _completed(moved(shapes, distance_mm), shapes, distance_mm)


def _completed(found: Moved, shapes: Shapes, distance_mm: FloatArray) -> Shapes:
    """(N,) moved outlines, those that are not right by GEOS."""
    grown, rest = found.shapes.copy(), np.flatnonzero(~found.sound)
    grown[rest] = offset(shapes[rest], distance_mm[rest])
    return grown


def walls_and_fill(
    islands: Shapes, width_mm: FloatArray, settings: PrintSettings
) -> tuple[list[Shapes], Shapes, list[Moved]]:
    """Offset every island inwards, wall by wall.

    Args:
        islands: (I,) valid regions whose boundary is the center line of the outermost wall's inside.
        width_mm: (I,) of the lines.
        settings: `perimeters` and `infill_overlap` are read.

    Returns:
        The islands, and then for each straight wall, from the outside in, (I,) regions bounded by its center line;
        (I,) regions to fill: what is inside the last wall's inner edge, grown by the overlap; and how each wall came
        from the one before.
    """
    into_fill = (settings.infill_overlap / 100.0 - 0.5) * width_mm
    walls, steps = [islands], []
    for _ in range(settings.perimeters):
        steps.append(moved(walls[-1], -width_mm))
        walls.append(_completed(steps[-1], walls[-1], -width_mm))
    inside = simplified(walls[-1], _SIMPLIFY_MM)
    filled = moved(inside, into_fill)
    fill = _completed(filled, inside, into_fill)
    for number, onwards in enumerate([*steps[1:], filled][: len(steps)], start=1):
        # Where edges have met on the way further in, or nothing was left to go on with.
        rows = np.flatnonzero(~onwards.sound | (shapely.is_empty(onwards.shapes) & ~shapely.is_empty(walls[number])))
        least = _NARROWEST / 2 * width_mm[rows]
        if onwards is filled and np.allclose(into_fill[rows], -least):
            cores, least = fill[rows], least + _SIMPLIFY_MM
        else:
            cores = offset(walls[number][rows], -least)
        opened = _open_necks(walls[number], rows, offset(cores, least + _APART_MM), width_mm[rows])
        steps[number - 1].sound[opened] = False
    return walls, fill, steps


def _open_necks(walls: Shapes, rows: IntArray, wide: Shapes, width_mm: FloatArray) -> IntArray:
    """Cut the rows (R,) of walls (I,), in place, back to where they are `wide` (R,), but not at sharp corners.

    Where both sides of a wall would be printed nearly on each other there is none: one line along the gap is as wide.
    """
    whole = walls[rows]
    opened = polygonal(shapely.intersection(whole, wide))
    lost_mm2, shorter_mm = shapely.area(whole) - shapely.area(opened), shapely.length(whole) - shapely.length(opened)
    necks = (lost_mm2 > _TIP * width_mm**2) | (shorter_mm > 2.0 * width_mm)
    necks |= shapely.get_num_geometries(opened) > shapely.get_num_geometries(whole)
    changed: IntArray = rows[necks]
    walls[changed] = opened[necks]
    return changed


def polygonal(shapes: Shapes) -> Shapes:
    """(N,) shapes, in place, without the lines and points where others only touch."""
    mixed = shapely.get_type_id(shapes) == shapely.GeometryType.GEOMETRYCOLLECTION
    mixed |= shapely.get_dimensions(shapes) < 2
    shapes[mixed] = shapely.buffer(shapes[mixed], 0.0)
    return shapes


def wall_paths(walls: list[Shapes], island_layer: IntArray, width_mm: FloatArray) -> Paths:
    """The boundaries of the walls' regions as closed paths.

    Args:
        walls: for each wall, (I,) regions bounded by its center line.
        island_layer: (I,) layer of each island.
        width_mm: (I,) of the lines.

    Returns:
        INNER_WALL loops, outer ones counter-clockwise and holes clockwise, without those too short to be printed.
    """
    if not walls:
        return Paths.empty()
    island = np.tile(np.arange(len(island_layer)), len(walls))
    return boundary_paths(np.concatenate(walls), island, island_layer, width_mm, Feature.INNER_WALL)


def boundary_paths(
    regions: Shapes, island: IntArray, island_layer: IntArray, width_mm: FloatArray, feature: Feature
) -> Paths:
    """The boundaries of regions as closed paths.

    Args:
        regions: (R,) Polygon or MultiPolygon, maybe empty.
        island: (R,) int64.
        island_layer: (I,) layer of each island.
        width_mm: (I,) of each island's lines.
        feature: of all of them.

    Returns:
        Outer loops counter-clockwise and holes clockwise, without those too short to be printed.
    """
    parts, owner = shapely.get_parts(regions, return_index=True)
    rings, part = shapely.get_rings(parts, return_index=True)
    turned = shapely.is_ccw(rings) == np.append(False, part[1:] == part[:-1])[: len(part)]
    rings[turned] = shapely.reverse(rings[turned])
    island = island[owner][part]
    printable = shapely.length(rings) >= 2.0 * width_mm[island]
    rings, island = rings[printable], island[printable]
    points, ring = shapely.get_coordinates(rings, return_index=True)
    closing = np.append(ring[1:] != ring[:-1], True)[: len(ring)]
    points, ring = points.compress(~closing, axis=0), ring[~closing]
    counts = np.bincount(ring, minlength=len(rings))
    return Paths(
        points=points,
        start=starts(counts),
        layer=island_layer[island].astype(np.int64),
        feature=np.full(len(rings), int(feature), dtype=np.int64),
        island=island.astype(np.int64),
        closed=np.ones(len(rings), dtype=bool),
        width=np.repeat(width_mm[island], counts),
    )
