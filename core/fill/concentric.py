"""Sparse fill by lines that follow the boundary."""

from __future__ import annotations

import numpy as np
import shapely

from ..model import IntArray, Shapes
from ..parallel import geos_in_threads
from .offsets import offset, simplified

_SIMPLIFY_MM = 0.05
_RADIUS_TOLERANCE = 0.02  # of the greatest circle in a part, in spacings


def nested(regions: Shapes, spacing_mm: float) -> tuple[Shapes, IntArray]:
    """Shrink every part of regions again and again, evenly down to its middle.

    The spacing is fitted to the largest circle inside the part, so that a whole number of loops covers the part: each
    loop covers a stripe as wide as the spacing, along whose middle it runs.

    Args:
        regions: (I,) Polygon or MultiPolygon, maybe empty.
        spacing_mm: distance of neighboring loops, about.

    Returns:
        (R,) Polygon or MultiPolygon whose boundaries are the lines; (R,) the region of each.
    """
    parts, owner = shapely.get_parts(regions, return_index=True)
    if not len(parts):
        return parts, owner.astype(np.int64)

    def chunk(shapes: Shapes) -> tuple[Shapes]:
        shapes = simplified(shapes, _SIMPLIFY_MM)
        radius = np.zeros(len(shapes))
        some = ~shapely.is_empty(shapes)
        circle = shapely.maximum_inscribed_circle(shapes[some], _RADIUS_TOLERANCE * spacing_mm)
        radius[some] = shapely.length(circle)
        step = radius / np.maximum(np.round(radius / spacing_mm), 1)
        loops = []
        inner = offset(shapes, -0.5 * step)
        while not shapely.is_empty(inner).all():
            loops.append(inner)
            inner = offset(inner, -step)
        return (shapely.geometrycollections(np.stack(loops, axis=1)) if loops else shapes,)

    (gathered,) = geos_in_threads(chunk, parts)
    levels, part = shapely.get_parts(gathered, return_index=True)
    some = ~shapely.is_empty(levels)
    return levels[some], owner[part[some]].astype(np.int64)
