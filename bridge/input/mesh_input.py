"""A Blender object as the job's input: world-space polygons in mm with their UVs, tones and textures."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import field

import bpy
import numpy as np

from ...core.errors import MeshError, TextureError
from ...core.model import BoolArray, FloatArray, IntArray, SurfaceModel, ToneImage
from ...core.records import dataclass
from ...core.settings import PrintSettings
from ...core.texture.decode import color_tone
from ..mesh_data import corner_vertices, in_world, layer_uv, positions
from ..units import mm_per_unit
from .base_color import BaseColor, base_color, chosen_color, color_layer, ignored_note, picture_layer
from .image_input import image_tone
from .metaballs import metaball_of
from .printed_materials import printed_materials
from .seam_visibility import painted_visibility

WITH_SURFACE = ("MESH", "CURVE", "SURFACE", "FONT", "META")
SUPPORT_ATTRIBUTE = "dualcolor_support"
"""Whole number of each face: above 0 it enforces supports, below 0 it blocks them."""
NO_FACES_HINT = "choose a mesh with a closed surface; instances need Geometry Nodes' Realize Instances"
MAKE_REAL = "Object > Apply > Make Instances Real"
CURVE_HINT = "give the curve an Extrude or a Bevel (Object Data > Geometry)"
UNWRAP_HINT = "unwrap it first (in Blender: Paint > Smart UV Project; on the command line: --unwrap smart)"


def surface_model(
    obj: bpy.types.Object,
    depsgraph: bpy.types.Depsgraph,
    settings: PrintSettings,
    image: bpy.types.Image | None = None,
) -> SurfaceModel:
    """An object as it stands in the scene: modifiers, shape keys and transform applied, in mm.

    Tone comes from `image` if it is given, else from the images of the materials, else from the active color
    attribute, else it is left to `settings.background_tone`.

    Args:
        obj: the object to print.
        depsgraph: evaluated, of the scene that the object is in.
        settings: for the background tone, and what says where seams are seen.
        image: the picture chosen by the user; it covers the whole object.

    Raises:
        MeshError: the object has no surface.
        SettingsError: what shall say where seams are seen is not there.
        TextureError: a picture is missing or there is no UV map for it.
    """
    with evaluated_mesh(obj, depsgraph) as mesh:
        corners = _Corners.of(mesh)
        colors = _material_colors(obj, mesh)
        colors = [chosen_color(colors, image, mesh)] if image else colors
        slot = np.zeros(len(mesh.polygons), dtype=np.int64) if image else _material_slots(mesh, len(colors))
        uv = _corner_uv(mesh, obj.name, corners, colors, slot)
        tone = _corner_tone(mesh, corners, colors, slot, settings.background_tone)
        textures, polygon_texture = _textures(colors, slot)
        support = _face_marks(mesh)
        notes = _notes(obj, mesh, depsgraph, [colors[number] for number in np.unique(slot).tolist()])
        weights, shown = painted_visibility(obj, mesh, settings.seam_visibility)
        vertices = world_vertices(mesh, obj.evaluated_get(depsgraph), mm_per_unit(depsgraph.scene))
    order = corners.outward(mirrored=obj.evaluated_get(depsgraph).matrix_world.determinant() < 0)
    return SurfaceModel(
        vertices=vertices,
        polygon_start=corners.start,
        corner_vertex=corners.vertex[order],
        corner_uv=None if uv is None else uv[order],
        corner_tone=None if tone is None else tone[order],
        polygon_texture=polygon_texture,
        textures=(*textures, shown) if shown else textures,
        name=obj.name,
        polygon_support=support,
        corner_visibility=None if weights is None else weights[corners.vertex][order],
        polygon_visibility=np.full(len(polygon_texture), len(textures), dtype=np.int64) if shown else None,
        notes=notes,
    )


@contextmanager
def evaluated_mesh(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Iterator[bpy.types.Mesh]:
    """The mesh of an object with its modifiers applied, in object space, for as long as the block runs.

    Raises:
        MeshError: the object is of a kind without a surface, has no faces, is being sculpted, or disabled.
    """
    if obj.type not in WITH_SURFACE:
        raise MeshError(f"{obj.name} has no surface to print", "choose a mesh object")
    if obj.mode == "SCULPT":  # the modifier Multiresolution is left out, and Dynamic Topology keeps its own mesh
        raise MeshError(f"{obj.name} is in Sculpt Mode", "leave it first, since its strokes are in the mesh only then")
    if obj.mode == "EDIT":
        obj.update_from_editmode()
        depsgraph.update()
    evaluated = obj.evaluated_get(depsgraph)
    try:
        evaluated.evaluated_geometry()
    except TypeError:  # how Blender tells that it leaves the object out
        raise _left_out(obj, depsgraph) from None
    mesh = evaluated.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph)
    try:
        if mesh is None or not len(mesh.polygons):
            raise _no_faces(obj, depsgraph.scene)
        yield mesh
    finally:
        evaluated.to_mesh_clear()


def _left_out(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> MeshError:
    """Why Blender does not evaluate an object; strands may be active whose object is somewhere else."""
    if obj not in depsgraph.scene.objects.values():
        return MeshError(f"{obj.name} is not in this scene", "choose its scene, or add it to a collection of this one")
    if obj not in depsgraph.view_layer.objects.values():
        return MeshError(f"{obj.name} is in an excluded collection", "check the box of the collection in the outliner")
    hint = "turn on the screen icon of the object, or of its collection, in the outliner"
    return MeshError(f"{obj.name} is disabled in viewports", hint)


def _no_faces(obj: bpy.types.Object, scene: bpy.types.Scene) -> MeshError:
    whole = metaball_of(obj, scene)
    if whole.name != obj.name:
        return MeshError(f"{obj.name} is a part of the metaball {whole.name}", "choose that one: it has the surface")
    return MeshError(f"{obj.name} has no faces", CURVE_HINT if obj.type == "CURVE" else NO_FACES_HINT)


def _notes(
    obj: bpy.types.Object, mesh: bpy.types.Mesh, depsgraph: bpy.types.Depsgraph, colors: list[BaseColor]
) -> tuple[str, ...]:
    """Warnings about what is visible on an object but does not print: parts not in its mesh, colors made by nodes."""
    notes = [note for note in (ignored_note(color, mesh) for color in colors) if note]
    if obj.evaluated_get(depsgraph).evaluated_geometry().instances_pointcloud() is not None:
        realize = "Geometry Nodes' Realize Instances" if obj.instance_type == "NONE" else MAKE_REAL
        notes.append(f"instances on {obj.name} are not printed: use {realize}")
    return tuple(dict.fromkeys(notes))


@dataclass(frozen=True)
class _Corners:
    """Polygon corners: `start` (P + 1,), `vertex` (C,) and `polygon` (C,), the polygon of each corner."""

    start: IntArray
    vertex: IntArray
    polygon: IntArray = field(repr=False)

    @staticmethod
    def of(mesh: bpy.types.Mesh) -> _Corners:
        count = len(mesh.loops)
        start = np.empty(len(mesh.polygons), dtype=np.int32)
        mesh.polygons.foreach_get("loop_start", start)
        bounds = np.append(start, count).astype(np.int64)
        return _Corners(bounds, corner_vertices(mesh), np.repeat(np.arange(len(start)), np.diff(bounds)))

    def outward(self, mirrored: bool) -> IntArray:
        """(C,) the order of the corners in which faces look outward; a mirrored object turns every polygon around."""
        index = np.arange(len(self.vertex))
        if not mirrored:
            return index
        return self.start[self.polygon] + self.start[self.polygon + 1] - 1 - index


def _face_marks(mesh: bpy.types.Mesh) -> IntArray | None:
    """(P,) the `SupportMark` of each polygon; None where there is none."""
    attribute = mesh.attributes.get(SUPPORT_ATTRIBUTE)
    if attribute is None or attribute.domain != "FACE" or attribute.data_type != "INT":
        return None
    values = np.zeros(len(mesh.polygons), dtype=np.int32)
    attribute.data.foreach_get("value", values)
    marks: IntArray = np.sign(values).astype(np.int64)
    return marks if marks.any() else None


def polygon_corners(mesh: bpy.types.Mesh) -> tuple[IntArray, IntArray]:
    """(P + 1,) where each polygon's corners start, and (C,) the vertex of each corner."""
    corners = _Corners.of(mesh)
    return corners.start, corners.vertex


