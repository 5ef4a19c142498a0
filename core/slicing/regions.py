"""Which loops bound material: nesting by winding number, and the polygons that follow from it."""

from __future__ import annotations

import numpy as np
import shapely

from ..model import BoolArray, FloatArray, IntArray, Shapes
from ..ragged import ahead, ranges, starts
from ..records import dataclass
from .outlines import Outlines

_ROUNDS = 2  # of leaving out points that lie on a straight line
_LEAST_CORNERS = 3  # of a loop


@dataclass(frozen=True)
class Regions:
    """Cross-sections of a solid.

    Attributes:
        outlines: M loops, counter-clockwise around material, clockwise around holes.
        polygons: (I,) connected regions as shapely polygons.
        polygon_layer: (I,) int64, not decreasing.
        loop_polygon: (M,) int64, the region that each loop bounds, -1 for none.
    """

    outlines: Outlines
    polygons: Shapes
    polygon_layer: IntArray
    loop_polygon: IntArray

    def with_layers_from(self, other: Regions, layers: BoolArray) -> Regions:
        """These regions, with those of `other` in the layers that `layers` (L,) marks, the only ones that it has."""
        stay = ~layers[self.outlines.layer]
        layer = np.concatenate([self.polygon_layer, other.polygon_layer])
        kept = np.flatnonzero(np.append(~layers[self.polygon_layer], np.ones(len(other.polygons), dtype=bool)))
        kept = kept[np.argsort(layer[kept], kind="stable")]
        place = np.full(len(layer) + 1, -1)  # the last one for loops that bound nothing
        place[kept] = np.arange(len(kept))
        others = np.where(other.loop_polygon < 0, -1, other.loop_polygon + len(self.polygons))
        loop_polygon = place[np.concatenate([self.loop_polygon[stay], others])]
        loop_layer = np.concatenate([self.outlines.layer[stay], other.outlines.layer])
        return Regions(
            Outlines.joined([*self.outlines.runs(stay), other.outlines]),
            np.concatenate([self.polygons, other.polygons])[kept],
            layer[kept],
            loop_polygon[np.argsort(loop_layer, kind="stable")],
        )


def regions_of(outlines: Outlines, tolerance: float = 0.0) -> Regions:
    """The regions that loops bound by the non-zero rule.

    Args:
        outlines: loops that do not cross each other; where they do, the regions are not valid.
        tolerance: mm, by which polygons may differ from their loops.
    """
    kept, is_outer, parent = boundary_loops(outlines)
    shells = np.flatnonzero(is_outer)
    region = np.full(len(is_outer), -1, dtype=np.int64)
    region[shells] = np.arange(len(shells))
    holes = np.flatnonzero(~is_outer & (parent >= 0))
    region[holes] = region[parent[holes]]
    # The rings of each polygon, its shell first.
    rings = np.concatenate([shells, holes])
    rings = rings[np.argsort(region[rings], kind="stable")]
    count = np.bincount(region[rings], minlength=len(shells))
    points, start = straightened(kept.points, kept.start, tolerance) if tolerance else (kept.points, kept.start)
    return Regions(kept, ring_polygons(points, start, rings, starts(count)), kept.layer[shells], region)


def straightened(points: FloatArray, start: IntArray, tolerance: float) -> tuple[FloatArray, IntArray]:
    """Loops with fewer points, where these lie nearly on the line between their neighbors.

    Every other point of a loop may go, twice: so much is found without following the loops.

    Args:
        points: (N, 2) mm.
        start: (M + 1,) where each loop's points start.
        tolerance: mm, by which the loops may change.

    Returns:
        (N', 2) mm, and (M + 1,) where each loop's points start.
    """
    for _ in range(_ROUNDS):
        step = (ahead(points, start) - points).view(np.complex128).ravel()
        odd = np.flatnonzero((np.arange(len(step)) - np.repeat(start[:-1], np.diff(start))) & 1)
        before, after = step.take(odd - 1), step.take(odd)
        turn = after * before.conj()
        off = np.abs(turn.imag) <= tolerance / _ROUNDS * np.abs(before + after)
        kept = np.ones(len(step), dtype=bool)
        kept[odd[off & (turn.real > 0)]] = False
        few = np.flatnonzero(np.add.reduceat(kept, start[:-1], dtype=np.int64) < _LEAST_CORNERS)
        kept[ranges(start[few], np.diff(start)[few])] = True
        points, start = points.compress(kept, axis=0), starts(np.add.reduceat(kept, start[:-1], dtype=np.int64))
    return points, start


def polygons_of(outlines: Outlines, rings: IntArray, start: IntArray) -> Shapes:
    """(K,) shapely polygons.

    Args:
        outlines: M loops.
        rings: (R,) loops, the shell of each polygon followed by its holes.
        start: (K + 1,) where each polygon's rings start.
    """
    return ring_polygons(outlines.points, outlines.start, rings, start)


