"""The cleaning tower that primes a nozzle after each tool change (paper, section 4.2)."""

from __future__ import annotations

import numpy as np

from ..errors import MeshError
from ..model import FloatArray
from ..printer import REPLICATOR_2X
from ..settings import PrintSettings
from .moves import Feature, Paths

TOWER_ISLAND = -1
STROKE_HEIGHT = 0.3  # of the W's arms, as a share of its depth; at 16 × 8 mm two lines are 1.4 mm apart


def tower_paths(layers: int, occupied: FloatArray, settings: PrintSettings) -> Paths:
    """One closed W a layer, the same on all, beside the object where the bed has most room.

    The outline of the W's strokes is one loop of two lines side by side, so that it stands by itself, and every
    corner of it presses a straggling thread off the nozzle.

    Args:
        layers: how many layers the print has.
        occupied: (2, 2) mm, least and greatest XY that the object takes up, waves included.
        settings: of the print.

    Returns:
        `layers` paths of feature `TOWER` on island `TOWER_ISLAND`, or none with `tower_type` "none".

    Raises:
        MeshError: the bed has no room for the tower beside the object.
    """
    if settings.tower_type == "none" or layers == 0:
        return Paths.empty()
    outline = _placed(_w_outline(settings.tower_width, settings.tower_depth), occupied, settings)
    count = len(outline)
    return Paths(
        points=np.tile(outline, (layers, 1)),
        start=np.arange(layers + 1, dtype=np.int64) * count,
        layer=np.arange(layers, dtype=np.int64),
        feature=np.full(layers, Feature.TOWER, dtype=np.int64),
        island=np.full(layers, TOWER_ISLAND, dtype=np.int64),
        closed=np.ones(layers, dtype=bool),
        width=np.full(layers * count, settings.extrusion_width),
    )


def _w_outline(width: float, depth: float) -> FloatArray:
    """(10, 2) mm, counter-clockwise outline of a W within `width` × `depth`, its centre at the origin."""
    stroke = STROKE_HEIGHT * depth
    across = np.linspace(-width / 2, width / 2, 5)
    lower = np.array([depth - stroke, 0.0, depth - stroke, 0.0, depth - stroke]) - depth / 2
    below = np.column_stack([across, lower])
    above = np.column_stack([across, lower + stroke])[::-1]
    return np.concatenate([below, above])


def _placed(outline: FloatArray, occupied: FloatArray, settings: PrintSettings) -> FloatArray:
    """The outline moved to the side with most room; beside the object's left or right it stands upright.

    Raises:
        MeshError: it fits on no side.
    """
    reach = np.array([REPLICATOR_2X.reach_min[:2], REPLICATOR_2X.reach_max[:2]])
    half_line = settings.extrusion_width / 2
    best_room = 0.0
    best: FloatArray | None = None
    for axis, side in ((0, 1), (0, 0), (1, 1), (1, 0)):  # right, left, back, front
        turned = outline[:, ::-1] * (1.0, -1.0) if axis == 0 else outline
        half_size = np.abs(turned).max(axis=0) + half_line
        low, high = reach[0] + half_size, reach[1] - half_size
        outward = 1.0 if side else -1.0
        center = np.clip(occupied.mean(axis=0), low, high)
        center[axis] = occupied[side, axis] + outward * (settings.tower_distance + half_size[axis])
        room = outward * ((high if side else low)[axis] - center[axis])
        if room >= best_room and (low <= high).all() and (best is None or room > best_room):
            best_room, best = room, turned + center
    if best is None:
        raise MeshError(
            "the object leaves no room on the bed for the cleaning tower beside it",
            "make the object smaller, lower tower_distance, or set tower_type to none",
        )
    return best
