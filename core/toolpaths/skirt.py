"""The skirt around everything on the first layer; it primes the first nozzle and shows whether the bed is level."""

from __future__ import annotations

import numpy as np
import shapely

from ..paths import Feature, Paths
from ..settings import PrintSettings
from .loops import FirstIsland, exterior_rings, first_layer_loops, loop_points

CORNER_TOLERANCE_MM = 0.05
LEAST_DISTANCE_MM = 1.0


def skirt_paths(footprint: shapely.Geometry, settings: PrintSettings) -> Paths:
    """Loops around the first layer, the outermost first; nearer than asked, then fewer, where the bed is too small.

    Args:
        footprint: all that is printed on the first layer, tower included, in mm.
        settings: of the print.

    Returns:
        Closed counter-clockwise paths on layer 0 of feature `SKIRT`.
    """
    if footprint.is_empty or settings.skirts == 0:
        return Paths.empty()
    width = settings.first_layer_extrusion_width
    printer = settings.printer_profile
    low, high = np.reshape(shapely.bounds(footprint), (2, 2))
    # What lies between the footprint and the reach on the narrowest side holds the loops and a gap.
    room = float(min((low - printer.reach_min[:2]).min(), (printer.reach_max[:2] - high).min()))
    count = min(settings.skirts, int(np.floor((room - LEAST_DISTANCE_MM) / width + 1e-9)))
    if count <= 0:
        return Paths.empty()
    distance = min(settings.skirt_distance, room - count * width)
    distances = distance + width * (np.arange(count)[::-1] + 0.5)
    filled = shapely.convex_hull(shapely.get_parts(footprint))  # also keeps the skirt out of bays
    grown = shapely.buffer(shapely.union_all(filled), distances, quad_segs=8)
    rings = shapely.simplify(exterior_rings(np.asarray(grown)), CORNER_TOLERANCE_MM)
    return first_layer_loops([loop_points(ring) for ring in rings], Feature.SKIRT, FirstIsland.SKIRT, width)


def skirt_warnings(around: Paths, settings: PrintSettings) -> list[str]:
    """Says that the skirt has fewer loops than asked for.

    Args:
        around: what stands around the object; the loops of its skirt lie one within another, around each part.
        settings: skirts is used.
    """
    rings = [
        shapely.polygons(around.points[around.start[path] : around.start[path + 1]])
        for path in np.flatnonzero(around.feature == Feature.SKIRT)
    ]
    inside = shapely.contains_properly(np.array(rings)[:, None], rings) if rings else np.zeros((1, 0), dtype=bool)
    loops = int(inside.sum(axis=0).max(initial=-1)) + 1
    if loops >= settings.skirts:
        return []
    kept = f"{loops} of {settings.skirts} loops of the skirt" if loops else "no skirt"
    return [f"the bed has room for {kept}; set skirts lower, or scale the object down"]
