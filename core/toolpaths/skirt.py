"""The skirt around everything on the first layer; it primes the first nozzle and shows whether the bed is level."""

from __future__ import annotations

import numpy as np
import shapely

from ..printer import REPLICATOR_2X
from ..settings import PrintSettings
from .moves import Feature, Paths

SKIRT_ISLAND = -2
CORNER_TOLERANCE_MM = 0.05


def skirt_paths(footprint: shapely.Geometry, settings: PrintSettings) -> Paths:
    """Loops around the first layer, the outermost first; those that leave the printer's reach are left out.

    Args:
        footprint: all that is printed on the first layer, tower included, in mm.
        settings: of the print.

    Returns:
        Closed counter-clockwise paths on layer 0 of feature `SKIRT`, island `SKIRT_ISLAND`.
    """
    if footprint.is_empty or settings.skirts == 0:
        return Paths.empty()
    width = settings.extrusion_width
    distances = settings.skirt_distance + width * (np.arange(settings.skirts)[::-1] + 0.5)
    filled = shapely.convex_hull(shapely.get_parts(footprint))  # also keeps the skirt out of bays
    grown = shapely.buffer(shapely.union_all(filled), distances, quad_segs=8)
    rings = shapely.get_exterior_ring(shapely.get_parts(grown))
    rings = shapely.simplify(rings, CORNER_TOLERANCE_MM)
    (left, front), (right, back) = REPLICATOR_2X.reach_min[:2], REPLICATOR_2X.reach_max[:2]
    half = width / 2
    reach = shapely.box(left + half, front + half, right - half, back - half)
    return _as_paths(rings[shapely.covers(reach, rings)], width)


def _as_paths(rings: np.ndarray[tuple[int], np.dtype[np.object_]], width: float) -> Paths:
    loops = [shapely.get_coordinates(ring)[:-1] for ring in rings]
    loops = [loop if shapely.is_ccw(ring) else loop[::-1] for loop, ring in zip(loops, rings, strict=True)]
    if not loops:
        return Paths.empty()
    count = len(loops)
    points = np.concatenate(loops)
    return Paths(
        points=points,
        start=np.concatenate([[0], np.cumsum([len(loop) for loop in loops])]).astype(np.int64),
        layer=np.zeros(count, dtype=np.int64),
        feature=np.full(count, Feature.SKIRT, dtype=np.int64),
        island=np.full(count, SKIRT_ISLAND, dtype=np.int64),
        closed=np.ones(count, dtype=bool),
        width=np.full(len(points), width),
    )
