"""The middle of narrow regions: the chordal axis, from side to side through Delaunay triangles of their boundary."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import shapely

from ..model import BoolArray, FloatArray, IntArray, Shapes
from ..ragged import starts

SIMPLIFY_MM = 0.03  # finer zigzags only slow the nozzle down
ON_EDGE_MM = 1e-6
_SAMPLE = 1.0  # line widths between the boundary's points that the middle is found from
_GRID_DIGITS = 6  # decimals of mm; points much nearer than that to each other upset the triangulation
_MIXED = (0x1B873593_85EBCA6B, 0x27D4EB2F_165667C5, 0x2545F491_4F6CDD1D)  # odd numbers, to make one of three


def middles(gap: Shapes, width_mm: FloatArray) -> tuple[Shapes, Shapes]:
    """Lines along the middle of narrow polygons.

    Args:
        gap: (P,) Polygon.
        width_mm: (P,) of the lines that they are measured by.

    Returns:
        (P,) lines, which end before the polygons do, and (P,) the polygons' boundaries.
    """
    gap = shapely.segmentize(gap, _SAMPLE * width_mm)
    edge = shapely.boundary(gap)
    points, part = shapely.get_coordinates(edge, return_index=True)
    # Whatever holds the points is triangulated: one line is made sooner than a point each.
    corner, part = shapely.get_coordinates(
        _triangles(shapely.linestrings(_on_grid(points), indices=part), gap), return_index=True
    )
    corner, part = corner.reshape(-1, 4, 2)[:, :3], part[::4]
    center = (corner[:, 0] + corner[:, 1] + corner[:, 2]) / 3
    shapely.prepare(gap)
    within = ~_flat(corner) & shapely.contains_xy(gap[part], center[:, 0], center[:, 1])
    corner, center, part = corner[within], center[within], part[within]
    side = (corner + np.roll(corner, -1, axis=1)) / 2
    across = _shared(side, part)
    passed, forked = across.sum(axis=1) == 2, across.sum(axis=1) == 3
    straight = side[passed][across[passed]].reshape(-1, 2, 2)
    branches = np.stack([side[forked], np.repeat(center[forked][:, None], 3, axis=1)], axis=2).reshape(-1, 2, 2)
    part = np.concatenate([part[passed], np.repeat(part[forked], 3)])
    pieces = np.concatenate([straight, branches])[np.argsort(part, kind="stable")]
    bounds = starts(np.bincount(part, minlength=len(gap)))
    middle = shapely.from_ragged_array(
        shapely.GeometryType.MULTILINESTRING, pieces.reshape(-1, 2), (2 * np.arange(len(pieces) + 1), bounds)
    )
    return shapely.simplify(shapely.line_merge(middle), SIMPLIFY_MM, preserve_topology=False), edge


def _on_grid(points: FloatArray) -> FloatArray:
    """(N, 2) points rounded to a grid, so that neighbors either coincide or are well apart."""
    rounded: FloatArray = np.round(points, _GRID_DIGITS)
    return rounded


def _triangles(points: Shapes, gap: Shapes) -> Shapes:
    """(P,) Delaunay triangulations of (P,) sets of points on the boundaries of polygons.

    GEOS fails on some sets, mostly long symmetric ones; then the polygon itself is triangulated, which takes longer.
    """
    try:
        return np.asarray(shapely.delaunay_triangles(points))
    except shapely.GEOSException:  # tells not which one
        pass
    found = np.full(len(points), shapely.GeometryCollection(), dtype=object)
    for row, one in enumerate(points):
        try:
            found[row] = shapely.delaunay_triangles(one)
        except shapely.GEOSException:
            with suppress(shapely.GEOSException):
                found[row] = shapely.constrained_delaunay_triangles(gap[row])
    return found


def _flat(corner: FloatArray) -> BoolArray:
    """(T,) whether triangles (T, 3, 2) lie between points along a straight edge, which rounding has bent."""
    way = np.roll(corner, -1, axis=1) - corner
    area = way[:, 0, 0] * way[:, 1, 1] - way[:, 0, 1] * way[:, 1, 0]
    return np.asarray(np.abs(area) < ON_EDGE_MM * np.abs(way).sum(axis=(1, 2)))


def _shared(side: FloatArray, part: IntArray) -> BoolArray:
    """(T, 3) whether a triangle's side is that of another of its part as well, by the sides' middles (T, 3, 2)."""
    x, y = np.moveaxis(np.rint(side * (2 * 10**_GRID_DIGITS)).astype(np.int64), 2, 0)
    key = (x * _MIXED[0] + y * _MIXED[1] + part[:, None] * _MIXED[2]).ravel()  # hardly ever alike by chance
    order = np.argsort(key)
    same = np.flatnonzero(np.diff(key[order]) == 0)
    shared = np.zeros(key.shape, dtype=bool)
    shared[order[same]] = shared[order[same + 1]] = True
    return shared.reshape(-1, 3)
