"""How far the surface leans at every contour point."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray, TriangleMesh
from .contours import Contours


def face_slant_deg(mesh: TriangleMesh) -> FloatArray:
    """(F,) elevation of each face's normal, degrees: 0 for upright walls, 90 for tops, -90 for undersides."""
    return slant_deg_of(mesh.area_normals)


def slant_deg_of(normal: FloatArray) -> FloatArray:
    """(F,) elevation of normals (F, 3) of any length, degrees."""
    x, y, z = normal.T
    return np.asarray(np.degrees(np.arctan2(z, np.sqrt(x * x + y * y))))


def slant_along(lines: Contours, mesh: TriangleMesh) -> FloatArray:
    """(N,) degrees, of the face that each contour point was cut from."""
    return face_slant_deg(mesh)[lines.face]
