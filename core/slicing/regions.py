"""Which loops bound material: nesting by winding number, and the polygons that follow from it."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from ..model import BoolArray, FloatArray, IntArray
from .outlines import Outlines


def polygons_of(outlines: Outlines) -> NDArray[np.object_]:
    """(M,) shapely polygon inside each loop."""
    closing = np.insert(outlines.points, outlines.start[1:], outlines.points[outlines.start[:-1]], axis=0)
    ring = np.repeat(np.arange(len(outlines.layer)), outlines.count + 1)
    rings: NDArray[np.object_] = shapely.polygons(shapely.linearrings(closing, indices=ring))
    return rings


def containers(outlines: Outlines, rings: NDArray[np.object_]) -> tuple[IntArray, IntArray]:
    """Pairs (inner, outer) of loops of one layer of which the second surrounds the first point of the first.

    Args:
        outlines: M loops that do not cross each other.
        rings: (M,) their polygons.
    """
    box = shapely.bounds(rings)
    inner, outer = _same_layer_pairs(outlines.layer)
    a, b = box[inner], box[outer]
    within = (a[:, :2] >= b[:, :2]).all(axis=1) & (a[:, 2:] <= b[:, 2:]).all(axis=1) & (inner != outer)
    inner, outer = inner[within], outer[within]
    shapely.prepare(rings)
    probe = outlines.points[outlines.start[:-1]][inner]
    inside = shapely.contains_xy(rings[outer], probe[:, 0], probe[:, 1])
    return inner[inside], outer[inside]


def _same_layer_pairs(layer: IntArray) -> tuple[IntArray, IntArray]:
    """All ordered pairs of loops in the same layer; `layer` (M,) is sorted."""
    first = np.searchsorted(layer, layer, side="left")
    count = np.searchsorted(layer, layer, side="right") - first
    inner = np.repeat(np.arange(len(layer)), count)
    offset = np.arange(len(inner)) - np.repeat(np.cumsum(count) - count, count)
    return inner, first[inner] + offset


def boundary_loops(outlines: Outlines) -> tuple[Outlines, IntArray, IntArray]:
    """Keep the loops that part material from air by the non-zero rule, and turn them counter-clockwise around it.

    Args:
        outlines: loops that do not cross each other.

    Returns:
        The loops that stay; (M,) how many of these surround each; (M,) the one directly around it, -1 for none.
    """
    if len(outlines.layer) == 0:
        none = np.zeros(0, dtype=np.int64)
        return outlines, none, none
    area = outlines.signed_area
    turn = np.sign(area).astype(np.int64)
    inner, outer = containers(outlines, polygons_of(outlines))
    winding_outside = np.bincount(inner, weights=turn[outer], minlength=len(turn)).astype(np.int64)
    solid_inside, solid_outside = winding_outside + turn != 0, winding_outside != 0
    keep = solid_inside != solid_outside
    oriented = outlines.reversed(keep & (solid_inside == (turn < 0)))
    kept = oriented.selected(keep)
    number = np.cumsum(keep) - 1
    pair = keep[inner] & keep[outer]
    return kept, *_nesting(number[inner[pair]], number[outer[pair]], np.abs(area[keep]))


def _nesting(inner: IntArray, outer: IntArray, area: FloatArray) -> tuple[IntArray, IntArray]:
    depth = np.bincount(inner, minlength=len(area)).astype(np.int64)
    parent = np.full(len(area), -1, dtype=np.int64)
    by_area = np.argsort(-area[outer], kind="stable")
    parent[inner[by_area]] = outer[by_area]  # the smallest one around a loop is written last
    return depth, parent


def region_polygons(outlines: Outlines, parent: IntArray) -> tuple[NDArray[np.object_], IntArray, IntArray]:
    """Polygons with holes from correctly turned loops.

    Args:
        outlines: M loops, counter-clockwise around material, clockwise around holes.
        parent: (M,) the loop directly around each one, -1 for none.

    Returns:
        (I,) polygons, (I,) the layer of each, (M,) the polygon that each loop bounds.
    """
    is_outer = outlines.signed_area > 0
    shells = np.flatnonzero(is_outer)
    holes = np.flatnonzero(~is_outer & (parent >= 0))
    region = np.full(len(is_outer), -1, dtype=np.int64)
    region[shells] = np.arange(len(shells))
    region[holes] = region[parent[holes]]
    rings = shapely.get_exterior_ring(polygons_of(outlines))
    by_region = holes[np.argsort(region[holes], kind="stable")]
    polygons = np.empty(len(shells), dtype=object)
    polygons[:] = shapely.polygons(rings[shells])
    with_holes = np.unique(region[by_region])
    if len(with_holes):
        compact = np.searchsorted(with_holes, region[by_region])
        polygons[with_holes] = _with_holes(rings[shells[with_holes]], rings[by_region], compact)
    return polygons, outlines.layer[shells], region


def _with_holes(shells: NDArray[np.object_], holes: NDArray[np.object_], of_shell: IntArray) -> NDArray[np.object_]:
    parts = np.split(holes, np.flatnonzero(np.diff(of_shell)) + 1)
    return np.array(
        [shapely.Polygon(shell, list(part)) for shell, part in zip(shells, parts, strict=True)], dtype=object
    )


def crossing_layers(polygons: NDArray[np.object_], polygon_layer: IntArray, layers: int) -> BoolArray:
    """(L,) which layers have a loop that crosses itself or another one."""
    crossing = np.zeros(layers, dtype=bool)
    whole = layer_regions(polygons, polygon_layer, layers)
    crossing[:] = ~shapely.is_valid(whole)
    return crossing


def layer_regions(polygons: NDArray[np.object_], polygon_layer: IntArray, layers: int) -> NDArray[np.object_]:
    """(L,) one multipolygon a layer; empty where nothing is."""
    regions = np.empty(layers, dtype=object)
    regions[:] = shapely.MultiPolygon()
    if len(polygons):
        present = np.unique(polygon_layer)
        regions[present] = shapely.multipolygons(polygons, indices=np.searchsorted(present, polygon_layer))
    return regions


def solid_regions(outlines: Outlines, layers: int) -> NDArray[np.object_]:
    """(L,) cross-sections of a solid by the non-zero rule; where its loops cross, what GEOS makes of them."""
    kept, _, parent = boundary_loops(outlines)
    polygons, polygon_layer, _ = region_polygons(kept, parent)
    regions = layer_regions(polygons, polygon_layer, layers)
    broken = ~shapely.is_valid(regions)
    regions[broken] = shapely.make_valid(regions[broken])
    return regions
