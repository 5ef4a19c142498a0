"""Makes supports stable: thin columns are dropped if they are not worth printing, else thickened."""

from __future__ import annotations

from functools import partial

import numpy as np
import shapely

from ..fill.offsets import offset, simplified
from ..mesh.components import connected
from ..model import FloatArray, IntArray, Shapes
from ..parallel import geos_in_threads
from ..slicing.regions import gathered
from .grid_overlay import SIMPLIFY_MM, areas, once, overlapping, thickness
from .overhangs import Contacts

# Columns that never get this large (mm²), what is too narrow to be printed left out, carry bumps and ledges that hold
# without, unless something begins in the air there.
_WORTHWHILE_MM2 = 3.0
# Least thickness of a column, mm (the diameter of a round one), and the greatest ratio of height to thickness.
_STABLE_MM = 4.0
_SLENDERNESS = 12.0
_GROWTH_STEP_MM = 0.25  # so that columns of about one height grow alike
# Nothing narrower than twice this, mm, is printed.
_HALF_LEAST_WIDTH_MM = 0.3
_NARROW_MM = 1.2  # strips narrower than this may be too narrow in part
_ARC_SEGMENTS = 4


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
    thickest = _most(thickness(parts), column)
    wide, narrow = parts.copy(), np.flatnonzero(thickest[column] < 2 * _NARROW_MM)
    wide[narrow] = once(_opened, parts[narrow])
    largest = _most(shapely.area(wide), column)
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
    """(P,) number of each part's column: parts that touch from layer to layer are one column."""
    upper, lower = overlapping(parts, layer, parts, layer - 1)
    return connected(len(parts), upper, lower)


def _under(parts: Shapes, layer: IntArray, islands: Shapes, island_layer: IntArray) -> IntArray:
    """The parts that lie under an island."""
    under: IntArray = np.unique(overlapping(parts, layer, islands, island_layer)[1])
    return under


def _thickened(parts: Shapes, layer: IntArray, growth: FloatArray, count: int, taken: Shapes) -> Shapes:
    """(L,) the parts grown, clipped again, without what is too narrow for a line."""
    whole = parts.copy()
    for amount in np.unique(growth[growth > 0]):
        rows = np.flatnonzero(growth == amount)
        whole[rows] = once(partial(_grown, by_mm=amount), parts[rows])
    narrow = np.flatnonzero(growth < _HALF_LEAST_WIDTH_MM)
    whole[narrow] = once(_opened, whole[narrow])
    grown = np.flatnonzero(growth > 0)
    cut = grown[shapely.intersects(whole[grown], taken[layer[grown]])]
    (whole[cut],) = geos_in_threads(_clipped, whole[cut], taken[layer[cut]])
    pieces, owner = shapely.get_parts(whole, return_index=True)
    some = ~shapely.is_empty(pieces)
    return _united(pieces[some], layer[owner[some]], count)


def _united(pieces: Shapes, layer: IntArray, count: int) -> Shapes:
    """(L,) pieces of each layer; grown columns that overlap become one."""
    group = connected(len(pieces), *overlapping(pieces, layer, pieces, layer))
    shapes, several = gathered(pieces, group, len(pieces)), np.bincount(group, minlength=len(pieces)) > 1
    shapes[several] = once(lambda some: (shapely.buffer(some, 0.0),), shapes[several])
    of_group = np.zeros(len(pieces), dtype=np.int64)
    of_group[group] = layer
    parts, owner = shapely.get_parts(shapes, return_index=True)
    return gathered(parts, of_group[owner], count)


def _grown(shapes: Shapes, by_mm: float) -> tuple[Shapes]:
    """(P,) shapes grown by a distance."""
    return (simplified(shapely.buffer(shapes, by_mm, quad_segs=_ARC_SEGMENTS), SIMPLIFY_MM),)


def _clipped(shapes: Shapes, taken: Shapes) -> tuple[Shapes]:
    """(P,) shapes less what is taken (P,), without what is then too narrow for a line."""
    # Edges that were moved run along no others, so that this needs no grid.
    return _opened(areas(shapely.difference(shapes, taken)))


def _opened(shapes: Shapes) -> tuple[Shapes]:
    """(P,) shapes without what is too narrow for a line."""
    core = offset(shapes, -_HALF_LEAST_WIDTH_MM)
    return (simplified(shapely.buffer(core, _HALF_LEAST_WIDTH_MM, quad_segs=_ARC_SEGMENTS), SIMPLIFY_MM),)
