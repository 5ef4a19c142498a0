"""Ambient occlusion of an object: the darkness of its hollows, baked by Cycles in a scene of its own."""

from __future__ import annotations

from collections.abc import Generator

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
from .bake_scene import bake, bake_into, bake_light, bake_scene, bake_target

SAMPLES = 20
DISTANCE_MM = 25.0
_NAME = "Ambient occlusion"  # of all that is made for it
_ATTRIBUTE = "Occlusion"
_LEAST_VERTICES = 5_000  # coarser meshes are cut finer: occlusion is found at vertices, which is quick


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
    copy, unit = _fine_copy(obj), mm_per_unit(bpy.context.scene)
    with bake_scene(copy) as scene, bake_target(size, 1.0) as image:
        if not copy.data.uv_layers:
            raise TextureError(f"{obj.name} has no UV map", "unwrap it first")
        scene.world.light_settings.distance = distance_mm / unit
        material = _dress(copy)
        try:
            bake_into(material, image)
            yield 0.1
            scene.cycles.samples = samples
            bake(scene, copy, type="AO", target="VERTEX_COLORS")
            yield 0.7
            bake_light(scene, copy, uv_map)
        finally:
            bpy.data.materials.remove(material)
        return np.clip(image_pixels(image)[..., 0], 0.0, 1.0)


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


def _dress(copy: bpy.types.Object) -> bpy.types.Material:
    """Give the copy a material that shines by the attribute that occlusion is baked to."""
    attribute = copy.data.color_attributes.new(_ATTRIBUTE, "FLOAT_COLOR", "POINT")
    copy.data.color_attributes.active_color = attribute
    material = new_material(_NAME)
    tree = material.node_tree
    tree.nodes.clear()
    color, emission, output = (
        tree.nodes.new(f"ShaderNode{kind}") for kind in ("VertexColor", "Emission", "OutputMaterial")
    )
    color.layer_name = _ATTRIBUTE
    tree.links.new(color.outputs["Color"], emission.inputs["Color"])
    tree.links.new(emission.outputs["Emission"], output.inputs["Surface"])
    copy.data.materials.append(material)
    return material
