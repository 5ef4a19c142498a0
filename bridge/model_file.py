"""Model files (.blend, .obj, .stl, .ply, .glb, .gltf) as one object in a scene, standing upright."""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from ..core.errors import MeshError, PrintError
from .mesh_input import evaluated_mesh
from .units import mm_per_unit, use_millimetres

UP_AXIS = {".blend": "z", ".obj": "y", ".stl": "z", ".ply": "z", ".glb": "y", ".gltf": "y"}
"""The axis that usually points up in each kind of file."""


def open_model(path: Path, object_name: str = "", up: str = "", height_mm: float | None = None) -> bpy.types.Object:
    """Replace what is open by a model file and make the object to print ready, active and selected.

    All meshes of an imported file become one object, at 1 mm a unit. A .blend file keeps its scene and its units;
    of several meshes the active one is taken.

    Args:
        path: the file.
        object_name: the object to take, "" for the rule above.
        up: "y" or "z", the axis of the file that points up; "" for the usual one of its kind.
        height_mm: scale the object to this height, or None to leave its size.

    Raises:
        PrintError: no such file or object, an unknown kind of file, one that Blender cannot read.
        MeshError: nothing to print in it.
    """
    kind = path.suffix.lower()
    if kind not in UP_AXIS:
        raise PrintError(f"{path} is not a model file", f"known kinds are {', '.join(UP_AXIS)}")
    if not path.is_file():
        raise PrintError(f"there is no file {path}")
    if not path.stat().st_size:
        raise MeshError(f"{path} is empty")
    _read(path, kind)
    imported = kind != ".blend"
    if imported:
        use_millimetres(bpy.context.scene)
    bpy.context.view_layer.update()
    chosen = _chosen_objects(path, object_name, joined=imported)
    turn = _turn(kind, up or UP_AXIS[kind])
    if imported or height_mm is not None or turn != Matrix():
        name = path.stem if imported and not object_name else chosen[0].name
        chosen = [_baked(chosen, turn, name)]
    if height_mm is not None:
        _scale_to_height(chosen[0], height_mm)
    return _activated(chosen[0])


def _read(path: Path, kind: str) -> None:
    """Open or import a file as it is, y and z not swapped (but glTF, which Blender's importer always turns)."""
    name = str(path.resolve())
    axes = {"forward_axis": "Y", "up_axis": "Z"}
    try:
        if kind == ".blend":
            bpy.ops.wm.open_mainfile(filepath=name, load_ui=False, use_scripts=False)
            return
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        if kind == ".obj":
            bpy.ops.wm.obj_import(filepath=name, **axes)
        elif kind == ".stl":
            bpy.ops.wm.stl_import(filepath=name, **axes)
        elif kind == ".ply":
            bpy.ops.wm.ply_import(filepath=name, **axes)
        else:
            bpy.ops.import_scene.gltf(filepath=name, disable_bone_shape=True)
    except RuntimeError as problem:  # how an operator tells that it has failed
        reason = str(problem).strip().splitlines()[0].removeprefix("Error: ")
        raise PrintError(f"Blender cannot read {path}", reason) from None


def _turn(kind: str, up: str) -> Matrix:
    """The rotation that makes a file stand upright after `_read`."""
    upright = "y" if kind in (".glb", ".gltf") else "z"
    if up == upright:
        return Matrix()
    sine = 1.0 if up == "y" else -1.0  # written out, for a cosine of 90° is not quite zero
    return Matrix(((1, 0, 0, 0), (0, 0, -sine, 0), (0, sine, 0, 0), (0, 0, 0, 1)))


def _chosen_objects(path: Path, name: str, joined: bool) -> list[bpy.types.Object]:
    scene = bpy.context.scene
    meshes = sorted((obj for obj in scene.objects if obj.type == "MESH"), key=lambda obj: obj.name)
    names = ", ".join(obj.name for obj in meshes[:10])
    if name:
        found = scene.objects.get(name)
        if found is None:
            raise PrintError(f"there is no object {name} in {path}", f"its meshes are {names}" if names else "")
        return [found]
    meshes = [obj for obj in meshes if obj.visible_get()]
    if not meshes:
        raise MeshError(f"there is no mesh in {path}")
    if joined or len(meshes) == 1:
        return meshes
    active = bpy.context.view_layer.objects.active
    if active not in meshes:
        raise PrintError(f"{path} holds several meshes", f"choose one with --object: {names}")
    return [active]


def _baked(sources: list[bpy.types.Object], turn: Matrix, name: str) -> bpy.types.Object:
    """One new object without modifiers, parents or transform from several, which are hidden."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    copies = []
    for source in sources:
        with evaluated_mesh(source, depsgraph) as mesh:
            copy = bpy.data.objects.new(source.name, mesh.copy())
        matrix = turn @ source.evaluated_get(depsgraph).matrix_world
        copy.data.transform(matrix)
        if matrix.determinant() < 0:
            copy.data.flip_normals()
        bpy.context.scene.collection.objects.link(copy)
        copies.append(copy)
    for source in sources:
        source.name += ".source"
        source.hide_render = True
        source.hide_set(True)
    if len(copies) > 1:
        with bpy.context.temp_override(active_object=copies[0], selected_editable_objects=copies):
            bpy.ops.object.join()
    copies[0].name = name
    return copies[0]


def _scale_to_height(obj: bpy.types.Object, height_mm: float) -> None:
    """Scale the mesh of an object without transform about the origin."""
    position = np.empty(len(obj.data.vertices) * 3, dtype=np.float32)
    obj.data.attributes["position"].data.foreach_get("vector", position)
    z = position[2::3]
    height = float(z.max() - z.min()) * mm_per_unit(bpy.context.scene)
    if not math.isfinite(height):
        raise MeshError(f"{obj.name} has vertices without finite coordinates", "repair the mesh")
    if height == 0:
        raise MeshError(f"{obj.name} is flat", "it has no height to scale")
    obj.data.transform(Matrix.Scale(height_mm / height, 4))


def _activated(obj: bpy.types.Object) -> bpy.types.Object:
    for other in bpy.context.view_layer.objects:
        other.select_set(other == obj)
    bpy.context.view_layer.objects.active = obj
    bpy.context.view_layer.update()
    return obj
