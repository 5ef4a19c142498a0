"""Faces that part the inside of a solid or hang on its outside: what is left without them is closed.

They come from halves that were joined with the faces at which they met, above all by a Mirror modifier, which keeps one
of the two. Around an edge where three faces meet, an outline that takes the wrong turn loses half of the object.
"""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, IntArray, TriangleMesh
from ..ragged import starts
from .components import components, numbered


def inner_walls(mesh: TriangleMesh) -> IntArray:
    """(N,) the faces to leave out so that an even number of faces meets at every edge where an odd one did.

    Such edges part the surface into patches. Any one of the patches that meet there could go. The smallest one goes,
    as a flat wall across the solid is smaller than what bulges out on either side of it, unless that leaves a hole.

    Args:
        mesh: welded.
    """
    faces = mesh.faces
    a, b = faces, np.roll(faces, -1, axis=1)
    key, edge = np.unique(np.minimum(a, b) * np.int64(len(mesh.vertices)) + np.maximum(a, b), return_inverse=True)
    edge = edge.reshape(faces.shape)
    meeting = np.bincount(edge.ravel(), minlength=len(key))
    if not _is_odd(meeting).any():
        return np.zeros(0, dtype=np.int64)
    # Faces on both sides of an edge of two are of one patch; at other edges each stands for itself.
    ends = np.arange(len(key), len(key) + edge.size).reshape(edge.shape)
    patch = numbered(components(np.where(meeting[edge] == 2, edge, ends)))
    order = np.argsort(patch, kind="stable")
    first = starts(np.bincount(patch))
    touched = np.unique(patch[_is_odd(meeting)[edge].any(axis=1)])
    left_out = []
    for one in touched[np.argsort(np.bincount(patch, weights=mesh.face_area)[touched], kind="stable")]:
        members = order[first[one] : first[one + 1]]
        bounds, sides = np.unique(edge[members], return_counts=True)
        others = meeting[bounds] - sides
        if _is_odd(meeting[bounds]).any() and (others != 1).all():
            meeting[bounds] = others
            left_out.append(members)
    return np.sort(np.concatenate([np.zeros(0, dtype=np.int64), *left_out]))


def _is_odd(meeting: IntArray) -> BoolArray:
    """Whether an odd number of faces meets there, but more than one."""
    return np.asarray((meeting > 2) & (meeting % 2 == 1))
