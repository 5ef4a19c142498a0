"""Homographies: the perspective map between a flat rectangle and its photograph."""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, FloatArray


def square_to(corners: FloatArray) -> FloatArray:
    """(…, 3, 3) the homographies that map (0, 0), (1, 0), (1, 1), (0, 1) to four corners (…, 4, 2).

    Closed form of Heckbert, Fundamentals of Texture Mapping and Image Warping, 1989.
    """
    (x0, y0), (x1, y1), (x2, y2), (x3, y3) = (np.moveaxis(corners[..., n, :], -1, 0) for n in range(4))
    right_x, right_y, down_x, down_y = x1 - x2, y1 - y2, x3 - x2, y3 - y2
    skew_x, skew_y = x0 - x1 + x2 - x3, y0 - y1 + y2 - y3
    area = right_x * down_y - down_x * right_y
    area = np.where(area == 0, np.finfo(float).tiny, area)
    g = (skew_x * down_y - down_x * skew_y) / area
    h = (right_x * skew_y - skew_x * right_y) / area
    rows = [[x1 - x0 + g * x1, x3 - x0 + h * x3, x0], [y1 - y0 + g * y1, y3 - y0 + h * y3, y0], [g, h, np.ones_like(g)]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def projected(matrix: FloatArray, points: FloatArray) -> FloatArray:
    """(…, N, 2) images of points (N, 2) under homographies (…, 3, 3)."""
    homogeneous = np.column_stack([points, np.ones(len(points))]) @ np.swapaxes(matrix, -1, -2)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(homogeneous[..., :2] / homogeneous[..., 2:])


def is_clockwise(corners: FloatArray) -> BoolArray:
    """(…,) whether corners (…, 4, 2), y downwards, go around a convex quadrilateral clockwise."""
    side = np.roll(corners, -1, axis=-2) - corners
    following = np.roll(side, -1, axis=-2)
    turn = side[..., 0] * following[..., 1] - side[..., 1] * following[..., 0]
    return np.asarray((turn > 0).all(axis=-1))