def world_vertices(mesh: bpy.types.Mesh, evaluated: bpy.types.Object, mm: float) -> FloatArray:
    """(V, 3) mm in the world, of an evaluated object's mesh; `mm` is the length of a unit."""
    with np.errstate(invalid="ignore"):  # vertices at infinity are refused later
        return in_world(positions(mesh).astype(np.float64), np.array(evaluated.matrix_world)) * mm


def _material_colors(obj: bpy.types.Object, mesh: bpy.types.Mesh) -> list[BaseColor]:
    """One entry per material slot, at least one."""
    slots = printed_materials(obj)
    slots += list(mesh.materials)[len(slots) :]  # that Geometry Nodes give
    return [base_color(material) for material in slots] or [BaseColor()]


def _material_slots(mesh: bpy.types.Mesh, slots: int) -> IntArray:
    index = np.zeros(len(mesh.polygons), dtype=np.int32)
    mesh.polygons.foreach_get("material_index", index)
    return np.clip(index.astype(np.int64), 0, slots - 1)


def _textures(colors: list[BaseColor], slot: IntArray) -> tuple[tuple[ToneImage, ...], IntArray]:
    """The pictures that polygons use, each once, and which one each polygon uses."""
    used = set(np.unique(slot).tolist())
    images: list[bpy.types.Image] = []
    of_slot = np.full(len(colors), -1, dtype=np.int64)
    for number, color in enumerate(colors):
        if color.image is None or number not in used:
            continue
        if color.image not in images:
            images.append(color.image)
        of_slot[number] = images.index(color.image)
    return tuple(image_tone(image) for image in images), of_slot[slot]


