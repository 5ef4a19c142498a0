"""Poly lines made ready for a renderer that draws smooth curves through their points and leaves their ends open."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray, IntArray
from ..ragged import starts

_PIECE = 1.2  # radii between points, at most
_CAP = ((0.6, 0.8), (0.9, 0.44), (1.0, 0.02))  # radii beyond an end, and the share of the radius there


def for_smooth_curves(
    points: FloatArray, counts: IntArray, radius: FloatArray
) -> tuple[FloatArray, IntArray, FloatArray]:
    """More points, so that a curve through them keeps to the line and closes at its ends.

    A Catmull-Rom curve overshoots where a long step follows a short one; steps of less than about a radius leave it
    no room. Round caps are made of points beyond the ends with ever smaller radii.

    Args:
        points: (N, 3).
        counts: (K,) points of each line.
        radius: (N,) in the unit of the points.

    Returns:
        Points, counts and radii as they were given.
    """
    if not len(points):
        return points, counts, radius
    start = starts(counts)
    step = np.zeros_like(points)
    step[1:] = np.diff(points, axis=0)
    step[start[:-1]] = 0.0
    pieces = np.maximum(np.ceil(np.linalg.norm(step, axis=1) / (_PIECE * radius)), 1).astype(np.int64)
    source = np.repeat(np.arange(len(points)), pieces)
    ends = np.cumsum(pieces)
    left = ((ends[source] - 1 - np.arange(len(source))) / pieces[source])[:, None]
    dense = points[source] - left * step[source]
    wide = radius[source] + left[:, 0] * (radius[np.maximum(source - 1, 0)] - radius[source])
    start = np.concatenate([[0], ends])[start]
    return _capped(dense, start, wide)


def _capped(points: FloatArray, start: IntArray, radius: FloatArray) -> tuple[FloatArray, IntArray, FloatArray]:
    first, last = start[:-1], start[1:] - 1
    several = last > first
    outwards = points[first] - points[np.where(several, first + 1, first)]
    onwards = points[last] - points[np.where(several, last - 1, last)]
    places, before = [], []
    # The end of one line and the beginning of the next are inserted at the same place, in this order.
    for end, away, at, caps in ((last, onwards, last + 1, _CAP), (first, outwards, first, _CAP[::-1])):
        length = np.linalg.norm(away, axis=1)[:, None]
        unit = np.where(length > 0, away / np.maximum(length, 1e-12), (1.0, 0.0, 0.0))
        places += [(points[end] + share * radius[end, None] * unit, radius[end] * thin) for share, thin in caps]
        before += [at] * len(caps)
    where = np.concatenate(before)
    return (
        np.insert(points, where, np.concatenate([place for place, _ in places]), axis=0),
        np.diff(start) + 2 * len(_CAP),
        np.insert(radius, where, np.concatenate([thin for _, thin in places])),
    )
