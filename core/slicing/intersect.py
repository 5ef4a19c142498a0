"""Triangles × planes → directed segments, all layers at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model import FloatArray, IntArray, TriangleMesh
from ..pattern.chunks import in_chunks
from ..texture.islands import complex_uv
from .edges import faces_beyond
from .outlines import starts

_BEFORE = np.array([2, 0, 1])  # the corner before each one of a face


@dataclass(frozen=True)
class Segments:
    """S segments, solid on their left where the mesh's normals point outwards.

    A mesh edge is named by the corner of a face that it starts from: 3 f + k leads from corner k of face f to the next.

    Attributes:
        mesh: F faces.
        planes: (L,) mm, increasing.
        layer: (S,) int64.
        tail: (S,) int64, the edge that the segment starts on.
        head: (S,) int64, the edge of the same face that it ends on.
        successor: (S,) int64, the segment that starts where each one ends, in the face beyond; -1 where none does.
    """

    mesh: TriangleMesh
    planes: FloatArray
    layer: IntArray
    tail: IntArray
    head: IntArray
    successor: IntArray

    @property
    def points(self) -> FloatArray:
        """(S, 2, 2) mm, both ends."""
        plane = self.planes[self.layer]
        ends = [cut_edges(self.mesh.faces, *columns(self.mesh), edge, plane)[0] for edge in (self.tail, self.head)]
        return np.stack(ends, axis=1).view(np.float64).reshape(-1, 2, 2)


@dataclass(frozen=True)
class Crossings:
    """Which layers cut each face through which of its edges: K spans of layers, those of a face in a row.

    Attributes:
        mesh: F faces.
        planes: (L,) mm, increasing.
        first: (K,) int64, the lowest layer of each span.
        end: (K,) int64, the layer above the span.
        faces: (R,) int64, the only ones that are counted by what follows, None for all.
        tail: (K,) int64, the edge that the cuts start on, see `Segments`.
        head: (K,) int64, the edge that they end on.
        beyond: (K,) int64, the face on the other side of that edge, -1 for none.
    """

    mesh: TriangleMesh
    planes: FloatArray
    first: IntArray
    end: IntArray
    faces: IntArray | None
    tail: IntArray
    head: IntArray
    beyond: IntArray

    def between(self, low: int, high: int) -> Crossings:
        """What is cut by the layers from `low` to the one before `high`."""
        some = np.flatnonzero((self.first < high) & (self.end > low))
        first, end = np.maximum(self.first[some], low), np.minimum(self.end[some], high)
        edges = (column[some] for column in (self.tail, self.head, self.beyond))
        return Crossings(self.mesh, self.planes, first, end, self.faces, *edges)

    def segments(self) -> Segments:
        """The cuts, face by face and upwards in each."""
        count = self.end - self.first
        # The cuts of a face stand in a row, so the one that goes on is found by the face beyond and the layer.
        face, begin = self.tail // 3, starts(count)[:-1] - self.first
        base = np.zeros(len(self.mesh.faces if self.faces is None else self.faces), dtype=np.int64)
        base[face] = begin
        going_on = np.where(self.beyond < 0, -1 - len(self.planes), base.take(self.beyond))
        layer = np.repeat(-begin, count)
        layer += np.arange(len(layer))
        successor = np.repeat(going_on, count)
        successor += layer
        if (self.beyond < 0).any():
            np.maximum(successor, -1, out=successor)
        shift = 0 if self.faces is None else 3 * (self.faces.take(face) - face)
        tail, head = (np.repeat(edge + shift, count) for edge in (self.tail, self.head))
        return Segments(self.mesh, self.planes, layer, tail, head, successor)


def crossings(mesh: TriangleMesh, planes: FloatArray) -> Crossings:
    """Find the planes that pass through each face.

    A vertex exactly on a plane counts as above it. With that rule each face is crossed through exactly two of its
    edges or not at all, whatever touches the plane, so loops stay closed without any special case; coplanar facets
    and on-plane edges simply fall to one side.

    Args:
        mesh: F faces.
        planes: (L,) mm, increasing.
    """
    level = np.searchsorted(planes, mesh.vertices[:, 2].copy(), side="right").astype(np.int32)
    (levels,) = in_chunks(lambda faces: (np.asarray(level.take(faces)),), mesh.faces)
    faces, some = mesh.faces, np.flatnonzero((levels[:, 0] != levels[:, 1]) | (levels[:, 1] != levels[:, 2]))
    few = len(some) < len(faces) / 2
    if few:
        faces, levels = faces.take(some, axis=0), levels.take(some, axis=0)

    def chunk(levels: NDArray[np.int32], row: IntArray) -> tuple[IntArray, ...]:
        """First and end layer, tail and head of the spans of some faces."""
        # Three sorted by hand, with the number of the corner in the last bits.
        a, b, c = (4 * levels[:, k] + k for k in range(3))
        a, b = np.minimum(a, b), np.maximum(a, b)
        lowest, middle, highest = np.minimum(a, c), np.maximum(a, np.minimum(b, c)) >> 2, np.maximum(b, c)
        # Below its middle corner a face is cut around its lowest one, above it around its highest one. A cut starts on
        # the edge that leads down and ends on the one that leads up.
        low, high = lowest & 3, highest & 3
        first, end = _alternating(lowest >> 2, middle), _alternating(middle, highest >> 2)
        tail = _alternating(3 * row + _BEFORE.take(low), 3 * row + high)
        head = _alternating(3 * row + low, 3 * row + _BEFORE.take(high))
        there = np.flatnonzero(first < end)
        return first.take(there), end.take(there), tail.take(there), head.take(there)

    first, end, tail, head = in_chunks(chunk, levels, np.arange(len(faces)))
    beyond = faces_beyond(faces, levels, len(mesh.vertices)).take(head)
    return Crossings(mesh, planes, first, end, some if few else None, tail, head, beyond)


def _alternating(one: IntArray, other: IntArray) -> IntArray:
    """(2N,) one of the first, one of the second and so on."""
    both = np.empty(2 * len(one), dtype=one.dtype)
    both[0::2], both[1::2] = one, other
    return both


def intersect(mesh: TriangleMesh, planes: FloatArray) -> Segments:
    """Cut every face with every plane that passes through it; see `crossings`."""
    return crossings(mesh, planes).segments()


def columns(mesh: TriangleMesh) -> tuple[NDArray[np.complex128], FloatArray]:
    """(V,) x + iy and z of the vertices: numbers in one piece are read several times as fast as short rows."""
    return complex_uv(mesh.vertices[:, :2]), mesh.vertices[:, 2].copy()


def cut_edges(
    faces: IntArray, place: NDArray[np.complex128], height: FloatArray, edge: IntArray, plane: FloatArray
) -> tuple[NDArray[np.complex128], FloatArray, FloatArray]:
    """Where planes meet the edges that lead from some corners (N,) to the next ones, see `columns`.

    Returns:
        (N,) x + iy, the same to the last digit for all faces of an edge; (N,) the share of the way from corner to
        corner, and (N,) the other way round.
    """
    begin, end = faces.take(edge), faces.take(following_corner(edge))
    low, high = np.minimum(begin, end), np.maximum(begin, end)
    base = height.take(low)
    share = (plane - base) / (height.take(high) - base)
    rest, forwards = 1 - share, begin < end
    return between(place, low, high, share), np.where(forwards, share, rest), np.where(forwards, rest, share)


def between(
    column: NDArray[Any], begin: IntArray, end: NDArray[np.signedinteger[Any]], share: FloatArray
) -> NDArray[Any]:
    """(N,) values of a column, real or complex, the share of the way from one row to another."""
    base = column.take(begin)
    value: NDArray[Any] = base + share * (column.take(end) - base)
    return value


def following_corner(corner: IntArray) -> NDArray[np.int32]:
    """(N,) the next corner of the same face."""
    short = corner.astype(np.int32)  # divided in half the time
    return np.asarray(short + 1 - 3 * ((short - 3 * (short // 3)) >> 1), dtype=np.int32)
