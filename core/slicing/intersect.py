"""Triangles × planes → directed segments, all layers at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..model import FloatArray, IntArray, TriangleMesh
from .outlines import ranges


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
    height = mesh.vertices[:, 2][mesh.faces]
    first = np.searchsorted(planes, height.min(axis=1), side="right")
    count = np.searchsorted(planes, height.max(axis=1), side="right") - first
    face = np.repeat(np.arange(len(mesh.faces)), count)
    layer = ranges(first, count)

    above = height[face] >= planes[layer, None]
    lone_is_above = above.sum(axis=1) == 1
    apex = np.argmax(above == lone_is_above[:, None], axis=1)
    # Corners in the face's own turn, the apex first: the cut runs from edge (0, 1) to edge (2, 0) when the apex is
    # above, and back when it is below.
    corners = (apex[:, None] + np.arange(3)) % 3
    ahead = np.where(lone_is_above, 1, 2)
    behind = 3 - ahead
    row = np.arange(len(face))
    ends = [(corners[row, 0], corners[row, side]) for side in (ahead, behind)]
    edge_of_side = _edge_ids(mesh.faces)
    edges = [edge_of_side[face, np.where(side == 1, corners[row, 0], corners[row, 2])] for side in (ahead, behind)]
    cuts = [_cut(mesh, face, planes[layer], a, b) for a, b in ends]
    return Segments(
        layer,
        face,
        tail=edges[0],
        head=edges[1],
        points=np.stack([cuts[0][0], cuts[1][0]], axis=1),
        carried=np.stack([cuts[0][1], cuts[1][1]], axis=1),
    )


def _edge_ids(faces: IntArray) -> IntArray:
    """(F, 3) id of the undirected edge from corner k to corner k + 1."""
    tail, head = faces, np.roll(faces, -1, axis=1)
    key = np.minimum(tail, head) * (faces.max(initial=0) + 1) + np.maximum(tail, head)
    return np.asarray(np.unique(key.ravel(), return_inverse=True)[1].reshape(faces.shape), dtype=np.int64)


def _cut(
    mesh: TriangleMesh, face: IntArray, plane: FloatArray, a: IntArray, b: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Point and carried values where the edge between corners a and b of a face meets its plane."""
    # From the lower vertex number to the higher one, so that both faces of an edge get the very same point.
    swap = mesh.faces[face, a] > mesh.faces[face, b]
    a, b = np.where(swap, b, a), np.where(swap, a, b)
    from_point, to_point = mesh.vertices[mesh.faces[face, a]], mesh.vertices[mesh.faces[face, b]]
    share = ((plane - from_point[:, 2]) / (to_point[:, 2] - from_point[:, 2]))[:, None]
    point = from_point[:, :2] + share * (to_point - from_point)[:, :2]
    carried = np.concatenate([mesh.face_uv, mesh.face_tone[..., None]], axis=2)
    from_value, to_value = carried[face, a], carried[face, b]
    return point, from_value + share * (to_value - from_value)
