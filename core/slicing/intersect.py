"""Triangles × planes → directed segments, all layers at once."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..mesh.corners import complex_uv
from ..model import FloatArray, IntArray, TriangleMesh
from ..parallel import CHUNK_ROWS
from ..ragged import starts
from ..records import dataclass
from .edges import LEADS_UP, faces_beyond
from .planes import levels

_CODE_BITS, _AROUND_HIGHEST = 5, 2  # see `ends_of`


def _codes() -> tuple[IntArray, IntArray]:
    """(32,) lower and (32,) upper corner, 0 to 2, for every value of the five bits of an edge, see `ends_of`."""
    code = np.arange(1 << _CODE_BITS)
    bottom, rising, around_highest, ends = code >> 3, (code >> 2) & 1, (code >> 1) & 1, code & 1
    side, top = (bottom + 2 - rising) % 3, (bottom + 1 + rising) % 3
    # A cut starts on the edge that leads down and ends on the one that leads up.
    across = rising != ends
    low = np.where(across | (around_highest == 0), bottom, side)
    return low, np.where(across | (around_highest == 1), top, side)


_LOW, _HIGH = _codes()


@dataclass(frozen=True)
class Segments:
    """S segments, solid on their left where the mesh's normals point outwards.

    Attributes:
        mesh: F faces.
        planes: (L,) mm, increasing.
        layer: (S,) int64.
        tail: (S,) int64, the edge that the segment starts on, see `ends_of`; it ends on `tail ^ 1`.
        successor: (S,) int64, the segment that starts where each one ends, in the face beyond; -1 where none does.
    """

    mesh: TriangleMesh
    planes: FloatArray
    layer: IntArray
    tail: IntArray
    successor: IntArray

    @property
    def face(self) -> IntArray:
        """(S,) the face that each was cut from."""
        return faces_of(self.tail)

    @property
    def points(self) -> FloatArray:
        """(S, 2, 2) mm, x and y of both ends."""
        plane, columns = self.planes[self.layer], columns_of(self.mesh)
        ends = [cut_edges(*columns, *ends_of(edge), plane)[0] for edge in (self.tail, self.tail ^ 1)]
        return np.stack(ends, axis=1).view(np.float64).reshape(-1, 2, 2)


@dataclass(frozen=True)
class Crossings:
    """Which layers cut each of N faces, and through which of its edges.

    Layers from `low` to before `middle` separate its lowest corner from the other two, layers from `middle` to before
    `high` its highest one.

    Attributes:
        mesh: F faces.
        planes: (L,) mm, increasing.
        low: (N,) int64, the lowest layer that cuts the face.
        middle: (N,) int64, the lowest layer above its middle corner.
        high: (N,) int64, the lowest layer above all of it.
        edge: (N,) int64, the edge on which cuts around the lowest corner start, see `ends_of`.
        beyond: (N, 2) int64, in which of the N faces the cuts around the lowest and around the highest corner continue,
            -1 for none.
    """

    mesh: TriangleMesh
    planes: FloatArray
    low: IntArray
    middle: IntArray
    high: IntArray
    edge: IntArray
    beyond: IntArray

    def between(self, low: int, high: int) -> Crossings:
        """The cuts by the layers from `low` to the one before `high`."""
        some = np.flatnonzero((self.low < high) & (self.high > low))
        first, middle, end = (np.clip(level[some], low, high) for level in (self.low, self.middle, self.high))
        place = np.full(len(self.low) + 1, -1)  # the last one for none
        place[some] = np.arange(len(some))
        return Crossings(self.mesh, self.planes, first, middle, end, self.edge[some], place[self.beyond[some]])

    def segments(self) -> Segments:
        """The cuts, face by face, each from its lowest layer up."""
        # The cuts of a face stand in a row, so the one that goes on is found by the face beyond and the layer.
        count = self.high - self.low
        begin = starts(count)
        begin[:-1] -= self.low
        begin[-1] = -1 - len(self.planes)  # for none
        row = np.repeat(np.arange(len(count)), count)
        layer = np.arange(len(row))
        layer -= begin.take(row)
        tail, around_highest = self.edge.take(row), (layer >= self.middle.take(row)).astype(np.int64)
        row <<= 1
        row |= around_highest
        successor = begin.take(self.beyond, mode="wrap").take(row)
        successor += layer
        np.maximum(successor, -1, out=successor)
        around_highest *= _AROUND_HIGHEST
        tail |= around_highest
        return Segments(self.mesh, self.planes, layer, tail, successor)


def crossings(mesh: TriangleMesh, planes: FloatArray) -> Crossings:
    """Find the planes that pass through each face.

    A vertex exactly on a plane counts as above it. With that rule each face is crossed through exactly two of its
    edges or not at all, whatever touches the plane, so loops stay closed without any special case; coplanar facets
    and on-plane edges simply fall to one side.

    Args:
        mesh: F faces.
        planes: (L,) mm, increasing.
    """
    level = levels(mesh.vertices[:, 2].copy(), planes)
    bits, count = len(level).bit_length(), len(mesh.faces)
    vertex = ((level << bits) | np.arange(len(level))) << 2
    # As long as they can get; what is not filled takes no memory.
    table, edges = np.empty((4, count), dtype=np.int64), np.empty((2, 3 * count), dtype=np.int64)
    cut = used = 0
    for begin in range(0, count, CHUNK_ROWS):
        faces, *of_edges = _cuts(vertex, bits, mesh.faces[begin : begin + CHUNK_ROWS], begin, cut)
        cut = _filled(table, cut, faces)
        for columns in of_edges:
            used = _filled(edges, used, columns)
    (low, middle, high, edge), (key, number) = table[:, :cut], edges[:, :used]
    beyond, slot = faces_beyond(key, number, 2 * cut), 2 * np.arange(cut)
    pairs = np.stack([beyond.take(slot), beyond.take(slot + ((edge >> 2) & 1))], axis=1)
    return Crossings(mesh, planes, low, middle, high, edge, pairs)


def _filled(table: IntArray, begin: int, columns: tuple[IntArray, ...]) -> int:
    """Put columns (n,) into the rows of a table from a place on; where they end."""
    end = begin + len(columns[0])
    for row, column in zip(table, columns, strict=True):
        row[begin:end] = column
    return end


def _cuts(
    vertex: IntArray, bits: int, faces: IntArray, first: int, cut_before: int
) -> tuple[tuple[IntArray, ...], ...]:
    """Which planes cut some faces, and the edges of these that planes cut.

    Args:
        vertex: (V,) each vertex in one number: its level, then its index in `bits` bits, then two bits for the corner
            of a face, which are 0 here.
        bits: that hold any index.
        faces: (n, 3) vertices.
        first: number of the first face.
        cut_before: how many faces before that are cut.

    Returns:
        `low`, `middle`, `high` and `edge` of each face that is cut, as in `Crossings`, and three times keys and numbers
        of edges as `faces_beyond` takes them: from its lowest to its highest corner, below and above the middle one.
    """
    corners = vertex.take(faces)
    unlike = (corners[:, 0] ^ corners[:, 1]) | (corners[:, 1] ^ corners[:, 2])
    cut = np.flatnonzero(unlike >= 1 << (bits + 2))
    corners = corners.take(cut, axis=0)
    # Three sorted by hand; an odd number of pairs in order makes the order a turned one, not a mirrored one.
    a, b, c = (corners[:, k] + k for k in range(3))
    rising = ((a < b) ^ (b < c) ^ (a < c)).astype(np.int64)
    lowest, highest = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    ordered = lowest, a ^ b ^ c ^ lowest ^ highest, highest
    low, middle, high = (column >> (bits + 2) for column in ordered)
    edge = (((cut + first) << 2 | (ordered[0] & 3)) << 3) | (rising << 2)

    bottom, side, top = ((column >> 2) & ((1 << bits) - 1) for column in ordered)
    bottom <<= bits
    # The edges next to the middle corner lead up where it comes after the lowest one, else the one across from it does.
    number = 2 * np.arange(cut_before, cut_before + len(cut)) + LEADS_UP * rising
    below, above = np.flatnonzero(low < middle), np.flatnonzero(middle < high)
    across = bottom | top, number ^ LEADS_UP
    lower = (bottom | side).take(below), number.take(below)
    upper = ((side << bits) | top).take(above), number.take(above) + 1
    return (low, middle, high, edge), across, lower, upper


def intersect(mesh: TriangleMesh, planes: FloatArray) -> Segments:
    """Cut every face with every plane that passes through it; see `crossings`."""
    return crossings(mesh, planes).segments()


def ends_of(edge: IntArray) -> tuple[IntArray, IntArray]:
    """Lower and upper corner (N,) of edges (N,) that planes cut; corner k of face f has the number 3 f + k.

    An edge is named by its use in a cut. The number of the face is followed by five bits: its lowest corner (two bits),
    whether the middle corner follows that one, whether the cut goes around the highest corner, and whether it ends on
    this edge rather than starts there.
    """
    code, face = edge & (len(_LOW) - 1), 3 * (edge >> _CODE_BITS)
    return face + _LOW.take(code), face + _HIGH.take(code)


def faces_of(edge: IntArray) -> IntArray:
    """(N,) the faces of edges (N,), see `ends_of`."""
    return edge >> _CODE_BITS


def columns_of(mesh: TriangleMesh) -> tuple[IntArray, NDArray[np.complex128], FloatArray]:
    """(3F,) vertex of each corner, (V,) x + iy and (V,) z of the vertices; contiguous columns are read much faster."""
    return mesh.faces.ravel(), complex_uv(mesh.vertices[:, :2]), mesh.vertices[:, 2].copy()


def cut_edges(
    vertex: IntArray,
    place: NDArray[np.complex128],
    height: FloatArray,
    low: IntArray,
    high: IntArray,
    plane: FloatArray,
) -> tuple[NDArray[np.complex128], FloatArray]:
    """Where planes meet edges.

    Args:
        vertex: (3F,) see `columns_of`.
        place: (V,) likewise.
        height: (V,) likewise.
        low: (N,) corner at the lower end of each edge.
        high: (N,) corner at its upper end.
        plane: (N,) mm.

    Returns:
        (N,) x + iy, the same to the last digit for all faces of an edge, and (N,) the share of the way up.
    """
    low, high = vertex.take(low), vertex.take(high)
    share = height.take(low)
    whole = height.take(high)
    whole -= share
    np.subtract(plane, share, out=share)
    share /= whole
    return between(place, low, high, share), share


def between(column: NDArray[Any], begin: IntArray, end: IntArray, share: FloatArray) -> NDArray[Any]:
    """(N,) values of a column, real or complex, interpolated: at a share of the way from row `begin` to row `end`."""
    base, value = column.take(begin), column.take(end)
    value -= base
    value *= share
    value += base
    return value
