"""The ooze shield: a thin wall around the object that catches what drips from the idle nozzle."""

from __future__ import annotations

import numpy as np
import shapely

from ..paths import Feature, Paths
from ..settings import PrintSettings
from .loops import FirstIsland, exterior_rings, first_layer_loops, loop_points, on_layers

_CORNER_TOLERANCE_MM = 0.05
_SMOOTH_MM = 4.0


def shield_walls(shadow: shapely.Geometry, settings: PrintSettings) -> shapely.Geometry:
    """What the center lines of the shield enclose; nothing without a shield.

    Args:
        shadow: of the object and its supports on the bed, in mm.
        settings: ooze_shield, ooze_shield_distance and extrusion_width are used.
    """
    if not settings.ooze_shield or shadow.is_empty:
        return shapely.Polygon()
    distance = settings.ooze_shield_distance + settings.extrusion_width / 2
    # Narrow bays are left out: a plain wall prints faster, and nothing in them could drip beyond it.
    grown = shapely.buffer(shapely.buffer(shadow, distance + _SMOOTH_MM, quad_segs=6), -_SMOOTH_MM, quad_segs=6)
    return shapely.union_all(shapely.polygons(exterior_rings(np.array([grown]))))


def shield_paths(walls: shapely.Geometry, layers: int, settings: PrintSettings) -> Paths:
    """One line a layer around everything that the object covers seen from above.

    The same on all layers, so that it stands upright and needs no support whatever the object's shape.

    Args:
        walls: what its center lines enclose, mm; see `shield_walls`.
        layers: how many layers the print has.
        settings: the widths are used.

    Returns:
        Closed paths of feature `OOZE_SHIELD`.
    """
    rings = shapely.simplify(exterior_rings(np.array([walls])), _CORNER_TOLERANCE_MM)
    loops = [loop_points(ring) for ring in rings]
    width = settings.first_layer_extrusion_width
    first = first_layer_loops(loops, Feature.OOZE_SHIELD, FirstIsland.OOZE_SHIELD, width)
    return on_layers(first, layers, settings.extrusion_width)
