"""Lines of plastic as a mesh: an oval swept along each of them, closed at both ends."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..ragged import ranges, starts
from ..records import dataclass
from .strands import Strands, semi_axes

SIDES = 8
_LONGEST_MITRE = 2.0
"""Where a strand turns so sharply that its outer corner would reach farther, in half widths, it is cut in two tubes."""

_BLOCK_POINTS = 1 << 17


@dataclass(frozen=True)
class Rods:
    """K lines with N points in all, and the oval at each point.

    Attributes:
        points: (N, 3) mm.
        start: (K + 1,) int64, where each line's points start.
        across: (N,) mm, horizontal semi-axis.
        up: (N,) mm, vertical semi-axis.
    """

    points: FloatArray
    start: IntArray
    across: FloatArray
    up: FloatArray

    @staticmethod
    def of(laid: Strands) -> Rods:
        """The shape of strands."""
        across, up = semi_axes(laid.width, np.repeat(laid.height, np.diff(laid.start)), laid.roundness)
        return Rods(laid.points, laid.start, across, up)

    @staticmethod
    def joined(parts: list[Rods]) -> Rods:
        """All lines of several tables in one."""
        return Rods(
            points=np.concatenate([part.points for part in parts]),
            start=starts(np.concatenate([np.diff(part.start) for part in parts])),
            across=np.concatenate([part.across for part in parts]),
            up=np.concatenate([part.up for part in parts]),
        )

    def between(self, low: int, high: int) -> Rods:
        """The lines `low` to `high`, exclusive."""
        part = slice(int(self.start[low]), int(self.start[high]))
        start = self.start[low : high + 1] - self.start[low]
        return Rods(self.points[part], start, self.across[part], self.up[part])


@dataclass(frozen=True)
class Tubes:
    """A closed mesh of quads and fans, each tube apart from all others, normals outwards.

    Attributes:
        vertices: (SIDES · N, 3) mm, ring by ring.
        quads: (Q, 4) int64, the sides.
        caps: (2 T, SIDES) int64, the ends of T tubes.
    """

    vertices: FloatArray
    quads: IntArray
    caps: IntArray

    def triangles(self) -> IntArray:
        """(F, 3) all faces cut into triangles."""
        fans = [self.caps[:, [0, corner, corner + 1]] for corner in range(1, SIDES - 1)]
        return np.concatenate([self.quads[:, [0, 1, 2]], self.quads[:, [0, 2, 3]], *fans])


def count(rods: Rods) -> tuple[int, int]:
    """How many points and tubes `tubes` makes of lines."""
    first = _first_points(rods)
    return len(rods.points) + len(first) - len(rods.start) + 1, len(first)


def tubes(rods: Rods) -> Iterator[Tubes]:
    """The mesh in parts of about a hundred thousand points of center lines each, so that it need not fit the memory.

    The polygon that is swept has the area of the oval, and it is mitred at the points of the line: the volume is that
    which was extruded.
    """
    cut = np.flatnonzero(np.diff(rods.start[:-1] // _BLOCK_POINTS, prepend=-1))
    for low, high in zip(cut.tolist(), [*cut[1:].tolist(), len(rods.start) - 1], strict=True):
        yield _tubes(rods.between(low, high))


def _tubes(rods: Rods) -> Tubes:
    first = _first_points(rods)
    # A point at which a strand is cut is the last of one tube and the first of the next.
    joined = ~np.isin(first, rods.start[:-1])
    last = np.append(first[1:] - 1 + joined[1:], len(rods.points) - 1)
    counts = last - first + 1
    points = ranges(first, counts)
    start = starts(counts)
    arriving, leaving = _directions(rods.points[points], start)
    ahead = _unit(arriving + leaving)
    side = _unit(np.stack([-ahead[:, 1], ahead[:, 0], np.zeros(len(ahead))], axis=1))
    up = np.cross(ahead, side)
    across = rods.across[points] / np.maximum(np.einsum("ij,ij->i", ahead, arriving), 1 / _LONGEST_MITRE)
    turn = 2 * math.pi * (np.arange(SIDES) + 0.5) / SIDES
    wide = math.sqrt(2 * math.pi / (SIDES * math.sin(2 * math.pi / SIDES)))  # the polygon has the area of the oval
    ring = (
        np.cos(turn)[:, None] * wide * (across[:, None] * side)[:, None]
        + np.sin(turn)[:, None] * wide * (rods.up[points][:, None] * up)[:, None]
    )
    vertices = (rods.points[points][:, None] + ring).reshape(-1, 3)
    is_last = np.zeros(len(points), dtype=bool)
    is_last[start[1:] - 1] = True
    corner = np.arange(SIDES)
    following = (corner + 1) % SIDES
    here = np.flatnonzero(~is_last)[:, None] * SIDES
    quads = np.stack([here + corner, here + following, here + SIDES + following, here + SIDES + corner], axis=2)
    first_ring, last_ring = start[:-1, None] * SIDES + corner[::-1], (start[1:, None] - 1) * SIDES + corner
    return Tubes(vertices, quads.reshape(-1, 4), np.concatenate([first_ring, last_ring]))


def _first_points(rods: Rods) -> IntArray:
    """The points at which tubes begin: those of strands, and sharp turns."""
    arriving, leaving = _directions(rods.points, rods.start)
    # The mitre is 1 / cos(a / 2) for a turn by the angle a.
    sharp: BoolArray = np.einsum("ij,ij->i", arriving, leaving) < 2 / _LONGEST_MITRE**2 - 1
    sharp[rods.start[:-1]] = True
    sharp[rods.start[1:] - 1] = False
    return np.flatnonzero(sharp)


def _directions(points: FloatArray, start: IntArray) -> tuple[FloatArray, FloatArray]:
    """Unit vectors (N, 3) from the point before and to the next one; at the end of a line both are the one there is."""
    step = _unit(np.diff(points, axis=0))
    arriving, leaving = np.empty_like(points), np.empty_like(points)
    arriving[1:], leaving[:-1] = step, step
    arriving[start[:-1]] = leaving[start[:-1]]
    leaving[start[1:] - 1] = arriving[start[1:] - 1]
    return arriving, leaving


def _unit(vectors: FloatArray) -> FloatArray:
    length = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))[:, None]
    return np.where(length > 1e-12, vectors / np.maximum(length, 1e-12), (1.0, 0.0, 0.0))
