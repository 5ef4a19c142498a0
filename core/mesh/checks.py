"""Refuses what is no mesh: no faces, tables that do not fit each other, coordinates that are not finite."""

from __future__ import annotations

import numpy as np

from ..errors import MeshError, TextureError
from ..model import FloatArray, IntArray, SurfaceModel

_FAR_AWAY_MM = 1e7  # beyond this, neighboring vertices could no longer be told apart


def checked(model: SurfaceModel) -> tuple[IntArray, FloatArray]:
    """Corners' vertices (C,) and coordinates (V', 3) without the vertices that no face uses.

    Raises:
        MeshError: no faces, coordinates that are not finite or indices that do not fit.
        TextureError: a texture but no UV map.
    """
    _check_indices(model)
    corner_vertex, vertices = _used_vertices(model)
    _check_coordinates(vertices, model.name)
    return corner_vertex, vertices


def _check_indices(model: SurfaceModel) -> None:
    """Refuse a mesh without faces or with tables that do not fit each other."""
    start, corner = model.polygon_start, model.corner_vertex
    if not len(model.vertices) or model.sides.max(initial=0) < 3:
        raise MeshError(f"{model.name} has no faces", "choose a mesh object with a closed surface")
    fits = start[0] == 0 and start[-1] == len(corner) and model.sides.min() >= 0
    if not fits or corner.min() < 0 or corner.max() >= len(model.vertices):
        raise MeshError(f"{model.name} has faces that use vertices it does not have", "repair or export the mesh again")
    textures = [table for table in (model.polygon_texture, model.polygon_visibility) if table is not None]
    if any(len(table) != len(start) - 1 or table.max() >= len(model.textures) for table in textures):
        raise MeshError(f"{model.name} has faces that use textures it does not have", "assign the picture again")
    if model.corner_uv is None and any((table >= 0).any() for table in textures):
        raise TextureError(f"{model.name} has a texture but no UV map", "unwrap the mesh first")


def _used_vertices(model: SurfaceModel) -> tuple[IntArray, FloatArray]:
    """Corners' vertices (C,) and coordinates (V', 3) without the vertices that no face uses."""
    used = np.zeros(len(model.vertices), dtype=bool)
    used[model.corner_vertex] = True
    if used.all():
        return np.asarray(model.corner_vertex, dtype=np.int64), np.asarray(model.vertices, dtype=np.float64)
    renumbered = np.cumsum(used) - 1
    return renumbered[model.corner_vertex], np.asarray(model.vertices[used], dtype=np.float64)


def _check_coordinates(vertices: FloatArray, name: str) -> None:
    if not np.isfinite(vertices).all():
        count = int((~np.isfinite(vertices)).any(axis=1).sum())
        number = "a vertex" if count == 1 else f"{count} vertices"
        raise MeshError(f"{name} has {number} whose coordinates are not finite numbers", "delete or repair them")
    farthest = np.abs(vertices).max()
    if farthest > _FAR_AWAY_MM:
        raise MeshError(f"{name} reaches {farthest:.3g} mm from the origin", "check its location, scale and unit")
