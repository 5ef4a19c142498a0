"""The skirt around everything on the first layer; it primes the first nozzle and shows whether the bed is level."""

from __future__ import annotations

import numpy as np
import shapely

from ..settings import PrintSettings
from .loops import Turn, exterior_rings, first_layer_loops, loop_points
from .moves import Feature, Paths

CORNER_TOLERANCE_MM = 0.05


def skirt_paths(footprint: shapely.Geometry, settings: PrintSettings) -> Paths:
    """Loops around the first layer, the outermost first; those that leave the printer's reach are left out.

    Args:
        footprint: all that is printed on the first layer, tower included, in mm.
        settings: of the print.

    Returns:
        Closed counter-clockwise paths on layer 0 of feature `SKIRT`.
    """
    if footprint.is_empty or settings.skirts == 0:
        return Paths.empty()
    width = settings.first_layer_extrusion_width
    distances = settings.skirt_distance + width * (np.arange(settings.skirts)[::-1] + 0.5)
    filled = shapely.convex_hull(shapely.get_parts(footprint))  # also keeps the skirt out of bays
    grown = shapely.buffer(shapely.union_all(filled), distances, quad_segs=8)
    rings = shapely.simplify(exterior_rings(np.asarray(grown)), CORNER_TOLERANCE_MM)
    printer = settings.printer_profile
    (left, front), (right, back) = printer.reach_min[:2], printer.reach_max[:2]
    half = width / 2
    reach = shapely.box(left + half, front + half, right - half, back - half)
    loops = [loop_points(ring) for ring in rings[shapely.covers(reach, rings)]]
    return first_layer_loops(loops, Feature.SKIRT, Turn.SKIRT, width)
