"""Thin columns of support: those not worth printing are dropped, the others made thick enough to stand."""

from __future__ import annotations

from functools import partial

import numpy as np
import shapely

from ..fill.walls import offset, simplified
from ..model import FloatArray, IntArray, Shapes
from ..parallel import geos_in_threads
from ..slicing.regions import gathered
from .grid_overlay import SIMPLIFY_MM, difference, once, thickness
from .overhangs import Contacts

# Columns that never get this large (mm²) carry bumps that hold without, unless something begins in the air there.
_WORTHWHILE_MM2 = 3.0
# Least thickness of a column, mm (the diameter of a round one), and the greatest ratio of height to thickness.
_STABLE_MM = 4.0
_SLENDERNESS = 12.0
_GROWTH_STEP_MM = 0.25  # so that columns of about one height grow alike
# Nothing narrower than twice this, mm, is printed.
_HALF_LEAST_WIDTH_MM = 0.3
_ARC_SEGMENTS = 4
_LAYER_SHIFT_MM = 1000.0  # more than the bed: sets the layers apart in the plane for a single search


def steady(found: Shapes, needed: Contacts, taken: Shapes, layer_height: float) -> Shapes:
    """(L,) columns that are worth printing and can stand.

    Args:
        found: (L,) areas of support.
        needed: what they carry.
        taken: (L,) where the object leaves no room.
        layer_height: mm.
    """
    parts, layer = shapely.get_parts(found, return_index=True)
    if not len(parts):
        return found
    column = _columns_of(parts, layer)
    area = shapely.area(parts)
    largest, thickest = _most(area, column), _most(thickness(parts), column)
    island = np.zeros(len(largest), dtype=bool)
    island[column[_under(parts, layer, needed.islands, needed.island_layer)]] = True
    kept = (largest >= _WORTHWHILE_MM2) | island
    height = (_most(layer, column) + _most(-layer, column) + 1) * layer_height
    short_of = np.maximum(np.maximum(_STABLE_MM, height / _SLENDERNESS) - thickest, 0.0)
    growth = np.ceil(short_of / 2 / _GROWTH_STEP_MM - 1e-6) * _GROWTH_STEP_MM
    chosen = kept[column]
    return _thickened(parts[chosen], layer[chosen], growth[column[chosen]], len(found), taken)


def _most(values: FloatArray | IntArray, column: IntArray) -> FloatArray:
    """(C,) greatest value of each column's parts."""
    most = np.full(int(column.max()) + 1, -np.inf)
    np.maximum.at(most, column, values)
    return most


def _columns_of(parts: Shapes, layer: IntArray) -> IntArray:
    """(P,) number of the column that each part belongs to: parts that touch from layer to layer are one."""
    upper, lower = _pairs(parts, layer, parts, layer - 1)
    label = np.arange(len(parts))
    while True:
        least = label.copy()
        np.minimum.at(least, upper, label[lower])
        np.minimum.at(least, lower, label[upper])
        least = least[least]
        if np.array_equal(least, label):
            number: IntArray = np.unique(label, return_inverse=True)[1].astype(np.int64)
            return number
        label = least


def _under(parts: Shapes, layer: IntArray, islands: Shapes, island_layer: IntArray) -> IntArray:
    """The parts that lie under an island."""
    under: IntArray = np.unique(_pairs(parts, layer, islands, island_layer)[1])
    return under


def _pairs(parts: Shapes, layer: IntArray, others: Shapes, other_layer: IntArray) -> tuple[IntArray, IntArray]:
    """(other, part) of all that overlap on the same layer."""
    tree = shapely.STRtree(_set_apart(parts, layer))
    other, part = tree.query(_set_apart(others, other_layer), predicate="intersects")
    return other.astype(np.int64), part.astype(np.int64)


def _set_apart(shapes: Shapes, layer: IntArray) -> Shapes:
    points, owner = shapely.get_coordinates(shapes, return_index=True)
    moved: FloatArray = points + np.column_stack([layer[owner] * _LAYER_SHIFT_MM, np.zeros(len(owner))])
    copies: Shapes = shapely.set_coordinates(shapes.copy(), moved)
    return copies


def _thickened(parts: Shapes, layer: IntArray, growth: FloatArray, count: int, taken: Shapes) -> Shapes:
    """(L,) the parts grown, clipped again, without what is too narrow for a line."""
    whole = parts.copy()
    for amount in np.unique(growth[growth > 0]):
        rows = np.flatnonzero(growth == amount)
        whole[rows] = once(partial(_grown, by_mm=amount), parts[rows])
    grown = np.flatnonzero(growth > 0)
    (whole[grown],) = geos_in_threads(_clipped, whole[grown], taken[layer[grown]])
    pieces, owner = shapely.get_parts(whole, return_index=True)
    merged = gathered(pieces, layer[owner], count)
    (merged,) = geos_in_threads(_united, merged)
    pieces, owner = shapely.get_parts(merged, return_index=True)
    pieces, row = shapely.get_parts(once(_opened, pieces), return_index=True)
    return gathered(pieces, owner[row], count)


def _grown(shapes: Shapes, by_mm: float) -> tuple[Shapes]:
    return (shapely.buffer(shapes, by_mm, quad_segs=_ARC_SEGMENTS),)


def _clipped(shapes: Shapes, taken: Shapes) -> tuple[Shapes]:
    met = shapely.intersects(shapes, taken)
    shapes[met] = difference(shapes[met], taken[met])
    return (shapes,)


def _united(shapes: Shapes) -> tuple[Shapes]:
    """Grown columns that overlap become one."""
    met = ~shapely.is_valid(shapes)
    shapes[met] = shapely.buffer(shapes[met], 0.0)
    return (shapes,)


def _opened(shapes: Shapes) -> tuple[Shapes]:
    core = offset(shapes, -_HALF_LEAST_WIDTH_MM)
    return (simplified(shapely.buffer(core, _HALF_LEAST_WIDTH_MM, quad_segs=_ARC_SEGMENTS), SIMPLIFY_MM),)