def ring_polygons(points: FloatArray, loop_start: IntArray, rings: IntArray, start: IntArray) -> Shapes:
    """(K,) shapely polygons of rings that do not repeat their first points; arguments as of `polygons_of`."""
    if not len(rings):
        return np.zeros(0, dtype=object)
    count = np.diff(loop_start)[rings] + 1
    ring_start = starts(count)
    point = ranges(loop_start[rings], count)
    point[ring_start[1:] - 1] = loop_start[rings]
    kind = shapely.GeometryType.POLYGON
    polygons: Shapes = shapely.from_ragged_array(kind, points.take(point, axis=0), (ring_start, start))
    return polygons


def ring_points(rings: Shapes) -> tuple[FloatArray, IntArray]:
    """(N, 2) points of (R,) rings without the repeated first ones, and (R + 1,) where those of each ring start."""
    points, ring = shapely.get_coordinates(rings, return_index=True)
    kept = np.append(ring[1:] == ring[:-1], False)[: len(ring)]
    return points.compress(kept, axis=0), starts(np.bincount(ring[kept], minlength=len(rings)))


def containers(outlines: Outlines) -> tuple[IntArray, IntArray]:
    """Pairs (inner, outer) of loops of one layer: the outer one surrounds the first point of the inner one.

    Args:
        outlines: M loops that do not cross each other.
    """
    box = _boxes(outlines)
    inner, outer = _same_layer_pairs(outlines.layer)
    a, b = box[inner], box[outer]
    within = (a[:, :2] >= b[:, :2]).all(axis=1) & (a[:, 2:] <= b[:, 2:]).all(axis=1) & (inner != outer)
    inner, outer = inner[within], outer[within]
    around, number = np.unique(outer, return_inverse=True)
    polygons = polygons_of(outlines, around, np.arange(len(around) + 1))
    shapely.prepare(polygons)
    probe = outlines.points[outlines.start[:-1]][inner]
    inside = shapely.contains_xy(polygons[number], probe[:, 0], probe[:, 1])
    return inner[inside], outer[inside]


def _boxes(outlines: Outlines) -> FloatArray:
    """(M, 4) least x and y, greatest x and y of each loop; none may be empty."""
    columns = np.ascontiguousarray(outlines.points.T)
    extremes = (np.minimum, np.maximum)
    return np.stack([of.reduceat(column, outlines.start[:-1]) for of in extremes for column in columns], axis=1)


def _same_layer_pairs(layer: IntArray) -> tuple[IntArray, IntArray]:
    """All ordered pairs of loops in the same layer; `layer` (M,) is sorted."""
    first = np.searchsorted(layer, layer, side="left")
    count = np.searchsorted(layer, layer, side="right") - first
    return np.repeat(np.arange(len(layer)), count), ranges(first, count)


def boundary_loops(outlines: Outlines) -> tuple[Outlines, BoolArray, IntArray]:
    """Keep the loops that part material from air by the non-zero rule, and turn them counter-clockwise around it.

    Args:
        outlines: loops that do not cross each other.

    Returns:
        The loops that stay; (M,) which have material inside; (M,) the loop directly around each, -1 for none.
    """
    if len(outlines.layer) == 0:
        return outlines, np.zeros(0, dtype=bool), np.zeros(0, dtype=np.int64)
    area = outlines.signed_area
    turn = np.sign(area).astype(np.int64)
    inner, outer = containers(outlines)
    winding_outside = np.bincount(inner, weights=turn[outer], minlength=len(turn)).astype(np.int64)
    solid_inside, solid_outside = winding_outside + turn != 0, winding_outside != 0
    keep = solid_inside != solid_outside
    oriented = outlines.reversed(keep & (solid_inside == (turn < 0)))
    number = np.cumsum(keep) - 1
    pair = keep[inner] & keep[outer]
    parent = _parents(number[inner[pair]], number[outer[pair]], np.abs(area[keep]))
    return oriented.selected(keep), solid_inside[keep], parent


def _parents(inner: IntArray, outer: IntArray, area: FloatArray) -> IntArray:
    parent = np.full(len(area), -1, dtype=np.int64)
    by_area = np.argsort(-area[outer], kind="stable")
    parent[inner[by_area]] = outer[by_area]  # the smallest one around a loop is written last
    return parent


def gathered(parts: Shapes, owner: IntArray, count: int) -> Shapes:
    """(N,) one multipolygon for each owner, of its parts in their order; empty where there are none.

    Args:
        parts: (P,) polygons; those of one owner do not overlap.
        owner: (P,) from 0 to N - 1.
        count: N.
    """
    whole = np.full(count, shapely.MultiPolygon(), dtype=object)
    if len(parts):
        order = np.argsort(owner, kind="stable")
        rows, row = np.unique(owner[order], return_inverse=True)
        whole[rows] = shapely.multipolygons(parts[order], indices=row)
    return whole


def solid_regions(outlines: Outlines, layers: int) -> Shapes:
    """(L,) cross-sections of a solid by the non-zero rule; where its loops cross, what GEOS makes of them."""
    solid = regions_of(outlines)
    regions = gathered(solid.polygons, solid.polygon_layer, layers)
    broken = ~shapely.is_valid(regions)
    regions[broken] = shapely.make_valid(regions[broken])
    return regions
