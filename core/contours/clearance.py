"""Thickness of the material behind each outline point, and width of the air gap in front of it."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model import BoolArray, FloatArray, IntArray
from ..parallel import runs_of_layers
from ..ragged import following, ranges, starts
from .along_loops import box, cross, dot, filtered
from .grid import PointGrid

BLOCK = 4
"""Points of a block, as which walls are looked for; all loops are made of whole blocks."""
# Walls face each other where their normals point apart by more than this (cosine).
FACING = -0.3
# A block whose points lie this near to its chord is a straight piece of wall, mm.
STRAIGHT = 0.01
# Points to both sides for which what is found counts too, and over which it is averaged.
EASING = 2
# Most cells for each block for which a table of all cells is kept.
CELLS_A_BLOCK = 64
# Blocks that face others that are worked on at a time.
BLOCKS_AT_ONCE = 1 << 13

Bits = NDArray[np.uint16]


def wall_distances(
    points: FloatArray, step: float, normal: FloatArray, start: IntArray, layer: IntArray, inside: float, outside: float
) -> tuple[FloatArray, FloatArray]:
    """Distance to the opposite wall, inwards and outwards: twice the radius of the largest circle that fits there.

    The circle touches the wall at the point, lies on one side of it and contains no other wall. Its middle is nearer
    to that point than to any other one, so lines that are moved by less than the circles' radii do not meet.

    Args:
        points: (2, N) mm, evenly spaced on closed loops of whole blocks.
        step: mm, from point to point, at most.
        normal: (2, N) outward unit normals.
        start: (M + 1,) offsets of the loops.
        layer: (M,) layer of each loop.
        inside: mm; what is farther away inwards is not looked for.
        outside: mm, the same outwards; 0 for nothing.

    Returns:
        (N,) thickness of the material, at most `inside`, and (N,) width of the air gap, at most `outside`, mm.
    """
    thickness, clearance = np.full(points.shape[1], inside), np.full(points.shape[1], outside)
    # No point of a block is farther away from its middle than this.
    spread = step * (BLOCK - BLOCK // 2)
    blocks, cell = start // BLOCK, max(inside, outside) / 2 + spread
    block_layer = np.repeat(layer, np.diff(blocks))
    held, faced = _facing_blocks(points, normal, start, layer, cell)
    faced_before = np.searchsorted(faced, blocks)
    for first, last in runs_of_layers(layer, faced_before, BLOCKS_AT_ONCE):
        some = faced[faced_before[first] : faced_before[last]] - blocks[first]
        if not len(some):
            continue
        part, own = slice(start[first], start[last]), slice(blocks[first], blocks[last])
        near_points, near_normal = points[:, part], normal[:, part]
        point, block = _near(near_points, near_normal, block_layer[own], held[own], some, spread, inside, outside)
        begin, end, point, piece = _pieces(near_points, following(start[first : last + 1] - part.start), point, block)
        point, width, outwards = _across(near_points, near_normal, begin, end, point, piece)
        np.minimum.at(thickness[part], point[~outwards], width[~outwards])
        if outside:
            np.minimum.at(clearance[part], point[outwards], width[outwards])
    _ease(thickness, start, inside)
    if outside:
        _ease(clearance, start, outside)
    return thickness, clearance


def _facing_blocks(
    points: FloatArray, normal: FloatArray, start: IntArray, layer: IntArray, cell: float
) -> tuple[Bits, IntArray]:
    """(B,) directions of the normals of each block, and (F,) the blocks that face another one.

    Args:
        points: (2, N) mm, in blocks.
        normal: (2, N)
        start: (M + 1,) offsets of the loops.
        layer: (M,) of each loop.
        cell: mm, see `_faced`.
    """
    blocks = start // BLOCK
    held, faced = np.empty(blocks[-1], dtype=np.uint16), [np.zeros(0, dtype=np.int64)]
    for first, last in runs_of_layers(layer, blocks, BLOCKS_AT_ONCE):
        part, own = slice(start[first], start[last]), slice(blocks[first], blocks[last])
        held[own] = _directions(normal[:, part])
        own_layer = np.repeat(layer[first:last], np.diff(blocks[first : last + 1]))
        faced.append(own.start + _faced(points[:, part][:, BLOCK // 2 :: BLOCK], own_layer, held[own], cell))
    return held, np.concatenate(faced)


def _near(
    points: FloatArray,
    normal: FloatArray,
    layer: IntArray,
    held: Bits,
    faced: IntArray,
    spread: float,
    inside: float,
    outside: float,
) -> tuple[IntArray, IntArray]:
    """Pairs of a point and a block of points that may reach into the largest circle looked for at that point.

    Args:
        points: (2, N) mm, in blocks.
        normal: (2, N)
        layer: (B,) of each block.
        held: (B,) directions of its normals.
        faced: (F,) blocks that are looked at.
        spread: mm, no point of a block is farther away from its middle.
        inside: mm, the circles' widths.
        outside: mm.
    """
    middle, held = points[:, BLOCK // 2 :: BLOCK].take(faced, axis=1), held[faced]
    wanted = _facing().take(held)
    grid = PointGrid(middle.T, layer[faced], max(inside, outside) / 2 + spread)
    other, group = grid.candidates(middle.T, layer[faced], rings=2)
    this = np.repeat(np.arange(len(faced)), np.diff(group))
    kept = np.flatnonzero(wanted.take(this) & held.take(other))
    this, other = this.take(kept), other.take(kept)
    points, normal = (rows.reshape(2, -1, BLOCK).take(faced, axis=1) for rows in (points, normal))
    found = [_reached(points - normal * (inside / 2), inside / 2 + spread, middle, this, other)]
    if outside:
        found.append(_reached(points + normal * (outside / 2), outside / 2 + spread, middle, this, other))
    this, number, other = (np.concatenate(column) for column in zip(*found, strict=True))
    return BLOCK * faced.take(this) + number, faced.take(other)


def _of_blocks(most: np.ufunc, values: NDArray[Any]) -> NDArray[Any]:
    """(B,) the greatest value in each block."""
    return np.asarray(most.reduce([values[number::BLOCK] for number in range(BLOCK)]))


def _reached(
    center: FloatArray, radius: float, middle: FloatArray, this: IntArray, other: IntArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Which blocks reach into the circles of which points.

    Args:
        center: (2, B, BLOCK) mm, of each point's circle.
        radius: mm, of them all.
        middle: (2, B) mm, of the blocks.
        this: (C,) blocks.
        other: (C,) blocks that may reach into one of their circles.

    Returns:
        (P,) blocks, (P,) number of the point in each, and (P,) the other block.
    """
    usual = center[:, :, BLOCK // 2].copy()
    off = center - usual[:, :, None]
    apart = np.sqrt(_of_blocks(np.maximum, dot(off, off).ravel()))
    away = middle.take(other, axis=1) - usual.take(this, axis=1)
    kept = np.flatnonzero(dot(away, away) <= (radius + apart.take(this)) ** 2)
    this, other = this.take(kept), other.take(kept)
    off = middle.take(other, axis=1)[:, :, None] - center.take(this, axis=1)
    pair, number = np.nonzero(dot(off, off) <= radius**2)
    return this[pair], number, other[pair]


def _faced(middle: FloatArray, layer: IntArray, held: Bits, cell: float) -> IntArray:
    """Blocks that face another one within two square cells; some that do not may be among them.

    Facing is mutual, so a block that faces none is not looked for by others either.

    Args:
        middle: (2, B) mm.
        layer: (B,)
        held: (B,) directions of its normals.
        cell: mm.
    """
    if not len(layer):
        return layer
    wanted = _facing().take(held)
    column, row = ((along - along.min()) * (1 / cell) for along in middle)
    columns, rows = int(column.max()) + 3, int(row.max()) + 3
    key = ((layer - layer[0]) * rows + row.astype(np.int64)) * columns + column.astype(np.int64)
    cells = int(key[-1]) + rows * columns
    if cells > CELLS_A_BLOCK * len(layer):
        return np.flatnonzero(wanted & np.bitwise_or.reduce(held))
    around = np.zeros(cells, dtype=held.dtype)
    np.bitwise_or.at(around, key, held)
    for neighbor in (1, columns):
        own = around.copy()
        for away in (neighbor, 2 * neighbor):
            around[away:] |= own[:-away]
            around[:-away] |= own[away:]
    return np.flatnonzero(wanted & around.take(key))


def _directions(normal: FloatArray) -> Bits:
    """(B,) as bits, which of twelve directions the normals (2, N) of each block lie in."""
    bits = np.left_shift(np.uint16(1), _direction(normal), dtype=np.uint16).view(np.uint64)
    # The four points of a block side by side in 64 bits.
    bits |= bits >> np.uint64(32)
    return (bits | bits >> np.uint64(16)).astype(np.uint16)


@cache
def _facing() -> Bits:
    """(65536,) for each set of directions, as bits, the set of directions that may face one of them."""
    turn = np.pi / 12 * np.arange(1, 24, 2)
    middle = np.stack([np.cos(turn), np.sin(turn)])
    may_face = middle.T @ middle < np.cos(np.arccos(FACING) - np.pi / 6)
    number, facing = _direction(middle), np.zeros(1 << 16, dtype=np.uint16)
    for direction, others in zip(number.tolist(), may_face @ (1 << number.astype(np.int64)), strict=True):
        facing.reshape(-1, 2, 1 << direction)[:, 1] |= np.uint16(others)
    return facing


def _direction(normal: FloatArray) -> NDArray[np.uint8]:
    """(N,) 0 to 15: unit vectors turn by 30 degrees from one half of a coordinate to the next."""
    half = (normal >= -0.5).view(np.uint8) + (normal >= 0).view(np.uint8) + (normal >= 0.5).view(np.uint8)
    return np.asarray(4 * half[0] + half[1])


def _pieces(
    points: FloatArray, after: IntArray, point: IntArray, block: IntArray
) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
    """Blocks as straight pieces of wall: a block is one, or each of its segments if it is bent.

    Returns:
        Both ends (2, P) of each piece, and (C,) points paired with (C,) pieces.
    """
    seen = np.zeros(points.shape[1] // BLOCK, dtype=bool)
    seen[block] = True
    corner = BLOCK * np.flatnonzero(seen)[:, None] + np.arange(BLOCK)
    first, last = corner[:, 0], after[corner[:, -1]]
    origin = points.take(first, axis=1)
    chord = points.take(last, axis=1) - origin
    off = cross(points.take(corner, axis=1) - origin[:, :, None], chord[:, :, None])
    straight = np.abs(off).max(axis=1) < STRAIGHT * np.sqrt(dot(chord, chord))
    count = np.where(straight, 1, BLOCK)
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
    point, piece, turn = point.take(facing), piece.take(facing), turn.take(facing)
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


def _ease(width: FloatArray, start: IntArray, most: float) -> None:
    """Widths (N,) in place: the least of the neighbors, averaged over as many of them, without steps, nowhere more."""
    narrow = np.flatnonzero(np.minimum.reduceat(width, start[:-1]) < most) if len(width) else start[:0]
    count = np.diff(start)[narrow]
    point, own = ranges(start[narrow], count), starts(count)
    least = width[point]
    for _ in range(EASING):
        least = _least_beside(least, own)
    width[point] = filtered(least, own, box(EASING))


def _least_beside(values: FloatArray, start: IntArray) -> FloatArray:
    """(N,) the least of each value and those before and after it."""
    first, last, least = start[:-1], start[1:] - 1, values.copy()
    np.minimum(least[1:], values[:-1], out=least[1:])
    np.minimum(least[:-1], values[1:], out=least[:-1])
    # Not those of the loops before and after.
    least[first] = np.minimum(np.minimum(values[first], values[first + 1]), values[last])
    least[last] = np.minimum(np.minimum(values[last], values[last - 1]), values[first])
    return least
