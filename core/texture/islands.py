"""UV islands: which faces form one chart of a texture."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..model import IntArray, TriangleMesh

NO_ISLAND = -1

_UV_STEP = 1e-6  # UVs nearer than this are the same; a tenth of a texel of the largest pictures
_CHUNK_FACES = 1 << 17  # large meshes are worked on in parts, which stay in the cache and take little memory

LabelImage = NDArray[np.int32]
Node = TypeVar("Node", np.int32, np.int64)


def uv_islands(mesh: TriangleMesh) -> IntArray:
    """Island of each face (F,), numbered from 0 over all textures; `NO_ISLAND` without a texture.

    Faces belong together where they share a vertex at the same UV and use the same texture.
    """
    island = np.full(len(mesh.faces), NO_ISLAND, dtype=np.int64)
    faces = np.flatnonzero(mesh.face_texture >= 0)
    if not len(faces):
        return island
    root = components(_places(mesh, faces))
    is_root = np.zeros(root.max() + 1, dtype=bool)
    is_root[root] = True
    island[faces] = (np.cumsum(is_root) - 1)[root]
    return island


def _places(mesh: TriangleMesh, faces: IntArray) -> LabelImage:
    """(T, 3) the place in the textures at each corner of T faces: as a rule the vertex, at seams more than one.

    A vertex stands for the UV and the texture at one of its corners; only corners that differ from that are sorted.
    """
    standing = np.zeros(len(mesh.vertices), dtype=np.int64)
    place = np.empty((len(faces), 3), dtype=np.int32)
    parts = [slice(begin, begin + _CHUNK_FACES) for begin in range(0, len(faces), _CHUNK_FACES)]
    for part in parts:
        place[part] = mesh.faces[faces[part]]
        standing[place[part]] = 3 * faces[part, None] + np.arange(3)
    uv = mesh.face_uv.reshape(-1, 2)
    apart = np.empty(place.shape, dtype=bool)
    for part in parts:
        here, there = faces[part], standing[place[part]]
        apart[part] = (np.abs(mesh.face_uv[here] - uv[there]) > _UV_STEP).any(axis=2)
        apart[part] |= mesh.face_texture[here, None] != mesh.face_texture[there // 3]
    if apart.any():
        row, corner = np.nonzero(apart)
        steps = np.rint(mesh.face_uv[faces[row], corner] / _UV_STEP).astype(np.int64).view(np.uint64)
        owner = np.stack([place[row, corner], mesh.face_texture[faces[row]]]).astype(np.uint64)
        key = _mixed(owner[0], owner[1], steps[:, 0], steps[:, 1])
        place[row, corner] = len(mesh.vertices) + np.unique(key, return_inverse=True)[1]
    return place


def components(groups: NDArray[Node]) -> NDArray[Node]:
    """Connected components of nodes that occur together: of groups (G, k) of node numbers, each group's root (G,).

    Every group hooks the roots of its nodes to the least of them, then all paths are halved; groups that agree are
    done, since roots only ever merge.
    """
    parent = np.arange(groups.max(initial=-1) + 1, dtype=groups.dtype)
    open_groups = groups
    while len(open_groups):
        roots = parent[open_groups]
        least = roots.min(axis=1)
        apart = (roots != least[:, None]).any(axis=1)
        open_groups, roots, least = open_groups[apart], roots[apart], least[apart]
        np.minimum.at(parent, roots.ravel(), np.repeat(least, groups.shape[1]))
        parent = _flattened(parent)
    root: NDArray[Node] = parent[groups[:, 0]]
    return root


def _mixed(*parts: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """One 64-bit key of several numbers; unlike ones differ but for a chance of about n² / 2⁶⁵."""
    key = np.zeros(parts[0].shape, dtype=np.uint64)
    for part in parts:
        key = (key ^ part) * np.uint64(0x9E3779B97F4A7C15)
        key ^= key >> np.uint64(29)
        key *= np.uint64(0xBF58476D1CE4E5B9)
        key ^= key >> np.uint64(32)
    return key


def _flattened(parent: NDArray[Node]) -> NDArray[Node]:
    """Every node's root."""
    while True:
        above = parent[parent]
        if np.array_equal(above, parent):
            return parent
        parent = above
