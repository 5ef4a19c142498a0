"""Polygons simplified, grown and shrunk, as walls, fill and supports need them."""

from __future__ import annotations

import numpy as np
import shapely

from ..model import FloatArray, Shapes
from .mitres import MITRE_LIMIT, Moved, moved


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
    return completed(moved(shapes, distance_mm), shapes, distance_mm)


def completed(found: Moved, shapes: Shapes, distance_mm: FloatArray) -> Shapes:
    """(N,) moved outlines, where these are not right those of GEOS; arguments as of `mitres.moved`, and its result."""
    grown, rest = found.shapes.copy(), np.flatnonzero(~found.sound)
    grown[rest] = offset(shapes[rest], distance_mm[rest])
    return grown


def polygonal(shapes: Shapes) -> Shapes:
    """(N,) shapes, in place, without the lines and points where others only touch."""
    mixed = shapely.get_type_id(shapes) == shapely.GeometryType.GEOMETRYCOLLECTION
    mixed |= shapely.get_dimensions(shapes) < 2
    shapes[mixed] = shapely.buffer(shapes[mixed], 0.0)
    return shapes
