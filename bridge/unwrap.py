"""UV maps for meshes that have none."""

from __future__ import annotations

import math

import bmesh
import bpy
import numpy as np

from ..core.errors import MeshError, PrintError

UV_LAYER = "Dual-Color"
METHODS = ("smart", "xatlas")


def unwrap(obj: bpy.types.Object, method: str) -> None:
    """Give a mesh object a new, active UV map; the ones it has are kept.

    Args:
        obj: in object mode, in the current view layer.
        method: "smart" projects in few directions, fast; "xatlas" makes fewer, larger charts, slowly, and splits
            polygons into triangles.

    Raises:
        MeshError: the object is no mesh or has no faces.
        PrintError: xatlas is not installed.
    """
    if obj.type != "MESH" or not len(obj.data.polygons):
        raise MeshError(f"{obj.name} has no faces to unwrap", "choose a mesh object")
    if method == "smart":
        _new_layer(obj.data)
        _smart_project(obj)
    else:
        _xatlas(obj.data)


def _new_layer(mesh: bpy.types.Mesh) -> bpy.types.MeshUVLoopLayer:
    layer = mesh.uv_layers.new(name=UV_LAYER, do_init=False)
    if layer is None:
        raise MeshError(f"{mesh.name} has no room for another UV map", "remove one of its UV maps")
    layer.active = layer.active_render = True
    return layer


def _smart_project(obj: bpy.types.Object) -> None:
    layer = bpy.context.view_layer
    for other in layer.objects:
        other.select_set(other == obj)
    layer.objects.active = obj
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.reveal(select=False)
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.smart_project(angle_limit=math.radians(66.0), island_margin=0.002)
    bpy.ops.object.mode_set(mode="OBJECT")


def _xatlas(mesh: bpy.types.Mesh) -> None:
    try:
        import xatlas
    except ImportError:
        raise PrintError("xatlas is not installed", "unwrap with the smart method instead") from None
    _triangulate(mesh)
    position = np.empty(len(mesh.vertices) * 3, dtype=np.float32)
    mesh.attributes["position"].data.foreach_get("vector", position)
    corner_vertex = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", corner_vertex)
    _, corners, uv = xatlas.parametrize(position.reshape(-1, 3), corner_vertex.reshape(-1, 3).astype(np.uint32))
    _new_layer(mesh).uv.foreach_set("vector", np.ascontiguousarray(uv[corners.ravel()], dtype=np.float32).ravel())
    mesh.update()


def _triangulate(mesh: bpy.types.Mesh) -> None:
    """Split polygons, because a chart may end on a diagonal."""
    work = bmesh.new()
    work.from_mesh(mesh)
    bmesh.ops.triangulate(work, faces=[face for face in work.faces if len(face.verts) > 3])
    work.to_mesh(mesh)
    work.free()
