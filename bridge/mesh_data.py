"""Tables of Blender's meshes as arrays, and places in the world."""

from __future__ import annotations

import bpy
import numpy as np

from ..core.model import Float32Array, FloatArray, IntArray


def positions(mesh: bpy.types.Mesh) -> Float32Array:
    """(V, 3) of all vertices, in the object's own units."""
    position = np.empty(len(mesh.vertices) * 3, dtype=np.float32)
    mesh.attributes["position"].data.foreach_get("vector", position)
    return position.reshape(-1, 3)


def corner_vertices(mesh: bpy.types.Mesh) -> IntArray:
    """(C,) the vertex of each corner, polygon by polygon."""
    vertex = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", vertex)
    return vertex.astype(np.int64)


def in_world(points: FloatArray | Float32Array, matrix: FloatArray) -> FloatArray:
    """(N, 3) points of an object with this matrix (4, 4), where they are in the world, in scene units."""
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def layer_uv(layer: bpy.types.MeshUVLoopLayer) -> FloatArray:
    """(C, 2) of each corner."""
    uv = np.empty(len(layer.uv) * 2, dtype=np.float32)
    layer.uv.foreach_get("vector", uv)
    return uv.reshape(-1, 2).astype(np.float64)