def _corner_uv(
    mesh: bpy.types.Mesh, name: str, corners: _Corners, colors: list[BaseColor], slot: IntArray
) -> FloatArray | None:
    """(C, 2) from the UV map with which each material's picture is displayed; None if there is none."""
    if not mesh.uv_layers:
        pictured = next((color.image for color in colors if color.image), None)
        if pictured:
            raise TextureError(f"{name} has no UV map for the image {pictured.name}", UNWRAP_HINT)
        return None
    active = mesh.uv_layers.active
    uv = layer_uv(active)
    for number, color in enumerate(colors):
        layer = picture_layer(color, mesh)
        if color.image and layer.name != active.name:
            chosen = slot[corners.polygon] == number
            uv[chosen] = layer_uv(layer)[chosen]
    return uv


def _corner_tone(
    mesh: bpy.types.Mesh, corners: _Corners, colors: list[BaseColor], slot: IntArray, background: float
) -> FloatArray | None:
    """(C,) tone of corners without a picture, NaN elsewhere; None if only pictures and background give tones.

    Without a picture on the object that is the active color attribute. Beside materials with a picture, plain
    ones show their own color.
    """
    pictured = any(color.image for color in colors)
    tone = np.full(len(corners.vertex), np.nan)
    for number, color in enumerate(colors):
        chosen: BoolArray = slot[corners.polygon] == number
        if color.image or not chosen.any():
            continue
        layer = color_layer(color, mesh, pictured)
        if layer is not None:
            tone[chosen] = color_tone(_layer_color(layer, corners)[chosen], background)
        elif pictured and color.color:
            tone[chosen] = color_tone(np.array([color.color], dtype=np.float64), background)[0]
    return None if np.isnan(tone).all() else tone


def _layer_color(layer: bpy.types.Attribute, corners: _Corners) -> FloatArray:
    """(C, 4) linear color of a color attribute."""
    rgba = np.empty(len(layer.data) * 4, dtype=np.float32)
    layer.data.foreach_get("color", rgba)  # linear for byte colors too
    linear = rgba.reshape(-1, 4).astype(np.float64)
    return linear[corners.vertex] if layer.domain == "POINT" else linear
