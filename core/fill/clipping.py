"""Polygon clipping: intersection and difference of many pairs of regions at once, in half the time of GEOS.

Between two crossings an outline runs wholly within the other region or wholly beyond it; at a crossing the boundary of
what both share, or of what one leaves of the other, goes over to the other outline (Weiler and Atherton 1977).
"""

from __future__ import annotations

from dataclasses import fields
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray

from ..model import BoolArray, FloatArray, IntArray, Shapes
from ..ragged import following, ranges, starts, sums
from ..records import dataclass
from ..slicing.cycles import cycles
from ..slicing.outlines import Outlines
from ..slicing.regions import gathered, regions_of

_TOUCHING_MM = 1e-6  # nearer to each other an edge and the end of another one may touch
_LEAST_RUN = 6  # edges of a ring that are compared by their common box first; the root of their number in long ones
_PAIRS_AT_ONCE = 1 << 19

Plane = NDArray[np.complex128]


@dataclass(frozen=True)
class _Rings:
    """R rings of N points, those of the shapes first, then those of their cutters.

    Attributes:
        points: (N,) mm, in the complex plane.
        start: (R + 1,) offsets.
        row: (R,) what each bounds, to its left; not decreasing.
    """

    points: Plane
    start: IntArray
    row: IntArray

    @cached_property
    def ring(self) -> IntArray:
        """(N,) of each point."""
        return np.repeat(np.arange(len(self.row)), np.diff(self.start))

    @cached_property
    def ends(self) -> Plane:
        """(N,) mm, the next point of the ring."""
        return np.asarray(self.points[following(self.start)])


