"""Outlines as evenly spaced points, each with the face and the UVs of the segment that it lies on."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray, IntArray
from ..ragged import starts, sums
from ..records import dataclass
from ..slicing.outlines import Outlines
from .along_loops import dot, rows, steps

LEAST_POINTS = 8
"""Least number of points of a loop."""


@dataclass(frozen=True)
class EvenPoints:
    """Where evenly spaced points lie on the S segments of M outlines.

    Attributes:
        start: (M + 1,) offsets of the loops' new points.
        held: (S + 1,) number of new points on all segments before.
        begin: (S,) where each segment begins, in units of the spacing, counted on over all loops.
        share: (S,) of the segment between one new point and the next.
        corner: (2, S) mm, where it begins.
        along: (2, S) mm, from there to its end.
    """

    start: IntArray
    held: IntArray
    begin: FloatArray
    share: FloatArray
    corner: FloatArray
    along: FloatArray


def even_points(outlines: Outlines, step: float, block: int) -> EvenPoints:
    """Points on each outline no farther apart than `step` mm, in whole blocks, at least `LEAST_POINTS` a loop.

    Args:
        outlines: M loops.
        step: mm.
        block: the number of points of every loop is a multiple of this.
    """
    corner = rows(outlines.points)
    along = steps(corner, outlines.start)
    length = np.sqrt(dot(along, along))
    loop_length = sums(length, outlines.start)
    count = block * np.ceil(np.maximum(loop_length / step, LEAST_POINTS) / block).astype(np.int64)
    start, last = starts(count), outlines.start[1:] - 1
    length *= np.repeat(count / np.maximum(loop_length, 1e-9), outlines.count)
    end = np.cumsum(length)
    before_loop = end[outlines.start[:-1]] - length[outlines.start[:-1]]
    end += np.repeat(start[:-1] - before_loop, outlines.count)
    # Number of points before each segment's end; rounding must not move one to another loop.
    held = np.minimum(np.ceil(end).astype(np.int64), np.repeat(start[1:], outlines.count))
    held[last] = start[1:]
    share = 1 / np.maximum(length, 1e-12)
    return EvenPoints(start, np.concatenate([[0], held]), end - length, share, corner, along)


def resampled(outlines: Outlines, even: EvenPoints, loops: slice, face: IntArray, carried: FloatArray) -> FloatArray:
    """The even points of some consecutive loops.

    Args:
        outlines: all of them.
        even: from `even_points`.
        loops: those asked for.
        face: (N,) output, the face of each.
        carried: (C, N) output, the values that it carries.

    Returns:
        (2, N) mm.
    """
    among = slice(outlines.start[loops.start], outlines.start[loops.stop])
    begin, end = even.start[loops.start], even.start[loops.stop]
    segment = np.repeat(np.arange(among.stop - among.start), np.diff(even.held[among.start : among.stop + 1]))
    share = np.arange(begin, end) - even.begin[among].take(segment)
    share *= even.share[among].take(segment)
    np.clip(share, 0.0, 1.0, out=share)
    points = np.empty((2, end - begin))
    for row, corner, along in zip(points, even.corner[:, among], even.along[:, among], strict=True):
        np.multiply(along.take(segment), share, out=row)
        row += corner.take(segment)
    columns = outlines.carried[among].transpose(2, 1, 0)
    for row, ends in zip(carried, columns, strict=True):
        np.multiply((ends[1] - ends[0]).take(segment), share, out=row)
        row += ends[0].take(segment)
    face[:] = outlines.face[among].take(segment)
    return points
