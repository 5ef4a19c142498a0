"""UV islands: which faces form one chart of a texture."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..mesh.corners import complex_uv
from ..model import FloatArray, IntArray, TriangleMesh
from ..parallel import CHUNK_ROWS

NO_ISLAND = -1

_UV_STEP = 1e-6  # UVs nearer than this are the same; a tenth of a texel of the largest pictures

LabelImage = NDArray[np.signedinteger[Any]]
"""Numbers of islands, of as few bytes as their count allows."""


def corner_places(mesh: TriangleMesh, faces: IntArray) -> IntArray:
    """(T, 3) the place in the UV map at each corner of T faces: equal numbers where UV and texture are equal.

    As a rule that is the vertex; only corners whose UV differs from that of another corner of their vertex, as along
    seams, are sorted and get numbers of their own.
    """
    whole = len(faces) == len(mesh.faces)
    place, texture = (mesh.faces.copy(), mesh.face_texture) if whole else (mesh.faces[faces], mesh.face_texture[faces])
    uv = complex_uv(mesh.face_uv if whole else mesh.face_uv[faces])
    standing = np.empty(len(mesh.vertices), dtype=np.complex128)
    standing[place] = uv

    parts = range(0, len(faces), CHUNK_ROWS)
    unlike = [
        np.flatnonzero(standing.take(place[begin : begin + CHUNK_ROWS]) != uv[begin : begin + CHUNK_ROWS]) + 3 * begin
        for begin in parts
    ]
    row, corner = np.divmod(np.concatenate([*unlike, np.zeros(0, dtype=np.int64)]), 3)
    difference = uv[row, corner] - standing[place[row, corner]]
    far = np.maximum(np.abs(difference.real), np.abs(difference.imag)) > _UV_STEP
    row, corner = row[far], corner[far]
    if texture.min(initial=0) != texture.max(initial=0):
        owner = np.empty(len(mesh.vertices), dtype=np.int64)
        owner[place] = texture[:, None]
        apart = owner[place] != texture[:, None]
        apart[row, corner] = True
        row, corner = np.nonzero(apart)
    if len(row):
        steps = np.rint(uv[row, corner].view(np.float64).reshape(-1, 2) / _UV_STEP).astype(np.int64)
        key = _mixed(place[row, corner], texture[row], steps[:, 0], steps[:, 1])
        place[row, corner] = len(mesh.vertices) + np.unique(key, return_inverse=True)[1]
    return place


def uv_areas(face_uv: FloatArray) -> FloatArray:
    """(T,) area of triangles (T, 3, 2) in the picture, as a share of it, negative for those that are mirrored."""
    area = np.empty(len(face_uv))
    for begin in range(0, len(area), CHUNK_ROWS):  # what stays in the cache
        uv = complex_uv(face_uv[begin : begin + CHUNK_ROWS])
        first, second = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
        area[begin : begin + CHUNK_ROWS] = 0.5 * (first.real * second.imag - first.imag * second.real)
    return area


def _mixed(*parts: IntArray) -> NDArray[np.uint64]:
    """One 64-bit key of several numbers; unlike ones differ but for a chance of about n² / 2⁶⁵."""
    key = np.zeros(parts[0].shape, dtype=np.uint64)
    for part in parts:
        key = (key ^ part.astype(np.int64, copy=False).view(np.uint64)) * np.uint64(0x9E3779B97F4A7C15)
        key ^= key >> np.uint64(29)
        key *= np.uint64(0xBF58476D1CE4E5B9)
        key ^= key >> np.uint64(32)
    return key
