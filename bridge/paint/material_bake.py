"""What the materials of an object show, as a picture: their nodes, baked by Cycles in a scene of its own."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import contextmanager

import bpy
import numpy as np

from ...core.model import Float32Array, FloatArray
from ...core.texture.decode import srgb_from_linear
from ..input.image_input import image_pixels
from ..input.mesh_input import evaluated_mesh
from ..input.printed_materials import printed_materials
from ..mesh_data import layer_uv
from .bake_scene import bake_into, bake_light, bake_scene, bake_target, working_in
from .painting import picture_size
from .unlit_materials import unlit_copy
from .unwrap import add_uv_map, check_unwrappable, has_room_for_every_face, smart_project

REPEATED = "modifiers repeat the UV map, so all that they repeat prints alike"


def material_bake_steps(
    obj: bpy.types.Object, texel_mm: float, background_tone: float, printer: str
) -> Generator[float, None, tuple[bpy.types.Image, str]]:
    """Make a packed picture of the colors that an object's materials show, without any light; yields the share done.

    It lies by the active UV map; where that has no place of its own for every face, by a new one that is made
    active. The materials stay as they are, and so does by which UV map they show their pictures.

    Args:
        obj: a mesh object with faces.
        texel_mm: greatest side of a texel on the surface.
        background_tone: what shows where the materials are transparent.
        printer: name of the one that prints it; larger objects count as large as it can print.

    Returns:
        The picture, and a sentence about what it cannot hold, empty if there is nothing.

    Raises:
        MeshError: the object has no faces, or no room for the UV map that it needs.
        PrintError: Cycles is off.
    """
    copy = obj.copy()
    copy.data = obj.data.copy()
    with bake_scene(copy) as scene:
        scene.frame_current = bpy.context.scene.frame_current
        _render_as_seen(copy)
        yield 0.05
        made_uv = _fitting_uv_map(obj, scene, copy)
        side = picture_size(copy, texel_mm, printer)
        repeated = _with_all_materials(scene, copy)
        yield 0.1
        with bake_target((side, side), background_tone) as target, _unlit(obj, copy, background_tone) as materials:
            for material in materials:
                bake_into(material, target)
            bake_light(scene, copy, copy.data.uv_layers.active.name)
            yield 0.9
            light = image_pixels(target)
    if made_uv is not None:
        add_uv_map(obj, made_uv)
    return _picture(f"{obj.name} Material", light), REPEATED if repeated else ""


def _picture(name: str, light: Float32Array) -> bpy.types.Image:
    """A packed picture of linear light (H, W, 4)."""
    pixels = np.ones_like(light)
    pixels[..., :3] = srgb_from_linear(np.clip(light[..., :3], 0.0, 1.0))
    made = bpy.data.images.new(name, light.shape[1], light.shape[0], alpha=False)
    made.pixels.foreach_set(pixels.ravel())
    made.pack()
    return made


def _render_as_seen(copy: bpy.types.Object) -> None:
    """Have the renderer see the object and its modifiers as the viewport does, which is what is printed."""
    copy.hide_render = copy.is_holdout = copy.is_shadow_catcher = False
    for modifier in copy.modifiers:
        modifier.show_render = modifier.show_viewport
        if modifier.type in ("SUBSURF", "MULTIRES"):
            modifier.render_levels = modifier.levels


def _fitting_uv_map(obj: bpy.types.Object, scene: bpy.types.Scene, copy: bpy.types.Object) -> FloatArray | None:
    """Give a mesh a UV map to bake by if the active one does not do; (C, 2) of each corner, None if it does."""
    layers = copy.data.uv_layers
    if layers and has_room_for_every_face(copy.data):
        return None
    check_unwrappable(obj)
    shown = next((layer.name for layer in layers if layer.active_render), "")
    with working_in(scene, copy):
        smart_project(copy)
    if shown:
        layers[shown].active_render = True
    return layer_uv(layers.active)


def _with_all_materials(scene: bpy.types.Scene, copy: bpy.types.Object) -> bool:
    """Apply the modifiers if Geometry Nodes give further materials, which are in no slot.

    Returns:
        Whether modifiers put faces on the places of others in a UV map that has a place for each.
    """
    if not any(modifier.show_viewport for modifier in copy.modifiers):
        return False
    with working_in(scene, copy):
        depsgraph = bpy.context.evaluated_depsgraph_get()
        with evaluated_mesh(copy, depsgraph) as mesh:
            repeated = bool(mesh.uv_layers) and not has_room_for_every_face(mesh)
            given = len(mesh.materials) > len(copy.material_slots)
        if given:
            former, evaluated = copy.data, copy.evaluated_get(depsgraph)
            copy.data = bpy.data.meshes.new_from_object(evaluated, preserve_all_data_layers=True, depsgraph=depsgraph)
            copy.modifiers.clear()
            bpy.data.meshes.remove(former)
    return repeated


@contextmanager
def _unlit(obj: bpy.types.Object, copy: bpy.types.Object, background: float) -> Iterator[list[bpy.types.Material]]:
    """The copy wears materials that shine in the colors of the object's own; they are removed afterwards."""
    printed = printed_materials(obj)
    printed += [slot.material for slot in copy.material_slots][len(printed) :]
    made = [unlit_copy(material, background) for material in printed]
    try:
        for slot, (material, _) in zip(copy.material_slots, made, strict=True):
            slot.link, slot.material = "OBJECT", material
        yield [material for material, _ in made]
    finally:
        for material, groups in made:
            bpy.data.materials.remove(material)
            for group in groups:
                bpy.data.node_groups.remove(group)
