"""UV maps for meshes that have none, or bad ones."""

from __future__ import annotations

import math
from collections.abc import Generator

import bmesh
import bpy
import numpy as np

from ...core.errors import MeshError
from ...core.mesh.unwrapping import ChartOptions, PackOptions, unwrapping
from ...core.model import FloatArray
from ...core.texture.uv_fit import is_one_to_one
from ..mesh_data import corner_vertices, layer_uv, positions
from ..units import mm_per_unit

UV_LAYER = "Dual-Color"
GAP_MM = 0.5
"""Between charts: the soft proof reads a sixth of a millimeter beyond them, on flat walls twice as much."""
_FILLED, _WIDEST = 0.6, 0.02  # share of the picture that charts fill; share of its side that is left around a chart
_MOST_UV_MAPS = 8  # that Blender lets a mesh have


def unwrap(obj: bpy.types.Object, method: str) -> None:
    """Give a mesh object a new, active UV map; the ones it has are kept.

    Args:
        obj: in object mode, in the current view layer.
        method: "smart" projects in few directions, fast; "xatlas" makes fewer, larger charts, slowly, and splits
            polygons into triangles.

    Raises:
        MeshError: the object is no mesh, has no faces, or no room for another UV map.
        PrintError: xatlas is not installed.
    """
    if method == "smart":
        smart_project(obj)
        return
    for _ in unwrap_steps(obj, ChartOptions(), PackOptions(padding=0)):
        pass


def unwrap_steps(obj: bpy.types.Object, chart: ChartOptions, pack: PackOptions) -> Generator[float, None, None]:
    """Unwrap with xatlas; yields the share that is done, and changes the mesh at the very end.

    Args:
        obj: in object mode.
        chart: how to cut the surface.
        pack: how to pack the charts.

    Raises:
        MeshError: the object is no mesh, has no faces, no room for another UV map, detail that belongs to its
            polygons, or xatlas cannot unwrap it.
        PrintError: xatlas is not installed.
    """
    check_unwrappable(obj)
    if any(modifier.type == "MULTIRES" for modifier in obj.modifiers):
        raise MeshError(
            f"{obj.name} has the modifier Multiresolution, whose detail would be lost with its polygons",
            "apply the modifier, or use Smart UV Project",
        )
    triangles = _triangulated(obj.data)
    try:
        faces = corner_vertices(triangles).reshape(-1, 3)
        uv = yield from unwrapping(positions(triangles) * _scale(obj), faces, chart, pack)
        if obj.data.is_editmode:
            raise MeshError(f"{obj.name} is being edited", "leave Edit Mode first")
        _copy_into(triangles, obj.data)
    finally:
        bpy.data.meshes.remove(triangles)
    _new_layer(obj.data).uv.foreach_set("vector", uv.ravel())
    obj.data.update()


def smart_project(obj: bpy.types.Object) -> None:
    """Unwrap with Blender's Smart UV Project.

    Raises:
        MeshError: the object is no mesh, has no faces, or no room for another UV map.
    """
    check_unwrappable(obj)
    _new_layer(obj.data)
    side_mm = math.sqrt(sum(face.area for face in obj.data.polygons) / _FILLED) * _scale(obj)
    margin = min(GAP_MM / 2 / side_mm, _WIDEST) if side_mm > 0 else 0.0
    layer = bpy.context.view_layer
    for other in layer.objects:
        other.select_set(other == obj)
    layer.objects.active = obj
    former = obj.mode
    bpy.ops.object.mode_set(mode="EDIT")
    with bpy.context.temp_override(edit_object=obj):  # which Blender takes from the window, not from another scene
        bpy.ops.mesh.reveal(select=False)
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.uv.smart_project(angle_limit=math.radians(66.0), margin_method="FRACTION", island_margin=margin)
    bpy.ops.object.mode_set(mode=former)


def check_unwrappable(obj: bpy.types.Object) -> None:
    """Check that a UV map can be added.

    Raises:
        MeshError: the object is no mesh, has no faces, or no room for another UV map.
    """
    if obj.type != "MESH" or not len(obj.data.polygons):
        raise MeshError(f"{obj.name} has no faces to unwrap", "choose a mesh object")
    if len(obj.data.uv_layers) >= _MOST_UV_MAPS:
        raise MeshError(f"{obj.name} has no room for another UV map", "remove one of its UV maps")


def _scale(obj: bpy.types.Object) -> float:
    """Millimeters in one of the object's own units, on average over its axes."""
    return abs(obj.matrix_world.to_3x3().determinant()) ** (1 / 3) * mm_per_unit(bpy.context.scene) or 1.0


def add_uv_map(obj: bpy.types.Object, uv: FloatArray) -> None:
    """Give a mesh object a new, active UV map, which is not the one to render.

    Args:
        obj: not in Edit Mode.
        uv: (C, 2) of each corner.

    Raises:
        MeshError: the object is being edited, or was.
    """
    if obj.data.is_editmode or len(obj.data.loops) != len(uv):
        raise MeshError(f"{obj.name} was changed while it was worked on", "leave Edit Mode, and start again")
    layer = obj.data.uv_layers.new(name=UV_LAYER, do_init=False)
    layer.uv.foreach_set("vector", uv.astype(np.float32).ravel())
    layer.active = True


def _new_layer(mesh: bpy.types.Mesh) -> bpy.types.MeshUVLoopLayer:
    layer = mesh.uv_layers.new(name=UV_LAYER, do_init=False)
    layer.active = layer.active_render = True
    return layer


def _triangulated(mesh: bpy.types.Mesh) -> bpy.types.Mesh:
    """A copy with polygons split, because a chart may end on a diagonal."""
    copy = mesh.copy()
    work = bmesh.new()
    work.from_mesh(mesh)
    bmesh.ops.triangulate(work, faces=[face for face in work.faces if len(face.verts) > 3])
    work.to_mesh(copy)
    work.free()
    return copy


def _copy_into(source: bpy.types.Mesh, target: bpy.types.Mesh) -> None:
    work = bmesh.new()
    work.from_mesh(source)
    work.to_mesh(target)
    work.free()


def has_room_for_every_face(mesh: bpy.types.Mesh) -> bool:
    """Whether each face of a mesh has a place of its own in the active UV map."""
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    loops, area = np.empty(count * 3, dtype=np.int32), np.empty(count, dtype=np.float32)
    mesh.loop_triangles.foreach_get("loops", loops)
    mesh.loop_triangles.foreach_get("area", area)
    return is_one_to_one(layer_uv(mesh.uv_layers.active)[loops].reshape(-1, 3, 2), area.astype(np.float64))
