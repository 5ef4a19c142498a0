"""The ooze shield: a thin wall around the object that catches what drips from the idle nozzle."""

from __future__ import annotations

import numpy as np
import shapely

from ..paths import Feature, Paths
from ..settings import PrintSettings
from .loops import FirstIsland, exterior_rings, first_layer_loops, loop_points, on_layers

_CORNER_TOLERANCE_MM = 0.05
_SMOOTH_MM = 4.0


def shield_area(shadow: shapely.Geometry, width: float, settings: PrintSettings) -> shapely.Geometry:
    """The area that a shield of lines `width` mm wide encloses, itself included; the shadow alone without a shield."""
    if not settings.ooze_shield or shadow.is_empty:
        return shadow
    return shapely.buffer(_walls(shadow, settings), width / 2)


def shield_paths(shadow: shapely.Geometry, layers: int, settings: PrintSettings) -> Paths:
    """One line a layer around everything that the object covers seen from above.

    The same on all layers, so that it stands upright and needs no support whatever the object's shape.

    Args:
        shadow: of the object and its supports on the bed, in mm.
        layers: how many layers the print has.
        settings: ooze_shield, ooze_shield_distance and the widths are used.

    Returns:
        Closed paths of feature `OOZE_SHIELD`.
    """
    if not settings.ooze_shield or shadow.is_empty:
        return Paths.empty()
    rings = shapely.simplify(exterior_rings(np.array([_walls(shadow, settings)])), _CORNER_TOLERANCE_MM)
    loops = [loop_points(ring) for ring in rings]
    width = settings.first_layer_extrusion_width
    wall = first_layer_loops(loops, Feature.OOZE_SHIELD, FirstIsland.OOZE_SHIELD, width)
    return on_layers(wall, layers, settings.extrusion_width)


def _walls(shadow: shapely.Geometry, settings: PrintSettings) -> shapely.Geometry:
    """What the center lines of the shield enclose."""
    distance = settings.ooze_shield_distance + settings.extrusion_width / 2
    # Narrow bays are left out: a plain wall prints faster, and nothing in them could drip beyond it.
    grown = shapely.buffer(shapely.buffer(shadow, distance + _SMOOTH_MM, quad_segs=6), -_SMOOTH_MM, quad_segs=6)
    return shapely.union_all(shapely.polygons(exterior_rings(np.array([grown]))))
