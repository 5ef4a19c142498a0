"""Ambient occlusion of an object: the darkness of its hollows, baked by Cycles in a scene of its own."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import contextmanager

import bmesh
import bpy
import numpy as np

from ...core.errors import MeshError, TextureError
from ...core.model import Float32Array
from ...core.progress import drained
from ...core.texture.decode import linear_from_srgb, srgb_from_linear
from ...core.texture.grade import bands
from ..input.image_input import image_pixels, is_encoded
from ..input.mesh_input import NO_FACES_HINT
from ..materials import new_material
from ..units import mm_per_unit

SAMPLES = 20
DISTANCE_MM = 25.0
_NAME = "Ambient occlusion"  # of all that is made for it
_ATTRIBUTE = "Occlusion"
_LEAST_VERTICES = 5_000  # coarser meshes are cut finer: occlusion is found at vertices, which is quick
_MARGIN = 8


def occlusion_steps(
    obj: bpy.types.Object,
    size: tuple[int, int],
    distance_mm: float = DISTANCE_MM,
    samples: int = SAMPLES,
    uv_map: str = "",
) -> Generator[float, None, Float32Array]:
    """Bake ambient occlusion for one of the object's UV maps; yields the share that is done.

    It is baked for each vertex and carried from there to the texels. The object is copied with its modifiers; it and
    its scene are not touched, and no other object darkens it.

    Args:
        obj: an object with a surface and a UV map.
        size: width and height in texels.
        distance_mm: surfaces farther away than this darken nothing.
        samples: rays for each vertex.
        uv_map: name of the UV map, "" for the active one.

    Returns:
        (H, W) light that arrives: 1 in the open, 0 where there is none.

    Raises:
        MeshError: there are no faces.
        TextureError: there is no UV map.
    """
    with _set_up(obj, size, distance_mm) as (scene, copy, image):
        if uv_map in copy.data.uv_layers:
            copy.data.uv_layers[uv_map].active = True
        yield 0.1
        scene.cycles.samples = samples
        _bake(scene, copy, type="AO", target="VERTEX_COLORS")
        yield 0.7
        scene.cycles.samples = 1
        _bake(scene, copy, type="EMIT", margin=_MARGIN, margin_type="EXTEND", use_clear=False)
        pixels = np.empty(size[0] * size[1] * 4, dtype=np.float32)
        image.pixels.foreach_get(pixels)
        return np.clip(pixels.reshape(size[1], size[0], 4)[..., 0], 0.0, 1.0)


def occlusion(
    obj: bpy.types.Object, size: tuple[int, int], distance_mm: float = DISTANCE_MM, samples: int = SAMPLES
) -> Float32Array:
    """What `occlusion_steps` returns, all at once."""
    return drained(occlusion_steps(obj, size, distance_mm, samples))


def darkened(image: bpy.types.Image, shade: Float32Array, strength: float) -> bpy.types.Image:
    """A new, packed picture: another one multiplied with occlusion in linear light; alpha stays.

    Args:
        image: is kept.
        shade: (H, W) from `occlusion_steps`, of the picture's size.
        strength: 0 darkens nothing, 1 by all of it.

    Raises:
        TextureError: the picture has no pixels, or another size.
    """
    pixels = image_pixels(image)
    if pixels.shape[:2] != shade.shape:
        raise TextureError(f"the image {image.name} was resized while it was worked on", "start again")
    colors = pixels[..., : 3 if pixels.shape[2] > 2 else 1]
    encoded = is_encoded(image)
    for band in bands(pixels):
        light = (1.0 - strength * (1.0 - shade[band]))[..., None]
        lit = linear_from_srgb(colors[band]) if encoded else colors[band]
        colors[band] = srgb_from_linear(lit * light) if encoded else lit * light
    made = image.copy()
    made.name = f"{image.name} Occlusion"
    made.pixels.foreach_set(pixels.ravel())
    made.pack()
    return made


@contextmanager
def _set_up(
    obj: bpy.types.Object, size: tuple[int, int], distance_mm: float
) -> Iterator[tuple[bpy.types.Scene, bpy.types.Object, bpy.types.Image]]:
    """A scene with only a copy of the object, and the picture that it bakes into; both are removed afterwards."""
    copy, unit = _fine_copy(obj), mm_per_unit(bpy.context.scene)
    scene, world = bpy.data.scenes.new(_NAME), bpy.data.worlds.new(_NAME)
    material = new_material(_NAME)
    image = bpy.data.images.new(_NAME, *size, float_buffer=True, is_data=True)
    image.generated_color = (1.0, 1.0, 1.0, 1.0)  # between the charts
    try:
        if not copy.data.uv_layers:
            raise TextureError(f"{obj.name} has no UV map", "unwrap it first")
        scene.collection.objects.link(copy)
        scene.world = world
        world.light_settings.distance = distance_mm / unit
        scene.render.engine = "CYCLES"
        _dress(copy, material, image)
        yield scene, copy, image
    finally:
        mesh = copy.data
        bpy.data.objects.remove(copy)
        bpy.data.scenes.remove(scene)
        bpy.data.meshes.remove(mesh)
        bpy.data.materials.remove(material)
        bpy.data.images.remove(image)
        bpy.data.worlds.remove(world)


def _fine_copy(obj: bpy.types.Object) -> bpy.types.Object:
    """The object as it is printed, without materials, cut finer if it has few vertices; in no scene.

    Raises:
        MeshError: there are no faces.
    """
    depsgraph = bpy.context.evaluated_depsgraph_get()
    mesh = bpy.data.meshes.new_from_object(
        obj.evaluated_get(depsgraph), preserve_all_data_layers=True, depsgraph=depsgraph
    )
    if not len(mesh.polygons):
        bpy.data.meshes.remove(mesh)
        raise MeshError(f"{obj.name} has no faces", NO_FACES_HINT)
    mesh.materials.clear()
    work = bmesh.new()
    work.from_mesh(mesh)
    bmesh.ops.triangulate(work, faces=work.faces)
    while len(work.verts) < _LEAST_VERTICES:
        bmesh.ops.subdivide_edges(work, edges=work.edges, cuts=1, use_grid_fill=True)
    work.to_mesh(mesh)
    work.free()
    copy = bpy.data.objects.new(_NAME, mesh)
    copy.matrix_world = obj.matrix_world
    return copy


def _dress(copy: bpy.types.Object, material: bpy.types.Material, image: bpy.types.Image) -> None:
    """A material that shines by the attribute that occlusion is baked to, and bakes into the image."""
    attribute = copy.data.color_attributes.new(_ATTRIBUTE, "FLOAT_COLOR", "POINT")
    copy.data.color_attributes.active_color = attribute
    tree = material.node_tree
    tree.nodes.clear()
    color, emission, output, target = (
        tree.nodes.new(f"ShaderNode{kind}") for kind in ("VertexColor", "Emission", "OutputMaterial", "TexImage")
    )
    color.layer_name = _ATTRIBUTE
    target.image = image
    tree.links.new(color.outputs["Color"], emission.inputs["Color"])
    tree.links.new(emission.outputs["Emission"], output.inputs["Surface"])
    tree.nodes.active = target
    copy.data.materials.append(material)


def _bake(scene: bpy.types.Scene, copy: bpy.types.Object, **options: object) -> None:
    layer = scene.view_layers[0]
    layer.objects.active = copy
    copy.select_set(True, view_layer=layer)
    layer.update()
    with bpy.context.temp_override(
        scene=scene, view_layer=layer, object=copy, active_object=copy, selected_objects=[copy],
        selected_editable_objects=[copy],
    ):  # fmt: skip
        bpy.ops.object.bake(**options)
