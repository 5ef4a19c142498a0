"""Triangles × planes → directed segments, all layers at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model import FloatArray, IntArray, TriangleMesh
from ..pattern.chunks import in_chunks
from .outlines import ranges

# For each set of corners above a plane, as bits: the corner that is alone on its side and the two that follow it, and
# whether it is above.
_FROM_APEX = (np.array([0, 0, 1, 2, 2, 1, 0, 0]) + np.arange(3)[:, None]) % 3
_LONE_IS_ABOVE = np.array([False, True, True, False, True, False, False, False])


@dataclass(frozen=True)
class Segments:
    """S segments, solid on their left where the mesh's normals point outwards.

    Attributes:
        layer: (S,) int64.
        face: (S,) int64.
        tail: (S,) int64, the mesh edge that the segment starts on.
        head: (S,) int64, the mesh edge that it ends on.
        points: (S, 2, 2) float64 mm, both ends.
        carried: (S, 2, 3) float64, u, v and vertex tone at both ends.
    """

    layer: IntArray
    face: IntArray
    tail: IntArray
    head: IntArray
    points: FloatArray
    carried: FloatArray


def intersect(mesh: TriangleMesh, planes: FloatArray) -> Segments:
    """Cut every face with every plane that passes through it.

    A vertex exactly on a plane counts as above it. With that rule each face is crossed through exactly two of its
    edges or not at all, whatever touches the plane, so loops stay closed without any special case; coplanar facets
    and on-plane edges simply fall to one side.

    Args:
        mesh: F faces.
        planes: (L,) mm, increasing.
    """
    corner = mesh.faces.ravel()
    height = mesh.vertices[:, 2][corner]
    first, end = (np.searchsorted(planes, extreme, side="right") for extreme in extremes(height))
    count = end - first
    face = np.repeat(np.arange(len(mesh.faces)), count)
    layer = ranges(first, count)
    edge = _edge_ids(mesh.faces).ravel()
    carried = np.concatenate([mesh.face_uv, mesh.face_tone[..., None]], axis=2).reshape(-1, 3)

    def chunk(face: IntArray, layer: IntArray) -> tuple[NDArray[Any], ...]:
        """Edges, ends and what they carry of some of the cuts."""
        plane, corners = planes[layer], 3 * face
        above = sum((height[corners + k] >= plane) * np.int64(1 << k) for k in range(3))
        # Corners in the face's own turn, the apex first: the cut runs from edge (0, 1) to edge (2, 0) when the apex is
        # above, and back when it is below.
        apex, second, third = (corners + turned[above] for turned in _FROM_APEX)
        lone_is_above = _LONE_IS_ABOVE[above]
        ahead, behind = np.where(lone_is_above, (second, third), (third, second))
        cuts = [_cut(mesh.vertices, corner, carried, plane, apex, other) for other in (ahead, behind)]
        tail, head = np.where(lone_is_above, (apex, third), (third, apex))
        points, values = (np.stack(pair, axis=1) for pair in zip(*cuts, strict=True))
        return edge[tail], edge[head], points, values

    return Segments(layer, face, *in_chunks(chunk, face, layer))


def extremes(height: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(F,) the least and the greatest of the heights (3F,) of each face's corners."""
    a, b, c = height[0::3], height[1::3], height[2::3]
    return np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)


def _edge_ids(faces: IntArray) -> IntArray:
    """(F, 3) id of the undirected edge from corner k to corner k + 1."""
    tail, head = faces, np.roll(faces, -1, axis=1)
    key = np.minimum(tail, head) * (faces.max(initial=0) + 1) + np.maximum(tail, head)
    return np.asarray(np.unique(key.ravel(), return_inverse=True)[1].reshape(faces.shape), dtype=np.int64)


def _cut(
    vertices: FloatArray, corner: IntArray, carried: FloatArray, plane: FloatArray, a: IntArray, b: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Point and carried values where the edge between corners a and b of the mesh meets its plane."""
    # From the lower vertex number to the higher one, so that both faces of an edge get the very same point.
    swap = corner[a] > corner[b]
    a, b = np.where(swap, (b, a), (a, b))
    low, high = (vertices.take(corner[end], axis=0) for end in (a, b))
    share = ((plane - low[:, 2]) / (high[:, 2] - low[:, 2]))[:, None]
    value = carried.take(a, axis=0)
    return low[:, :2] + share * (high - low)[:, :2], value + share * (carried.take(b, axis=0) - value)
