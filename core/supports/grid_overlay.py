"""Overlays of areas on a common grid, so that edges that coincide from layer to layer stay the same edges."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import shapely

from ..fill.offsets import polygonal
from ..model import FloatArray, IntArray, Shapes
from ..parallel import geos_in_threads
from ..ragged import ranges

GRID_MM = 0.01
"""Vertices of supports lie on this grid: overlays on it are exact, whatever the shapes have in common."""
SIMPLIFY_MM = 0.04
"""Areas of support may be off by this much, so that they do not gather vertices from layer to layer."""
_PAIRS_AT_ONCE = 1 << 20  # whose boxes are held in memory


def difference(shapes: Shapes, others: Shapes | shapely.Geometry) -> Shapes:
    """(N,) areas of the first shapes outside the second."""
    return areas(shapely.difference(shapes, others, grid_size=GRID_MM))


def intersection(shapes: Shapes, others: Shapes | shapely.Geometry) -> Shapes:
    """(N,) areas in both."""
    return areas(shapely.intersection(shapes, others, grid_size=GRID_MM))


def areas(shapes: Shapes | shapely.Geometry) -> Shapes:
    """(N,) shapes without the lines and points where shapes only touch."""
    return polygonal(np.atleast_1d(np.asarray(shapes, dtype=object)))


def nothing(count: int) -> Shapes:
    """(N,) empty shapes."""
    return np.full(count, shapely.MultiPolygon(), dtype=object)


def thickness(shapes: Shapes) -> FloatArray:
    """(N,) mm, four times the area over the perimeter: the diameter of a disc, twice the width of a strip."""
    return np.asarray(4 * shapely.area(shapes) / shapely.length(shapes))


def once(function: Callable[[Shapes], tuple[Shapes]], shapes: Shapes) -> Shapes:
    """(N,) a function of each shape, computed once for shapes that are the same object, in threads."""
    _, first, same = _alike(shapes)
    (made,) = geos_in_threads(function, shapes[first])
    return np.asarray(made[same])


def distinct(shapes: Shapes) -> Shapes:
    """(D,) the shapes, each once."""
    return np.asarray(shapes[_alike(shapes)[1]])


def overlapping(parts: Shapes, layer: IntArray, others: Shapes, other_layer: IntArray) -> tuple[IntArray, IntArray]:
    """(other, part) of all that overlap on the same layer, by `layer` (P,), which does not decrease, and another."""
    first = np.searchsorted(layer, other_layer, side="left")
    count = np.searchsorted(layer, other_layer, side="right") - first
    cuts = np.searchsorted(np.cumsum(count), np.arange(_PAIRS_AT_ONCE, count.sum(), _PAIRS_AT_ONCE))
    some = [
        _that_overlap(parts, others, np.repeat(rows, count[rows]), ranges(first[rows], count[rows]))
        for rows in np.split(np.arange(len(others)), cuts)
    ]
    other, part = (np.concatenate(column) for column in zip(*some, strict=True))
    return other, part


def _that_overlap(parts: Shapes, others: Shapes, other: IntArray, part: IntArray) -> tuple[IntArray, IntArray]:
    """Those of the pairs (other, part) that overlap."""
    one, two = shapely.bounds(others)[other], shapely.bounds(parts)[part]
    near = ((one[:, :2] <= two[:, 2:]) & (two[:, :2] <= one[:, 2:])).all(axis=1)
    other, part, same = other[near], part[near], (one[near] == two[near]).all(axis=1)
    # What joins all sides of a box crosses whatever else does.
    met = same.copy()
    met[~same] = shapely.intersects(others[other[~same]], parts[part[~same]])
    return other[met], part[met]


def _alike(shapes: Shapes) -> tuple[Any, Any, Any]:
    """As `numpy.unique`: distinct shapes, where each occurs first, and (N,) which one each shape is."""
    return np.unique(np.asarray(shapely.to_wkb(shapes), dtype=object), return_index=True, return_inverse=True)
