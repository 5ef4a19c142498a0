"""Layers whose loops cross: unite by the non-zero rule without losing what the segments carry."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from ..model import FloatArray, IntArray
from ..ragged import starts
from .outlines import Outlines, interpolated

# Odd numbers with bits all over, to scatter coordinates by.
_SCATTER = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F], dtype=np.uint64)


def united(outlines: Outlines) -> Outlines:
    """The boundary of the non-zero winding region of the loops of one layer.

    Loops are noded where they cross, the faces of that arrangement whose winding number is not zero are merged, and
    each segment of the new boundary takes over from the segment that it is a piece of.

    Args:
        outlines: any loops of a single layer; they may cross, overlap and run twice.
    """
    # Whole loops: GEOS nodes and polygonizes the few pieces between crossings twenty times as fast as single segments.
    noded = shapely.union_all(shapely.linearrings(outlines.points, indices=outlines.loop))
    cells = shapely.get_parts(shapely.polygonize(shapely.get_parts(noded)))
    if len(cells) == 0:
        return outlines.selected(np.zeros(len(outlines.layer), dtype=bool))
    probe = shapely.get_coordinates(shapely.point_on_surface(cells))
    solid = cells[winding_number(probe, outlines.points, outlines.ends) != 0]
    region = shapely.orient_polygons(shapely.disjoint_subset_union_all(solid))
    rings = shapely.get_rings(shapely.get_parts(region))
    points, ring = shapely.get_coordinates(rings, return_index=True)
    last = np.append(ring[1:] != ring[:-1], True) if len(ring) else np.zeros(0, dtype=bool)
    segment_tail, segment_head = points[~last], points[1:][~last[:-1]] if len(points) else points
    face, carried = _taken_over(segment_tail, segment_head, outlines)
    count = np.bincount(ring[~last], minlength=len(rings)).astype(np.int64)
    layer = np.full(len(rings), outlines.layer[0])
    return Outlines(segment_tail, starts(count), layer, face, carried)


def winding_number(probe: FloatArray, tails: FloatArray, heads: FloatArray) -> IntArray:
    """(Q,) how often the segments wind around each probe point (Q, 2), counter-clockwise positive."""
    number = np.zeros(len(probe), dtype=np.int64)
    for chunk in np.array_split(np.arange(len(probe)), max(1, len(probe) * len(tails) // 4_000_000)):
        x, y = probe[chunk, 0, None], probe[chunk, 1, None]
        up = (tails[:, 1] <= y) & (heads[:, 1] > y)
        down = (tails[:, 1] > y) & (heads[:, 1] <= y)
        along = heads - tails
        side: FloatArray = along[:, 0] * (y - tails[:, 1]) - (x - tails[:, 0]) * along[:, 1]
        number[chunk] = (up & (side > 0)).sum(axis=1) - (down & (side < 0)).sum(axis=1)
    return number


def _taken_over(tail: FloatArray, head: FloatArray, source: Outlines) -> tuple[IntArray, FloatArray]:
    """Face and carried values of new segments, each a piece of one of the old ones."""
    tails, heads = source.points, source.ends
    parent = equal_segments(tail, head, tails, heads)
    pieces = np.flatnonzero(parent < 0)
    if len(pieces):
        whole = np.zeros(len(tails), dtype=bool)
        whole[parent[parent >= 0]] = True
        gone = np.flatnonzero(~whole)  # what is still whole has no pieces
        tree = shapely.STRtree(shapely.linestrings(np.stack([tails[gone], heads[gone]], axis=1)))
        parent[pieces] = gone[tree.nearest(shapely.points((tail[pieces] + head[pieces]) / 2))]
    start, end = tails[parent], heads[parent]
    along = end - start
    length2 = np.maximum((along**2).sum(axis=1), 1e-300)
    carried = np.stack(
        [
            interpolated(source.carried[parent], ((point - start) * along).sum(axis=1) / length2)
            for point in (tail, head)
        ],
        axis=1,
    )
    return source.face[parent], carried


def equal_segments(tail: FloatArray, head: FloatArray, tails: FloatArray, heads: FloatArray) -> IntArray:
    """(N,) the segment from `tails` to `heads` with the same ends, either way round; -1 if there is none or several.

    Most segments cross nothing and are found so, ten times as fast as by looking for the nearest one.
    """
    old, new = _scattered(tails) + _scattered(heads), _scattered(tail) + _scattered(head)
    order = np.argsort(old)
    place = np.minimum(np.searchsorted(old[order], new), len(old) - 1)
    twin = (old[order][1:] == old[order][:-1]) if len(old) else np.zeros(0, dtype=bool)
    alone = ~(np.append(twin, False) | np.append(False, twin))
    found = order[place]
    ends, own = np.stack([tails, heads])[:, found], np.stack([tail, head])
    same = (ends == own).all(axis=(0, 2)) | (ends[::-1] == own).all(axis=(0, 2))
    return np.where(same & alone[place], found, -1)


def _scattered(points: FloatArray) -> NDArray[np.uint64]:
    """(N,) hashes of points (N, 2); sums of two tell pairs of points apart, whichever comes first."""
    bits = (points + 0.0).view(np.uint64) * _SCATTER  # a negative zero is a zero
    mixed: NDArray[np.uint64] = (bits[:, 0] ^ (bits[:, 1] >> np.uint64(29))) * _SCATTER[0]
    # Points that mirror each other differ in a single bit up to here, and their differences would cancel out.
    for shift, factor in zip(np.array([33, 29], dtype=np.uint64), _SCATTER, strict=True):
        mixed = (mixed ^ (mixed >> shift)) * factor
    return mixed ^ (mixed >> np.uint64(32))
