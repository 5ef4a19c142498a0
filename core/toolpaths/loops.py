"""Boundary rings of polygons as closed paths: brim, skirt, shield and tower are made of them."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
import shapely

from ..model import FloatArray, Shapes
from ..paths import Feature, Paths
from ..ragged import starts


class FirstIsland(IntEnum):
    """Island numbers of all that is not the object, in printing order; of each kind the first one.

    So a nozzle draws the skirt or primes on the tower before it prints anything that matters. All are negative, unlike
    the islands of the object. Each loop around it has an island of its own, with room for 10,000 of a kind; the raft
    and the supports are one island each.
    """

    SKIRT = -60_000
    TOWER_BRIM = -50_000
    TOWER = -40_000
    BRIM = -30_000
    OOZE_SHIELD = -20_000
    RAFT = -10_000
    SUPPORT = -1


def exterior_rings(shapes: Shapes) -> Shapes:
    """The outer boundaries of (N,) Polygons or MultiPolygons, in their order, without the empty ones."""
    parts = shapely.get_parts(shapes)
    rings: Shapes = shapely.get_exterior_ring(parts[~shapely.is_empty(parts)])
    return rings


def loop_points(ring: shapely.Geometry) -> FloatArray:
    """(N, 2) mm, counter-clockwise, the first point not repeated."""
    points: FloatArray = shapely.get_coordinates(ring)[:-1]
    return points if shapely.is_ccw(ring) else points[::-1]


def first_layer_loops(loops: list[FloatArray], feature: Feature, first: FirstIsland, width: float) -> Paths:
    """Closed paths on layer 0 that are printed in the order given.

    Args:
        loops: (N, 2) mm each.
        feature: of all of them.
        first: island of the first one; each that follows has the next greater number, as islands keep their order.
        width: mm, of the lines.
    """
    if not loops:
        return Paths.empty()
    return Paths.alike(
        np.concatenate(loops),
        starts(np.array([len(loop) for loop in loops])),
        np.zeros(len(loops), dtype=np.int64),
        feature=feature,
        island=first + np.arange(len(loops)),
        closed=True,
        width=width,
    )


def on_layers(paths: Paths, layers: int, width: float) -> Paths:
    """The paths of layer 0 repeated on the first layers.

    Args:
        paths: as they are on layer 0.
        layers: how many.
        width: mm, of the lines on the others.
    """
    lines, points = len(paths.layer), len(paths.points)
    if not lines or layers <= 0:
        return Paths.empty()
    begin = (np.arange(layers, dtype=np.int64) * points)[:, None] + paths.start[:-1]
    return Paths(
        points=np.tile(paths.points, (layers, 1)),
        start=np.append(begin.ravel(), layers * points).astype(np.int64),
        layer=np.repeat(np.arange(layers, dtype=np.int64), lines),
        feature=np.tile(paths.feature, layers),
        island=np.tile(paths.island, layers),
        closed=np.tile(paths.closed, layers),
        width=np.concatenate([paths.width, np.full((layers - 1) * points, width)]),
    )
