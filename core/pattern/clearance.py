"""How thick the material is behind each outline point, and how wide the air before it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import BoolArray, FloatArray, IntArray
from ..slicing.outlines import following, ranges, starts
from .along_loops import box, cross, dot, filtered, pairs, steps
from .grid import Bits, PointGrid

# Walls are looked for by so many points at a time.
BLOCK = 4
# Walls face each other where their normals point apart by more than this (cosine).
FACING = -0.3
# A block whose points lie this near to its chord is a straight piece of wall, mm.
STRAIGHT = 0.01
# What is found counts for so many points to both sides and goes over into what is beside it as smoothly.
EASING = 2


@dataclass(frozen=True)
class _Blocks:
    """Runs of points of a loop.

    Attributes:
        first: (B,) index of the first point.
        size: (B,) points.
        middle: (2, B) mm, one of the points.
        spread: mm, no point of a block is farther away from its middle.
        layer: (B,)
    """

    first: IntArray
    size: IntArray
    middle: FloatArray
    spread: float
    layer: IntArray


def gaps(
    points: FloatArray, normal: FloatArray, start: IntArray, layer: IntArray, inside: float, outside: float
) -> tuple[FloatArray, FloatArray]:
    """Distance to the opposite wall, inwards and outwards: twice the radius of the largest circle that fits there.

    The circle touches the wall at the point, lies on one side of it and reaches as far as no other wall. What is nearer
    to a point of a wall than to any other is left to that point, so lines that are moved by less than the radius of
    the circle there do not meet.

    Args:
        points: (2, N) mm, evenly spaced on closed loops.
        normal: (2, N) outward unit normals.
        start: (M + 1,) offsets of the loops.
        layer: (M,) layer of each loop.
        inside: mm; what is farther away inwards is not looked for.
        outside: mm, the same outwards; 0 for nothing.

    Returns:
        (N,) thickness of the material, at most `inside`, and (N,) width of the air gap, at most `outside`, mm.
    """
    thickness, clearance = np.full(points.shape[1], inside), np.full(points.shape[1], outside)
    blocks = _blocks(points, start, layer)
    point, block = _near(points, normal, blocks, inside, outside)
    if not len(point):
        return thickness, clearance
    begin, end, point, piece = _pieces(points, following(start), blocks, point, block)
    point, width, outwards = _across(points, normal, begin, end, point, piece)
    np.minimum.at(thickness, point[~outwards], width[~outwards])
    if outside:
        np.minimum.at(clearance, point[outwards], width[outwards])
        clearance = _eased(clearance, start)
    return _eased(thickness, start), clearance


def _blocks(points: FloatArray, start: IntArray, layer: IntArray) -> _Blocks:
    count = np.diff(start)
    number = -(-count // BLOCK)
    loop = np.repeat(np.arange(len(count)), number)
    first = start[loop] + BLOCK * ranges(np.zeros_like(count), number)
    size = np.minimum(start[loop + 1] - first, BLOCK)
    step = steps(points, start)
    spread = float(np.sqrt(dot(step, step).max(initial=0.0))) * (BLOCK - BLOCK // 2)
    return _Blocks(first, size, points.take(first + size // 2, axis=1), spread, layer[loop])


def _near(
    points: FloatArray, normal: FloatArray, blocks: _Blocks, inside: float, outside: float
) -> tuple[IntArray, IntArray]:
    """Pairs of a point and a block that may reach into a circle as large as is looked for at the point."""
    own, facing = _directions(normal)
    held, wanted = np.bitwise_or.reduceat(own, blocks.first), np.bitwise_or.reduceat(facing, blocks.first)
    middle, spread = pairs(blocks.middle), blocks.spread
    around = max(inside, outside) + 2 * spread
    grid = PointGrid(middle, blocks.layer, around / 2)
    faced = np.flatnonzero(wanted & grid.bits_around(held, rings=2)) if len(middle) else blocks.first
    other, group = grid.candidates(middle.take(faced, axis=0), blocks.layer[faced], rings=2)
    this = np.repeat(faced, np.diff(group))
    kept = np.flatnonzero(wanted[this] & held[other])
    this, other = this[kept], other[kept]
    away = blocks.middle.take(this, axis=1) - blocks.middle.take(other, axis=1)
    kept = np.flatnonzero(dot(away, away) <= around**2)
    this, other = this[kept], other[kept]
    # The same for each point of the blocks.
    size = blocks.size[this]
    point, other = ranges(blocks.first[this], size), np.repeat(other, size)
    kept = np.flatnonzero(facing[point] & held[other])
    point, other = point[kept], other[kept]
    away = blocks.middle.take(other, axis=1) - points.take(point, axis=1)
    along = dot(away, normal.take(point, axis=1))
    # The circle's middle is half its width away from the point.
    width = np.where(along > 0, outside, inside)
    kept = np.flatnonzero(dot(away, away) - np.abs(along) * width <= spread * (width + spread))
    return point[kept], other[kept]


def _directions(normal: FloatArray) -> tuple[Bits, Bits]:
    """As bits, which of twelve directions each normal (2, N) lies in, and in which lie normals that may face it."""
    turn = np.pi / 12 * np.arange(1, 24, 2)
    middle = np.stack([np.cos(turn), np.sin(turn)])
    number, own = _direction(middle), _direction(normal)
    may_face = middle.T @ middle < np.cos(np.arccos(FACING) - np.pi / 6)
    bit, facing = (1 << np.arange(16)).astype(np.uint16), np.zeros(16, dtype=np.uint16)
    facing[number] = may_face @ bit[number]
    return bit[own], facing[own]


def _direction(normal: FloatArray) -> NDArray[np.uint8]:
    """(N,) 0 to 15: unit vectors turn by 30 degrees from one half of a coordinate to the next."""
    half = np.minimum((2 * normal + 2).astype(np.uint8), 3)
    return np.asarray(4 * half[0] + half[1])


def _pieces(
    points: FloatArray, after: IntArray, blocks: _Blocks, point: IntArray, block: IntArray
) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
    """Blocks as straight pieces of wall: a block is one, or each of its segments if it is bent.

    Returns:
        Both ends (2, P) of each piece, and (C,) points paired with (C,) pieces.
    """
    seen = np.zeros(len(blocks.first), dtype=bool)
    seen[block] = True
    first, size = blocks.first[seen], blocks.size[seen]
    last, each = after[first + size - 1], np.repeat(np.arange(len(first)), size)
    chord = points.take(last, axis=1) - points.take(first, axis=1)
    off = cross(points.take(ranges(first, size), axis=1) - points.take(first[each], axis=1), chord.take(each, axis=1))
    farthest = np.maximum.reduceat(np.abs(off), starts(size)[:-1])
    straight = farthest < STRAIGHT * np.sqrt(dot(chord, chord))
    count = np.where(straight, 1, size)
    begin = ranges(first, count)
    end = np.where(np.repeat(straight, count), np.repeat(last, count), after[begin])
    number = (np.cumsum(seen) - 1)[block]
    count, piece = count[number], starts(count)[number]
    return points.take(begin, axis=1), points.take(end, axis=1), np.repeat(point, count), ranges(piece, count)


def _across(
    points: FloatArray, normal: FloatArray, begin: FloatArray, end: FloatArray, point: IntArray, piece: IntArray
) -> tuple[IntArray, FloatArray, BoolArray]:
    """Widths of the circles that touch the wall at a point and a straight piece of wall that faces it.

    Returns:
        (C,) the point of each, (C,) mm, (C,) whether the circle lies outwards.
    """
    piece_length = np.sqrt(dot(end - begin, end - begin))
    direction = (end - begin) / np.maximum(piece_length, 1e-12)
    # The piece's own normal is (y, -x) of its direction.
    turn = cross(direction.take(piece, axis=1), normal.take(point, axis=1))
    facing = np.flatnonzero(turn > -FACING)
    point, piece, turn = point[facing], piece[facing], turn[facing]
    along, out = direction.take(piece, axis=1), normal.take(point, axis=1)
    away = begin.take(piece, axis=1) - points.take(point, axis=1)
    # The line through the piece is as far away as this, before or behind the point.
    off = cross(away, along)
    outwards = off < 0
    radius = np.abs(off) / (1 + turn)
    out = np.where(outwards, out, -out)
    touching = np.clip(radius * dot(out, along) - dot(away, along), 0.0, piece_length[piece])
    away += touching * along
    reached = dot(away, out)
    return point, np.where(reached > 1e-9, dot(away, away) / np.maximum(reached, 1e-9), np.inf), outwards


def _eased(width: FloatArray, start: IntArray) -> FloatArray:
    """The least of the neighbours, averaged over as many of them: nowhere more, and without steps."""
    for _ in range(EASING):
        width = _least_beside(width, start)
    return filtered(width, start, box(EASING))


def _least_beside(values: FloatArray, start: IntArray) -> FloatArray:
    """(N,) the least of each value and those before and after it."""
    first, last, least = start[:-1], start[1:] - 1, values.copy()
    np.minimum(least[1:], values[:-1], out=least[1:])
    np.minimum(least[:-1], values[1:], out=least[:-1])
    # Not those of the loops before and after.
    least[first] = np.minimum(np.minimum(values[first], values[first + 1]), values[last])
    least[last] = np.minimum(np.minimum(values[last], values[last - 1]), values[first])
    return least
