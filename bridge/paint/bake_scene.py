"""A scene of its own in which Cycles bakes one object."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from ...core.errors import PrintError

MARGIN = 8
"""Texels by which colors go on beyond a chart."""


@contextmanager
def bake_scene(copy: bpy.types.Object) -> Iterator[bpy.types.Scene]:
    """A scene with an object, its world and nothing else; scene, object and the object's mesh are removed afterwards.

    Raises:
        PrintError: Blender's add-on Cycles is off.
    """
    scene, world = bpy.data.scenes.new(copy.name), bpy.data.worlds.new(copy.name)
    try:
        scene.collection.objects.link(copy)
        scene.world = world
        try:
            scene.render.engine = "CYCLES"
        except TypeError:  # no such name in the list
            raise PrintError("Cycles is off", "turn on Cycles Render Engine in Preferences > Add-ons") from None
        yield scene
    finally:
        mesh = copy.data
        bpy.data.objects.remove(copy)
        bpy.data.scenes.remove(scene)
        bpy.data.worlds.remove(world)
        bpy.data.meshes.remove(mesh)


@contextmanager
def working_in(scene: bpy.types.Scene, copy: bpy.types.Object) -> Iterator[None]:
    """Operators in the block work on the object of a bake scene."""
    layer = scene.view_layers[0]
    layer.objects.active = copy
    copy.select_set(True, view_layer=layer)
    layer.update()
    with bpy.context.temp_override(
        scene=scene, view_layer=layer, object=copy, active_object=copy, selected_objects=[copy],
        selected_editable_objects=[copy],
    ):  # fmt: skip
        yield


def bake(scene: bpy.types.Scene, copy: bpy.types.Object, **options: object) -> None:
    """Bake the object of a bake scene, with the options of Blender's own operator."""
    with working_in(scene, copy):
        bpy.ops.object.bake(**options)


def bake_light(scene: bpy.types.Scene, copy: bpy.types.Object, uv_map: str = "") -> None:
    """Bake what the object's materials emit into their targets; without that UV map, by the active one."""
    scene.cycles.samples = 1  # the center of each texel; they are finer than what is printed
    layer = uv_map if uv_map in copy.data.uv_layers else ""
    bake(scene, copy, type="EMIT", uv_layer=layer, margin=MARGIN, margin_type="EXTEND", use_clear=False)


@contextmanager
def bake_target(size: tuple[int, int], tone: float) -> Iterator[bpy.types.Image]:
    """A float image for linear light, of one tone between the charts; it is removed afterwards."""
    image = bpy.data.images.new("Baked", *size, float_buffer=True, is_data=True)
    image.generated_color = (tone, tone, tone, 1.0)
    try:
        yield image
    finally:
        bpy.data.images.remove(image)


def bake_into(material: bpy.types.Material, image: bpy.types.Image) -> None:
    """Have a material bake into an image."""
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    material.node_tree.nodes.active = node
