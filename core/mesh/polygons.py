"""Polygons into triangles: quads are cut along the better diagonal, larger polygons by GEOS."""

from __future__ import annotations

import numpy as np
import shapely

from ..model import BoolArray, FloatArray, IntArray


def triangle_corners(
    vertices: FloatArray, polygon_start: IntArray, corner_vertex: IntArray
) -> tuple[IntArray, IntArray]:
    """Cut every polygon into triangles between its own corners; the winding is kept.

    Args:
        vertices: (V, 3) mm.
        polygon_start: (P + 1,) where each polygon's corners start.
        corner_vertex: (C,) vertex of each corner.

    Returns:
        (T, 3) corners of each triangle and (T,) the polygon it is part of, in the order of the polygons. Polygons of
        fewer than three corners give none.
    """
    sides = np.diff(polygon_start)
    if (sides == 3).all():
        return np.arange(3 * len(sides)).reshape(-1, 3) + polygon_start[0], np.arange(len(sides))
    corners, owners = [], []
    for part, polygons in (
        (polygon_start[:-1][sides == 3, None] + np.arange(3), np.flatnonzero(sides == 3)),
        _quads(vertices, polygon_start, corner_vertex, np.flatnonzero(sides == 4)),
        _large_polygons(vertices, polygon_start, corner_vertex, np.flatnonzero(sides > 4)),
    ):
        corners.append(part)
        owners.append(polygons)
    triangles, polygon = np.concatenate(corners), np.concatenate(owners)
    order = np.argsort(polygon, kind="stable")
    return triangles[order], polygon[order]


def _quads(
    vertices: FloatArray, polygon_start: IntArray, corner_vertex: IntArray, polygons: IntArray
) -> tuple[IntArray, IntArray]:
    """Two triangles per quad: along the diagonal that flips neither half, or the shorter one if both or neither do."""
    corners = polygon_start[polygons, None] + np.arange(4)
    a, b, c, d = vertices[corner_vertex[corners]].transpose(1, 0, 2)
    fits_ac = _dot(np.cross(b - a, c - a), np.cross(c - a, d - a)) > 0
    fits_bd = _dot(np.cross(c - b, d - b), np.cross(d - b, a - b)) > 0
    shorter_ac = _dot(c - a, c - a) <= _dot(d - b, d - b)
    cut_ac = np.where(fits_ac == fits_bd, shorter_ac, fits_ac)
    split = np.where(cut_ac[:, None], [0, 1, 2, 0, 2, 3], [1, 2, 3, 1, 3, 0])
    return np.take_along_axis(corners, split, axis=1).reshape(-1, 3), np.repeat(polygons, 2)


def _large_polygons(
    vertices: FloatArray, polygon_start: IntArray, corner_vertex: IntArray, polygons: IntArray
) -> tuple[IntArray, IntArray]:
    """Constrained Delaunay triangles of polygons with more than four corners, a fan where that fails."""
    if not len(polygons):
        return np.zeros((0, 3), dtype=np.int64), polygons
    sides = polygon_start[polygons + 1] - polygon_start[polygons]
    row = np.repeat(np.arange(len(polygons)), sides)
    within = np.arange(len(row)) - np.repeat(np.cumsum(sides) - sides, sides)
    corner = polygon_start[polygons][row] + within
    flat, area = _projected(vertices[corner_vertex[corner]], row, within, sides)
    triangles, owner = _delaunay(flat, row, corner)
    good = _covers(triangles, owner, flat, corner, area, sides)
    fan = (within > 0) & (within < sides[row] - 1) & ~good[row]
    spokes = np.stack([polygon_start[polygons][row[fan]], corner[fan], corner[fan] + 1], axis=1)
    kept = good[owner]
    return np.concatenate([triangles[kept], spokes]), polygons[np.concatenate([owner[kept], row[fan]])]


