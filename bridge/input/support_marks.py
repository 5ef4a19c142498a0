"""Support enforcers and blockers in Blender: a whole number on each face, and objects in collections."""

from __future__ import annotations

import bpy

# isort: split
import bmesh  # found only once bpy is there

from ...core.model import SupportMark, SupportVolume
from ..units import mm_per_unit
from .mesh_input import SUPPORT_ATTRIBUTE, evaluated_mesh, polygon_corners, world_vertices

COLLECTIONS = {SupportMark.ENFORCER: "support_enforcers", SupportMark.BLOCKER: "support_blockers"}
"""Properties of an object that name the collections of its volumes."""


def mark_selected_faces(mesh: bpy.types.Mesh, mark: SupportMark) -> int:
    """Mark the selected faces of a mesh in Edit Mode; returns how many there are."""
    edited = bmesh.from_edit_mesh(mesh)
    layer = edited.faces.layers.int.get(SUPPORT_ATTRIBUTE) or edited.faces.layers.int.new(SUPPORT_ATTRIBUTE)
    chosen = [face for face in edited.faces if face.select]
    for face in chosen:
        face[layer] = int(mark)
    bmesh.update_edit_mesh(mesh, loop_triangles=False, destructive=False)
    return len(chosen)


def select_marked_faces(mesh: bpy.types.Mesh, mark: SupportMark) -> int:
    """Select the faces with this mark, and no others, of a mesh in Edit Mode; returns how many there are."""
    edited = bmesh.from_edit_mesh(mesh)
    layer = edited.faces.layers.int.get(SUPPORT_ATTRIBUTE)
    chosen = {face for face in edited.faces if layer is not None and not face.hide and face[layer] == mark}
    for face in edited.faces:
        face.select_set(False)
    for face in chosen:
        face.select_set(True)
    edited.select_flush_mode()
    bmesh.update_edit_mesh(mesh, loop_triangles=False, destructive=False)
    return len(chosen)


def volume_objects(obj: bpy.types.Object) -> dict[str, tuple[bpy.types.Object, SupportMark]]:
    """The meshes in an object's two collections, by name."""
    found = {}
    for mark, name in COLLECTIONS.items():
        collection = getattr(getattr(obj, "dualcolor", None), name, None)
        for member in collection.all_objects if collection else ():
            if member.type == "MESH" and member != obj:
                found[member.name] = (member, mark)
    return dict(sorted(found.items()))


def support_volume(obj: bpy.types.Object, mark: SupportMark, depsgraph: bpy.types.Depsgraph) -> SupportVolume:
    """An object as a volume, as it stands in the scene, in mm.

    Raises:
        MeshError: it has no faces.
    """
    with evaluated_mesh(obj, depsgraph) as mesh:
        start, vertex = polygon_corners(mesh)
        vertices = world_vertices(mesh, obj.evaluated_get(depsgraph), mm_per_unit(depsgraph.scene))
    return SupportVolume(mark, vertices, start, vertex, obj.name)
