"""Whether a UV map can hold a picture of the whole surface: a place of its own for every place."""

from __future__ import annotations

import numpy as np

from ..mesh.surface_points import points_on_faces
from ..model import FloatArray
from .islands import uv_areas

_CELLS = 512  # along the side of the picture
_STEP = 0.7  # between points, so that hardly a cell is missed
_OUTSIDE = 1e-3  # of the side; less is rounding
_TWICE = 0.03  # share of the charts' area that may lie on others
_LOST = 0.01  # share of the surface that may have hardly any room
_LEAST_ROOM = 1e-3  # of the mean room; faces with less count as lost


def is_one_to_one(face_uv: FloatArray, face_area: FloatArray) -> bool:
    """Whether charts lie within the picture, beside one another, and all faces have room in them.

    Args:
        face_uv: (T, 3, 2) of each triangle.
        face_area: (T,) on the surface, in any unit.
    """
    room, surface = np.abs(uv_areas(face_uv)), float(face_area.sum())
    own = (1.0 - _TWICE) * float(room.sum())  # of the picture, at least, where hardly any lies on others
    if not 0 < own <= 1.0 or face_uv.min() < -_OUTSIDE or face_uv.max() > 1.0 + _OUTSIDE:
        return False
    lost = room < _LEAST_ROOM * face_area * (room.sum() / surface) if surface > 0 else np.zeros(0, dtype=bool)
    if face_area[lost].sum() > _LOST * surface:
        return False
    points = points_on_faces(face_uv * _CELLS, _STEP)
    place = np.einsum("qc,qcd->qd", points.share, face_uv[points.face])
    cell = np.clip((place * _CELLS).astype(np.int64), 0, _CELLS - 1)
    covered = np.zeros(_CELLS * _CELLS, dtype=bool)
    covered[cell[:, 1] * _CELLS + cell[:, 0]] = True
    return bool(np.count_nonzero(covered) >= own * _CELLS**2)
