"""The brim: loops on the bed around the first layer that keep its edge from lifting."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import shapely

from ..model import Shapes
from ..paths import Feature, Paths
from ..settings import PrintSettings
from .loops import FirstIsland, exterior_rings, first_layer_loops, loop_points

_CORNER_TOLERANCE_MM = 0.02


def brim_area(first_layer: shapely.Geometry, settings: PrintSettings) -> shapely.Geometry:
    """The first layer together with its brim; closed holes get no brim inside."""
    loops = _loops(settings)
    if not loops or first_layer.is_empty:
        return first_layer
    width = loops * settings.first_layer_extrusion_width
    grown = shapely.buffer(first_layer, width + settings.brim_separation, quad_segs=16)
    return shapely.union_all(shapely.polygons(exterior_rings(np.array([grown]))))


def brim_paths(first_layer: shapely.Geometry, settings: PrintSettings) -> Paths:
    """Loops around the first layer: around each part the outermost first, the last one beside the object's line.

    Args:
        first_layer: all that is printed there, as wide as its lines; mm.
        settings: brim_width, brim_separation and first_layer_extrusion_width are used.

    Returns:
        Counter-clockwise paths on layer 0 of feature `BRIM`.
    """
    loops = _loops(settings)
    if not loops or first_layer.is_empty:
        return Paths.empty()
    width = settings.first_layer_extrusion_width
    away = width * (np.arange(loops)[::-1] + 0.5) + settings.brim_separation
    grown = np.asarray(shapely.buffer(first_layer, away, quad_segs=16))
    levels = [shapely.simplify(exterior_rings(grown[k : k + 1]), _CORNER_TOLERANCE_MM) for k in range(loops)]
    return first_layer_loops([loop_points(ring) for ring in _nested(levels)], Feature.BRIM, FirstIsland.BRIM, width)


def _nested(levels: list[Shapes]) -> list[shapely.Geometry]:
    """Order rings so that each follows the ring around it, and all rings inside one come before its neighbor.

    Args:
        levels: rings from the outermost level in; each lies within one of the level before.
    """
    order: list[tuple[int, ...]] = [(k,) for k in range(len(levels[0]))]
    rings, keys = list(levels[0]), list(order)
    for outer, inner in pairwise(levels):
        around = shapely.polygons(outer)
        inside = shapely.contains(around[:, None], shapely.get_point(inner, 0))
        # Rings of one level may lie within each other, as an object within its ooze shield: the smallest counts.
        parent = np.argmin(np.where(inside, shapely.area(around)[:, None], np.inf), axis=0)
        order = [(*order[p], k) for k, p in enumerate(parent.tolist())]
        keys += order
        rings += list(inner)
    return [rings[k] for k in sorted(range(len(keys)), key=keys.__getitem__)]


def _loops(settings: PrintSettings) -> int:
    return int(np.ceil(settings.brim_width / settings.first_layer_extrusion_width - 1e-9))
