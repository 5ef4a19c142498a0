"""The object as it is sliced: checked, triangulated, welded and placed on the bed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import MeshError
from ..model import FloatArray, IntArray, SurfaceModel, TriangleMesh, bounds
from ..records import dataclass
from ..settings import PrintSettings
from .checks import checked
from .polygons import triangle_corners
from .size import check_size
from .welding import weld

_UV_LIMIT = 1e6  # beyond this, float32 no longer tells the texels apart


def triangulate(model: SurfaceModel, settings: PrintSettings) -> TriangleMesh:
    """Check, triangulate, weld and place a mesh.

    With `center_on_bed` the middle of the bounding box goes to x = y = 0 and its lowest point to z = 0; else the
    object stays where it is. Corners with a UV that is not finite lose their texture.

    Raises:
        MeshError: no faces, coordinates that are not finite, indices that do not fit, or a size that cannot be printed.
        TextureError: a texture but no UV map.
    """
    corner_vertex, vertices = checked(model)
    shift = -vertices[0]
    vertices = placed(vertices, settings.center_on_bed)
    shift += vertices[0]
    check_size(vertices, model.name, settings)
    triangles = _triangles(model, corner_vertex, vertices)
    faces = triangles.of_corners(corner_vertex)
    distinct, welded = weld(vertices, _vertex_object(model, corner_vertex, len(vertices)))
    if len(distinct) < len(vertices):
        faces = welded.take(faces)
    a, b, c = faces.T
    proper = (a != b) & (b != c) & (c != a)
    if not proper.any():
        raise MeshError(f"{model.name} has no face with an area", "check the mesh for collapsed faces")
    if not proper.all():
        kept = np.flatnonzero(proper)
        triangles, faces = replace(triangles, kept=kept), faces.take(kept, axis=0)
    face_uv, face_texture = _painting(model, triangles)
    tone, visibility = (_of_corners(table, triangles) for table in (model.corner_tone, model.corner_visibility))
    face_object, face_support, face_visibility = (
        None if table is None else triangles.of_polygons(table)
        for table in (model.polygon_object, model.polygon_support, model.polygon_visibility)
    )
    return TriangleMesh(
        distinct, faces, face_uv, np.broadcast_to(np.nan, faces.shape) if tone is None else tone, face_texture,
        face_object, face_support, tuple(volume.moved(shift) for volume in model.volumes), visibility, face_visibility,
    )  # fmt: skip


@dataclass(frozen=True)
class _Triangles:
    """Which corners and polygons the triangles come from.

    Attributes:
        corners: (T', 3) corners of each, None if they are all corners in turn.
        polygon: (T',) the polygon that it is part of, None if they are all polygons in turn.
        kept: (T,) those that have an area, None for all.
    """

    corners: IntArray | None
    polygon: IntArray | None
    kept: IntArray | None = None

    def of_corners(self, table: NDArray[Any]) -> NDArray[Any]:
        """(T, 3, …) rows of their corners, a view of the table where it can be one."""
        rows = table.reshape(-1, 3, *table.shape[1:]) if self.corners is None else table.take(self.corners, axis=0)
        return rows if self.kept is None else rows.take(self.kept, axis=0)

    def of_polygons(self, table: NDArray[Any]) -> NDArray[Any]:
        """(T,) values of their polygons, likewise."""
        rows = table if self.polygon is None else table.take(self.polygon)
        return rows if self.kept is None else rows.take(self.kept)


def _triangles(model: SurfaceModel, corner_vertex: IntArray, vertices: FloatArray) -> _Triangles:
    """All triangles of a model."""
    if (model.sides == 3).all():
        return _Triangles(None, None)
    return _Triangles(*triangle_corners(vertices, model.polygon_start, corner_vertex))


def placed(vertices: FloatArray, center_on_bed: bool) -> FloatArray:
    """Vertices (V, 3), with `center_on_bed` moved onto the middle of the bed."""
    if not center_on_bed:
        return vertices
    low, high = bounds(vertices)
    anchor = ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2])
    moved = np.empty_like(vertices)
    for axis in range(3):
        np.subtract(vertices[:, axis], anchor[axis], out=moved[:, axis])
    return moved


def _vertex_object(model: SurfaceModel, corner_vertex: IntArray, count: int) -> IntArray | None:
    """(V,) the object on the plate that each vertex belongs to, None for a single one."""
    if model.polygon_object is None:
        return None
    owner = np.zeros(count, dtype=np.int64)
    owner[corner_vertex] = np.repeat(model.polygon_object, model.sides)
    return owner


def _painting(model: SurfaceModel, triangles: _Triangles) -> tuple[FloatArray, IntArray]:
    """UVs (T, 3, 2) and textures (T,) of triangles; those with a UV that is not finite or huge get no texture."""
    texture = triangles.of_polygons(model.polygon_texture)
    if texture.min() < -1:
        texture = np.maximum(texture, -1)
    if model.corner_uv is None:
        return np.zeros((len(texture), 3, 2)), texture
    uv = np.asarray(triangles.of_corners(model.corner_uv), dtype=np.float64)
    if uv.min() >= -_UV_LIMIT and uv.max() <= _UV_LIMIT:  # NaN fails as well
        return uv, texture
    broken = ~(np.abs(uv) <= _UV_LIMIT).all(axis=(1, 2))
    uv, texture = uv.copy(), texture.copy()
    uv[broken], texture[broken] = 0.0, -1
    return uv, texture


def _of_corners(table: FloatArray | None, triangles: _Triangles) -> FloatArray | None:
    return None if table is None else triangles.of_corners(table)
