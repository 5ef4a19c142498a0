"""Finds faults of a mesh that would spoil its print, and repairs them as far as possible."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from dataclasses import dataclass, field

import bmesh
import bpy
from mathutils import Matrix
from mathutils.bvhtree import BVHTree

from ..units import mm_per_unit

# Faces looked at between two signs of life.
_CHUNK = 20_000
# A ray starts this share of the wall's least thickness inside the face that it leaves.
_LIFT = 1e-3


@dataclass
class Findings:
    """Indices of faulty edges and faces.

    Attributes:
        open_edges: edges that bound a hole, or hang loose.
        branching_edges: edges where more than two faces meet.
        flipped_faces: faces whose neighbors look the other way, or all of them if the solid is inside out.
        crossing_faces: faces that pass through others.
        flat_faces: faces without an area.
        thin_faces: faces with another wall too near behind them.
    """

    open_edges: list[int] = field(default_factory=list)
    branching_edges: list[int] = field(default_factory=list)
    flipped_faces: list[int] = field(default_factory=list)
    crossing_faces: list[int] = field(default_factory=list)
    flat_faces: list[int] = field(default_factory=list)
    thin_faces: list[int] = field(default_factory=list)

    def counts(self) -> dict[str, int]:
        """How many of each kind were found."""
        return {kind: len(found) for kind, found in vars(self).items()}


TITLES = {
    "open_edges": "Open edges",
    "branching_edges": "Branching edges",
    "flipped_faces": "Flipped faces",
    "crossing_faces": "Crossing faces",
    "flat_faces": "Faces without area",
    "thin_faces": "Thin walls",
}
"""What each kind of finding is called."""
MEANINGS = {
    "open_edges": "edges of one face only, at the border of a hole",
    "branching_edges": "edges of more than two faces, where inside and outside are not told apart",
    "flipped_faces": "faces that look inwards",
    "crossing_faces": "faces that cross others; overlapping parts print as one",
    "flat_faces": "faces without an area",
    "thin_faces": "faces of walls that are thinner than two lines",
}
"""What each title means, for those who see it for the first time."""


def check_steps(obj: bpy.types.Object, least_wall_mm: float) -> Generator[float, None, Findings]:
    """Look for faults; yields the share done.

    Args:
        obj: a mesh object; modifiers are not looked at, since what they make cannot be selected.
        least_wall_mm: thinner walls are found.
    """
    mesh = bmesh.new()
    try:
        mesh.from_mesh(obj.data)
        _place(mesh, obj.matrix_world)
        for table in (mesh.verts, mesh.edges, mesh.faces):
            table.ensure_lookup_table()
        found = Findings()
        found.open_edges = [edge.index for edge in mesh.edges if len(edge.link_faces) < 2]
        found.branching_edges = [edge.index for edge in mesh.edges if len(edge.link_faces) > 2]
        found.flat_faces = [face.index for face in mesh.faces if face.calc_area() < 1e-12]
        found.flipped_faces = _flipped(mesh)
        yield 0.1
        tree = BVHTree.FromBMesh(mesh)
        found.crossing_faces = _crossing(mesh, tree)
        yield 0.4
        least = least_wall_mm / mm_per_unit(bpy.context.scene)
        yield from _look_for_thin_walls(mesh, tree, least, set(found.flat_faces), found.thin_faces)
        return found
    finally:
        mesh.free()


def select(obj: bpy.types.Object, kind: str, found: Findings) -> None:
    """Enter Edit Mode with only one kind of finding selected."""
    is_edge = kind.endswith("edges")
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.tool_settings.mesh_select_mode = (False, is_edge, not is_edge)
    bpy.ops.mesh.reveal(select=False)
    bpy.ops.mesh.select_all(action="DESELECT")
    mesh = bmesh.from_edit_mesh(obj.data)
    table = mesh.edges if is_edge else mesh.faces
    table.ensure_lookup_table()
    for index in getattr(found, kind):
        table[index].select_set(True)
    bmesh.update_edit_mesh(obj.data)


def repair(obj: bpy.types.Object, merge_mm: float, largest_hole_sides: int) -> str:
    """Merge vertices, drop flat and loose parts, fill holes, turn faces outwards; returns a sentence on what was done.

    Args:
        obj: a mesh object in Object Mode.
        merge_mm: vertices nearer than this become one.
        largest_hole_sides: holes with more edges stay open; 0 fills all.
    """
    scale = abs(obj.matrix_world.to_3x3().determinant()) ** (1 / 3) * mm_per_unit(bpy.context.scene)
    mesh = bmesh.new()
    try:
        mesh.from_mesh(obj.data)
        before = len(mesh.verts)
        bmesh.ops.remove_doubles(mesh, verts=mesh.verts, dist=merge_mm / (scale or 1.0))
        merged = before - len(mesh.verts)
        bmesh.ops.dissolve_degenerate(mesh, dist=1e-9, edges=mesh.edges)
        loose = [vertex for vertex in mesh.verts if not vertex.link_faces]
        bmesh.ops.delete(mesh, geom=loose, context="VERTS")
        borders = [edge for edge in mesh.edges if edge.is_boundary]
        filled = len(bmesh.ops.holes_fill(mesh, edges=borders, sides=largest_hole_sides)["faces"])
        bmesh.ops.recalc_face_normals(mesh, faces=mesh.faces)
        mesh.to_mesh(obj.data)
    finally:
        mesh.free()
    obj.data.update()
    return f"{merged} vertices merged, {len(loose)} loose ones removed, {filled} holes filled, faces turned outwards"


def _place(mesh: bmesh.types.BMesh, matrix: Matrix) -> None:
    """Move a mesh to where its object stands, its faces looking out of a mirrored one as they are printed."""
    mesh.transform(matrix)
    if matrix.determinant() < 0:
        bmesh.ops.reverse_faces(mesh, faces=mesh.faces)
    mesh.normal_update()  # the transform leaves the normals as they were


def _flipped(mesh: bmesh.types.BMesh) -> list[int]:
    """Faces that Recalculate Outside would turn."""
    copy = mesh.copy()
    try:
        copy.faces.ensure_lookup_table()
        bmesh.ops.recalc_face_normals(copy, faces=copy.faces)
        return [face.index for face in mesh.faces if face.normal.dot(copy.faces[face.index].normal) < 0]
    finally:
        copy.free()


def _crossing(mesh: bmesh.types.BMesh, tree: BVHTree) -> list[int]:
    """Faces that overlap another one with which they share no vertex."""
    crossing: set[int] = set()
    for a, b in tree.overlap(tree):
        if a < b and not set(mesh.faces[a].verts) & set(mesh.faces[b].verts):
            crossing.update((a, b))
    return sorted(crossing)


def _look_for_thin_walls(
    mesh: bmesh.types.BMesh, tree: BVHTree, least: float, flat: Iterable[int], thin: list[int]
) -> Generator[float, None, None]:
    """Cast a ray inwards from the middle of every face; a wall that it hits too soon, from inside, is thin."""
    for face in mesh.faces:
        if face.index % _CHUNK == _CHUNK - 1:
            yield 0.4 + 0.6 * face.index / len(mesh.faces)
        if face.index in flat:
            continue
        start = face.calc_center_median() - face.normal * (least * _LIFT)
        _, normal, hit, _ = tree.ray_cast(start, -face.normal, least * (1.0 - _LIFT))
        if hit is not None and hit != face.index and normal.dot(face.normal) < 0:
            thin.append(face.index)
