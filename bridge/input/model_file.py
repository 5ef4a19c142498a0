"""Model files (.blend, .obj, .stl, .ply, .glb, .gltf) as objects in a scene, standing upright."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from pathlib import Path

import bpy
import numpy as np
from mathutils import Euler, Matrix

from ...core.errors import MeshError, PrintError
from ...core.files import title
from ..mesh_data import positions
from ..quiet import quiet_stderr
from ..units import mm_per_unit, use_millimeters
from .file_heads import check_head, legible
from .mesh_input import evaluated_mesh

UP_AXIS = {".blend": "z", ".obj": "y", ".stl": "z", ".ply": "z", ".glb": "y", ".gltf": "y"}
"""The axis that usually points up in each kind of file."""
_OTHER_MODELS = (".3mf", ".amf", ".step", ".stp", ".fbx", ".dae", ".usd", ".usdc", ".usdz")
_OTHER_KINDS = {
    **dict.fromkeys(_OTHER_MODELS, "open it elsewhere and save it as .stl, .obj or .glb"),
    **dict.fromkeys(
        (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".webp"),
        "dualcolor plate puts pictures on plates; --texture puts one on a model",
    ),
    ".gcode": "dualcolor render shows the print in a G-code file",
    ".x3g": "dualcolor render shows the print in an X3G file",
}


Angles = tuple[float, float, float]
UNTURNED: Angles = (0.0, 0.0, 0.0)

SCALE_KEY = "dualcolor_scale"
"""Property of an object: what it was multiplied by, for what belongs to it."""


_STL_HEAD_BYTES = 84  # of a binary file; a facet in text needs more too


def open_model(
    path: Path,
    object_name: str = "",
    up: str = "",
    height_mm: float | None = None,
    *,
    scale: float = 1.0,
    rotate_deg: Angles = UNTURNED,
) -> bpy.types.Object:
    """One object: see `open_models`."""
    names = [object_name] if object_name else []
    return open_models([path], names, up, height_mm, scale=scale, rotate_deg=rotate_deg)[0]


def open_models(
    paths: Sequence[Path],
    object_names: Sequence[str] = (),
    up: str = "",
    height_mm: float | None = None,
    *,
    scale: float = 1.0,
    rotate_deg: Angles = UNTURNED,
) -> list[bpy.types.Object]:
    """Replace what is open by model files and make the objects to print ready and selected, the first one active.

    All meshes of an imported file become one object, at 1 mm a unit. A .blend file keeps its scene and its units;
    of several meshes the active one is taken.

    Args:
        paths: one file, or several that are imported into one scene.
        object_names: the objects of a single file to take, none for the rule above.
        up: "y" or "z", the axis of the files that points up; "" for the usual one of their kind.
        height_mm: scale the objects of each file together to this height, or None to leave their size.
        scale: multiply their size by this instead.
        rotate_deg: turn the upright objects about the X axis, then about Y, then about Z.

    Raises:
        PrintError: no such file or object, an unknown kind of file, one that Blender cannot read.
        MeshError: nothing to print in it.
    """
    for path in paths:
        check_file(path, alone=len(paths) == 1)
    if object_names and len(paths) > 1:
        raise PrintError("--object chooses from a single file", "give one model, or leave --object out")
    if paths[0].suffix.lower() != ".blend":
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    opened = [
        obj
        for path in paths
        for obj in _opened(path, object_names, turn_upright(path.suffix.lower(), up, rotate_deg), height_mm, scale)
    ]
    for other in bpy.context.view_layer.objects:
        other.select_set(other in opened)
    bpy.context.view_layer.objects.active = opened[0]
    bpy.context.view_layer.update()
    return opened


def check_file(path: Path, alone: bool) -> None:
    """Refuse a file that cannot be opened; `alone` says whether a .blend, which replaces all else, would do.

    Raises:
        PrintError: no such file, or an unknown kind.
        MeshError: it is empty, holds nothing, or would be read wrongly.
    """
    kind = path.suffix.lower()
    if kind not in UP_AXIS:
        hint = _OTHER_KINDS.get(kind, f"known kinds are {', '.join(UP_AXIS)}")
        what = "is of a kind that cannot be read" if kind in _OTHER_MODELS else "is not a model file"
        raise PrintError(f"{path} {what}", hint)
    if not os.path.isfile(path):
        raise PrintError(f"there is no file {path}")
    if not path.stat().st_size:
        raise MeshError(f"{path} is empty")
    if kind == ".stl" and path.stat().st_size <= _STL_HEAD_BYTES:
        raise MeshError(f"{path} holds no triangles", "export it again")
    check_head(path)
    if kind == ".blend" and not alone:
        raise PrintError(f"{path} cannot be opened beside other files", "print several of its objects with --object")


def _opened(
    path: Path, names: Sequence[str], turn: Matrix, height_mm: float | None, scale: float
) -> list[bpy.types.Object]:
    """The objects of one file that are to be printed."""
    imported = path.suffix.lower() != ".blend"
    found = import_objects(path) if imported else _opened_scene(path)
    chosen = [_named(path, found, name) for name in names] or printable(path, found, joined=imported)
    if imported or height_mm is not None or scale != 1 or turn != Matrix():
        groups = [[obj] for obj in chosen] if names else [chosen]
        titles = [group[0].name if names or not imported else title(path) for group in groups]
        chosen = [baked(group, turn, name) for group, name in zip(groups, titles, strict=True)]
    if height_mm is not None:
        scale = height_mm / _height(path, chosen)
    if scale != 1:
        _scale(chosen, scale)
    return chosen


def _opened_scene(path: Path) -> list[bpy.types.Object]:
    _read(path, ".blend")
    bpy.context.view_layer.update()
    return list(bpy.context.scene.objects)


def import_objects(path: Path) -> list[bpy.types.Object]:
    """The objects of a file that is not a .blend, added to the scene, which becomes one in millimeters.

    Raises:
        PrintError: Blender cannot read it.
    """
    former = set(bpy.context.scene.objects)
    bpy.context.scene.unit_settings.scale_length = 1.0  # the importer of glTF would take it into account
    _read(path, path.suffix.lower())
    use_millimeters(bpy.context.scene)
    bpy.context.view_layer.update()
    return [obj for obj in bpy.context.scene.objects if obj not in former]


def _read(path: Path, kind: str) -> None:
    """Open or import a file as it is, y and z not swapped (but glTF, which Blender's importer always turns)."""
    name = str(path.resolve())
    axes = {"forward_axis": "Y", "up_axis": "Z"}
    try:
        if kind == ".blend":
            bpy.ops.wm.open_mainfile(filepath=name, load_ui=False, use_scripts=False)
            return
        if kind == ".obj":
            with quiet_stderr():  # we report missing pictures ourselves
                bpy.ops.wm.obj_import(filepath=name, **axes)
        elif kind == ".stl":
            with legible(path.resolve()) as text:
                bpy.ops.wm.stl_import(filepath=str(text), **axes)
        elif kind == ".ply":
            bpy.ops.wm.ply_import(filepath=name, **axes)
        else:
            with quiet_stderr():  # its importer, written in Python, shows tracebacks
                bpy.ops.import_scene.gltf(filepath=name, disable_bone_shape=True)
    except RuntimeError as problem:  # how an operator tells that it has failed
        reason = str(problem).strip().splitlines()[0].removeprefix("Error: ")
        if reason.startswith("Python: "):  # a traceback of an importer that is written in it
            reason = "it is damaged"
        raise PrintError(f"Blender cannot read {path}", reason) from None


def turn_upright(kind: str, up: str, rotate_deg: Angles = UNTURNED) -> Matrix:
    """The rotation that makes a file of that kind stand upright after `_read`, and then turns it.

    Args:
        kind: suffix of the file.
        up: "y", "z" or "" for the usual axis.
        rotate_deg: about X, then Y, then Z.
    """
    up = up or UP_AXIS[kind]
    upright = "y" if kind in (".glb", ".gltf") else "z"
    turn = Matrix()
    if up != upright:
        sine = 1.0 if up == "y" else -1.0  # written out, for a cosine of 90° is not quite zero
        turn = Matrix(((1, 0, 0, 0), (0, 0, -sine, 0), (0, sine, 0, 0), (0, 0, 0, 1)))
    return rotation(rotate_deg) @ turn if any(rotate_deg) else turn


def rotation(degrees: Angles) -> Matrix:
    """About X, then about Y, then about Z."""
    return Euler([math.radians(angle) for angle in degrees], "XYZ").to_matrix().to_4x4()


def _named(path: Path, found: list[bpy.types.Object], name: str) -> bpy.types.Object:
    chosen = next((obj for obj in found if obj.name == name), None)
    if chosen is None:
        names = ", ".join(obj.name for obj in _meshes(found)[:10])
        raise PrintError(f"there is no object {name} in {path}", f"its meshes are {names}" if names else "")
    return chosen


def _meshes(found: list[bpy.types.Object]) -> list[bpy.types.Object]:
    return sorted((obj for obj in found if obj.type == "MESH"), key=lambda obj: obj.name)


def printable(path: Path, found: list[bpy.types.Object], joined: bool) -> list[bpy.types.Object]:
    """All visible meshes if they are to be joined, else the active one.

    Raises:
        MeshError: there is none.
        PrintError: there are several, none of them active.
    """
    meshes = [obj for obj in _meshes(found) if obj.visible_get()]
    if not meshes:
        raise MeshError(f"there is no mesh in {path}")
    if joined or len(meshes) == 1:
        return meshes
    active = bpy.context.view_layer.objects.active
    if active not in meshes:
        names = ", ".join(obj.name for obj in _meshes(found)[:10])
        raise PrintError(f"{path} holds several meshes", f"choose one with --object: {names}")
    return [active]


def baked(sources: list[bpy.types.Object], turn: Matrix, name: str) -> bpy.types.Object:
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


def _height(path: Path, objects: list[bpy.types.Object]) -> float:
    """Of objects without transform together, mm."""
    z = np.concatenate([positions(obj.data)[:, 2] for obj in objects])
    height = float(z.max() - z.min()) * mm_per_unit(bpy.context.scene)
    name = objects[0].name if len(objects) == 1 else str(path)
    if not math.isfinite(height):
        raise MeshError(f"{name} has vertices without finite coordinates", "repair the mesh")
    if height == 0:
        raise MeshError(f"{name} is flat", "it has no height to scale")
    return height


def _scale(objects: list[bpy.types.Object], factor: float) -> None:
    """Scale the meshes of objects without transform about the origin."""
    for obj in objects:
        obj.data.transform(Matrix.Scale(factor, 4))
        obj[SCALE_KEY] = factor
