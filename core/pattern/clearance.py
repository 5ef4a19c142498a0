"""How thick the material is behind each outline point, and how wide the air before it."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray, IntArray
from ..slicing.outlines import starts
from .grid import PointGrid

# Only every so many points are looked at: thickness changes slowly against their spacing.
STRIDE = 4
# Walls face each other where their normals point apart by more than this (cosine).
FACING = -0.3


def gaps(
    points: FloatArray, normal: FloatArray, start: IntArray, layer: IntArray, reach: float
) -> tuple[FloatArray, FloatArray]:
    """Distance to the opposite wall, inwards and outwards.

    Args:
        points: (N, 2) mm, evenly spaced on closed loops.
        normal: (N, 2) outward unit normals.
        start: (M + 1,) offsets of the loops.
        layer: (M,) layer of each loop.
        reach: mm; what is farther away is not looked for.

    Returns:
        (N,) thickness of the material and (N,) width of the air gap in mm, at most `reach`.
    """
    count = np.diff(start)
    coarse_count = -(-count // STRIDE)
    coarse_start = starts(coarse_count)
    loop = np.repeat(np.arange(len(count)), coarse_count)
    index = start[loop] + (np.arange(coarse_start[-1]) - coarse_start[loop]) * STRIDE
    inward, outward = _facing_distance(points[index], normal[index], layer[loop], reach)
    return tuple(_refined(values, coarse_start, start) for values in (inward, outward))  # type: ignore[return-value]


def _facing_distance(
    points: FloatArray, normal: FloatArray, layer: IntArray, reach: float
) -> tuple[FloatArray, FloatArray]:
    other, group = PointGrid(points, layer, reach / 2).candidates(points, layer, rings=2)
    this = np.repeat(np.arange(len(points)), np.diff(group))
    facing = np.einsum("ij,ij->i", normal.take(this, axis=0), normal.take(other, axis=0)) < FACING
    this, other = this[facing], other[facing]
    away = points.take(other, axis=0) - points.take(this, axis=0)
    near = np.flatnonzero(np.einsum("ij,ij->i", away, away) <= reach**2)
    this, away = this[near], away.take(near, axis=0)
    outwards = normal.take(this, axis=0)
    along = np.einsum("ij,ij->i", away, outwards)
    sideways = np.abs(away[:, 0] * outwards[:, 1] - away[:, 1] * outwards[:, 0])
    # Straight across is what counts; a point of the other wall is at most half a stride off to the side.
    across = sideways <= np.maximum(0.5 * np.abs(along), 0.3 * reach)
    inward, outward = np.full(len(points), reach), np.full(len(points), reach)
    np.minimum.at(inward, this[across & (along < 0)], -along[across & (along < 0)])
    np.minimum.at(outward, this[across & (along > 0)], along[across & (along > 0)])
    return inward, outward


def _refined(values: FloatArray, coarse_start: IntArray, start: IntArray) -> FloatArray:
    """Coarse values at every point again: the least of the neighbours, then linear in between."""
    count, coarse_count = np.diff(start), np.diff(coarse_start)
    loop = np.repeat(np.arange(len(count)), coarse_count)
    local = np.arange(coarse_start[-1]) - coarse_start[loop]
    least = np.minimum(
        np.minimum(values, values[coarse_start[loop] + (local + 1) % coarse_count[loop]]),
        values[coarse_start[loop] + (local - 1) % coarse_count[loop]],
    )
    fine_loop = np.repeat(np.arange(len(count)), count)
    place = (np.arange(start[-1]) - start[fine_loop]) / STRIDE
    before = np.minimum(place.astype(np.int64), coarse_count[fine_loop] - 1)
    share = np.minimum(place - before, 1.0)
    begin = coarse_start[fine_loop]
    after = (before + 1) % coarse_count[fine_loop]
    return np.asarray(least[begin + before] * (1 - share) + least[begin + after] * share)