@dataclass(frozen=True)
class _Crossings:
    """K places where an edge of a shape crosses one of its cutter.

    Attributes:
        place: (K,) mm.
        leaves: (K,) bool, where the shape's ring leaves the cutter; else it enters it.
        edge: (2, K) of the shape and of the cutter.
        share: (2, K) of the edges that lies before.
    """

    place: Plane
    leaves: BoolArray
    edge: IntArray
    share: FloatArray

    def of(self, keep: BoolArray) -> _Crossings:
        """Those that `keep` (K,) marks."""
        return _Crossings(self.place[keep], self.leaves[keep], self.edge[:, keep], self.share[:, keep])

    def along(self, rings: _Rings) -> tuple[IntArray, IntArray]:
        """(2, K) which crossing comes next along the ring of either side, and how many points of the ring before it."""
        edge = self.edge.ravel()
        order = np.lexsort((self.share.ravel(), edge))
        edge, ring = edge[order], rings.ring[edge[order]]
        ahead = following(starts(np.bincount(ring, minlength=len(rings.row))))
        rest = np.where(ahead <= np.arange(len(order)), np.diff(rings.start)[ring], 0)
        after, between = np.empty((2, len(order)), dtype=np.int64)
        after[order], between[order] = order[ahead], edge[ahead] - edge + rest
        after[len(after) // 2 :] -= len(after) // 2
        return after.reshape(2, -1), between.reshape(2, -1)


@dataclass(frozen=True)
class _Runs:
    """P pieces of rings, in order, that make up Q new rings.

    Attributes:
        ring: (P,) that each is a piece of.
        first: (P,) its first point, counted from the ring's.
        count: (P,) points.
        against: (P,) bool, against the ring's direction.
        of_ring: (Q,) pieces of each new ring.
        row: (Q,) what that bounds.
    """

    ring: IntArray
    first: IntArray
    count: IntArray
    against: BoolArray
    of_ring: IntArray
    row: IntArray


def parted(whole: Shapes, cutters: Shapes) -> tuple[Shapes, Shapes, BoolArray]:
    """What of regions lies within others and what beyond.

    Args:
        whole: (N,) valid Polygon or MultiPolygon, maybe empty.
        cutters: (N,) likewise.

    Returns:
        (N,) MultiPolygon within and (N,) beyond, maybe empty; (N,) bool, where they are right: not where outlines touch
        or run along each other, and not always where an outline touches itself.
    """
    sound, count = np.ones(len(whole), dtype=bool), len(whole)
    rings = _rings(np.concatenate([whole, cutters]))
    met = _crossings(rings, sound)
    runs = _joined(rings, met, count), _uncrossed(rings, met, np.concatenate([cutters, whole]), sound)
    points = np.concatenate([rings.points, met.place])
    start = np.append(rings.start, len(rings.points) + 1 + np.arange(len(met.place)))
    parts = _shapes(points, start, runs, 2 * count)
    return parts[:count], parts[count:], sound & shapely.is_valid(parts).reshape(2, -1).all(axis=0)


def _rings(shapes: Shapes) -> _Rings:
    parts, owner = shapely.get_parts(shapes, return_index=True)
    rings, part = shapely.get_rings(parts, return_index=True)
    corners, ring = shapely.get_coordinates(rings, return_index=True)
    kept = np.append(ring[1:] == ring[:-1], False)[: len(ring)]
    points = corners.compress(kept, axis=0).view(np.complex128).ravel()
    count = np.bincount(ring[kept], minlength=len(rings))
    start, hole = starts(count), np.append(False, part[1:] == part[:-1])[: len(part)]
    turned = (sums((points.conj() * points[following(start)]).imag, start) < 0) != hole
    index = np.arange(len(points))
    mirrored = np.repeat(start[:-1] + start[1:] - 1, count) - index
    return _Rings(points[np.where(np.repeat(turned, count), mirrored, index)], start, owner[part])


def _crossings(rings: _Rings, sound: BoolArray) -> _Crossings:
    """Where shapes cross their cutters; rows of which that is not sure are marked as not `sound` and left out."""
    edge = _near_edges(rings, len(sound))
    begin = rings.points[edge]
    along = rings.ends[edge] - begin
    # How far to the left of each edge's line both ends of the other one lie, times its length.
    line, apart = along[::-1].conj(), begin[0] - begin[1]
    side = (line * [apart, -apart]).imag
    end = side + (line * along).imag
    touching = _TOUCHING_MM * np.abs(along[::-1])
    low, high = np.minimum(side, end), np.maximum(side, end)
    clear = ((low > touching) | (high < -touching)).any(axis=0)
    through = ((low < -touching) & (high > touching)).all(axis=0)
    row = rings.row[rings.ring[edge[0]]]
    sound[row[~clear & ~through]] = False
    share = side / np.where(through, side - end, 1.0)
    met = _Crossings(begin[0] + along[0] * share[0], side[0] > 0, edge, share).of(through & sound[row])
    turn = met.leaves[met.along(rings)[0]] == met.leaves  # who has left has to enter
    sound[rings.row[rings.ring[met.edge[0, turn.any(axis=0)]]]] = False
    return met.of(sound[rings.row[rings.ring[met.edge[0]]]])


def _near_edges(rings: _Rings, count: int) -> IntArray:
    """(2, E) pairs of edges of `count` shapes and of their cutters whose boxes meet."""
    x, y, end_x, end_y = rings.points.real, rings.points.imag, rings.ends.real, rings.ends.imag
    boxes = np.stack([np.minimum(x, end_x), np.minimum(y, end_y), -np.maximum(x, end_x), -np.maximum(y, end_y)])
    size = np.diff(rings.start)
    run = np.maximum(_LEAST_RUN, np.sqrt(size).astype(np.int64))
    runs = -(-size // run)
    first = np.repeat(rings.start[:-1], runs) + np.repeat(run, runs) * ranges(np.zeros_like(runs), runs)
    length, row = np.diff(first, append=len(x)), np.repeat(rings.row, runs)
    low = np.searchsorted(row, row + count)
    beside = np.searchsorted(row, row + count, side="right") - low
    common, found = np.minimum.reduceat(boxes, first, axis=1), []
    for part in np.array_split(np.flatnonzero(beside), 1 + beside.sum() // _PAIRS_AT_ONCE):
        one, other = _meeting(common, np.repeat(part, beside[part]), common, ranges(low[part], beside[part]))
        one, other = _meeting(boxes, ranges(first[one], length[one]), common, np.repeat(other, length[one]))
        one, other = np.repeat(one, length[other]), ranges(first[other], length[other])
        found.append(np.stack(_meeting(boxes, one, boxes, other)))
    return np.concatenate(found, axis=1)


def _meeting(boxes: FloatArray, one: IntArray, others: FloatArray, other: IntArray) -> tuple[IntArray, IntArray]:
    """Those of pairs of boxes, least coordinates and less greatest ones, that meet or nearly do."""
    for low, high in zip(boxes, others[[2, 3, 0, 1]], strict=True):
        meets = np.flatnonzero(low.take(one) + high.take(other) <= _TOUCHING_MM)
        one, other = one.take(meets), other.take(meets)
    return one, other


def _joined(rings: _Rings, met: _Crossings, count: int) -> _Runs:
    """Rings around what is shared, or left beyond the cutters, which go over to the other side at every crossing."""
    after, between = met.along(rings)
    before = np.empty_like(after[1])
    before[after[1]] = np.arange(len(before))
    # Beyond a cutter its outline is followed backwards.
    end = np.where(met.leaves, before[after[0]], after[1, after[0]])
    owner, others_owner = rings.ring[met.edge]
    row = rings.row[owner] + np.where(met.leaves, count, 0)
    begin, start = cycles(end, row)
    middle, against = after[0, begin], met.leaves[begin]
    ring, others_ring = owner[begin], others_owner[middle]
    edge = np.stack([met.edge[0, begin] + 1, met.edge[1, middle] + ~against]) - rings.start[[ring, others_ring]]
    nothing, crossing = np.zeros_like(begin), len(rings.row)
    columns = (
        [crossing + begin, ring, crossing + middle, others_ring],
        [nothing, edge[0], nothing, edge[1]],
        [nothing + 1, between[0, begin], nothing + 1, between[1, np.where(against, end[begin], middle)]],
        [nothing, nothing, nothing, nothing + against],
    )
    piece, first, length, backwards = (np.stack(column, axis=1).ravel() for column in columns)
    return _Runs(piece, first, length, backwards > 0, 4 * np.diff(start), row[begin[start[:-1]]])


def _uncrossed(rings: _Rings, met: _Crossings, others: Shapes, sound: BoolArray) -> _Runs:
    """Rings that cross nothing, as they are or the other way round, of what is shared or of what is left beyond."""
    count = len(sound)
    crossed = np.zeros(len(rings.row), dtype=bool)
    crossed[rings.ring[met.edge]] = True
    alone = np.flatnonzero(~crossed & sound[rings.row % count])
    row, point = rings.row[alone], rings.points[rings.start[alone]]
    inside = shapely.contains_xy(others[row], point.real, point.imag)
    own, hole = row < count, (row >= count) & inside
    ring = np.concatenate([alone[own | hole], alone[hole]])
    against = np.arange(len(ring)) >= len(ring) - hole.sum()
    size = np.diff(rings.start)[ring]
    of_row = np.where(inside, row % count, row + count)[own | hole]
    return _Runs(
        ring, np.where(against, size - 1, 0), size, against, np.ones_like(ring), np.concatenate([of_row, row[hole]])
    )


def _shapes(points: Plane, begin: IntArray, found: tuple[_Runs, ...], count: int) -> Shapes:
    """(count,) MultiPolygon of rings that are made of runs of points, of rings that begin at (R + 1,) places."""
    ring, first, length, against, of_ring, row = (
        np.concatenate([getattr(runs, column.name) for runs in found]) for column in fields(_Runs)
    )
    by_row, order = np.argsort(np.repeat(row, of_ring), kind="stable"), np.argsort(row, kind="stable")
    ring, first, length, against = (column[by_row] for column in (ring, first, length, against))
    place = ranges(np.zeros_like(length), length) * np.repeat(1 - 2 * against, length) + np.repeat(first, length)
    place %= np.repeat(np.diff(begin)[ring], length)
    corners = points[place + np.repeat(begin[ring], length)].view(np.float64).reshape(-1, 2)
    start = starts(length)[starts(of_ring[order])]
    nothing = np.zeros(len(corners), dtype=np.int64)
    regions = regions_of(Outlines(corners, start, row[order], nothing, np.zeros((len(corners), 2, 0))))
    return gathered(regions.polygons, regions.polygon_layer, count)