def _projected(points: FloatArray, row: IntArray, within: IntArray, sides: IntArray) -> tuple[FloatArray, FloatArray]:
    """Corners (N, 2) in the plane of their own polygon, where it is counter-clockwise, and the areas (K,)."""
    first = np.cumsum(sides) - sides
    local = points - points[first][row]
    following = np.where(within + 1 == sides[row], first[row], np.arange(len(row)) + 1)
    normal = np.add.reduceat(np.cross(local, local[following]), first, axis=0)
    length = np.linalg.norm(normal, axis=1)
    normal = np.where(length[:, None] > 0, normal, [0.0, 0.0, 1.0]) / np.where(length > 0, length, 1.0)[:, None]
    aside = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
    across = np.cross(aside, normal)
    across /= np.linalg.norm(across, axis=1)[:, None]
    up = np.cross(normal, across)
    return np.stack([_dot(local, across[row]), _dot(local, up[row])], axis=1), length / 2


def _delaunay(flat: FloatArray, row: IntArray, corner: IntArray) -> tuple[IntArray, IntArray]:
    """Corners (T, 3), counter-clockwise, and rows (T,) of the triangles that GEOS makes of the projected polygons."""
    shapes = shapely.polygons(shapely.linearrings(flat, indices=row))
    simple = shapely.is_valid(shapes)
    parts = np.full(len(shapes), None, dtype=object)
    parts[simple] = shapely.constrained_delaunay_triangles(shapes[simple])
    for index in np.flatnonzero(~simple):  # rings that touch themselves around a hole are still triangulated correctly
        try:
            parts[index] = shapely.constrained_delaunay_triangles(shapes[index])
        except shapely.GEOSException:
            continue
    triangles, owner = shapely.get_parts(parts, return_index=True)
    places = shapely.get_coordinates(triangles).reshape(-1, 4, 2)[:, :3]
    found = _corner_at(flat, row, corner, places.reshape(-1, 2), np.repeat(owner, 3)).reshape(-1, 3)
    clockwise = _signed_areas(places) < 0
    found[clockwise] = found[clockwise][:, ::-1]
    return found, owner


def _corner_at(flat: FloatArray, row: IntArray, corner: IntArray, places: FloatArray, owner: IntArray) -> IntArray:
    """The corner of polygon `owner` at each place, -1 for none: GEOS returns coordinates instead of indices."""
    asked = len(places)
    keys = [np.concatenate([owner, row]), np.concatenate([places[:, 0], flat[:, 0]])]
    keys.append(np.concatenate([places[:, 1], flat[:, 1]]))
    order = np.lexsort([*reversed(keys)])
    fresh = np.ones(len(order), dtype=bool)
    fresh[1:] = np.logical_or.reduce([key[order][1:] != key[order][:-1] for key in keys])
    group = np.empty(len(order), dtype=np.int64)
    group[order] = np.cumsum(fresh) - 1
    answer = np.full(len(order), -1, dtype=np.int64)
    answer[group[asked:][::-1]] = corner[::-1]
    found: IntArray = answer[group[:asked]]
    return found


def _covers(
    triangles: IntArray, owner: IntArray, flat: FloatArray, corner: IntArray, area: FloatArray, sides: IntArray
) -> BoolArray:
    """Polygons (K,) whose triangles have known corners and, together, the polygon's area and number of corners."""
    count = len(sides)
    place = np.empty(corner.max() + 1, dtype=np.int64)
    place[corner] = np.arange(len(corner))
    known = (triangles >= 0).all(axis=1)
    total = np.bincount(owner[known], np.abs(_signed_areas(flat[place[triangles[known]]])), count)
    whole = np.bincount(owner, known, count) == np.bincount(owner, minlength=count)
    good: BoolArray = whole & (area > 0) & (np.abs(total - area) <= 1e-6 * area)
    return good


def _signed_areas(triangles: FloatArray) -> FloatArray:
    """(T,) areas of plane triangles (T, 3, 2), positive where counter-clockwise."""
    first, second = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    areas: FloatArray = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / 2
    return areas


def _dot(first: FloatArray, second: FloatArray) -> FloatArray:
    products: FloatArray = np.einsum("ij,ij->i", first, second)
    return products
