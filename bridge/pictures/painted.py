"""The model with its own tones as paint, to be compared with the predicted print."""

from __future__ import annotations

import math

import bpy
import numpy as np

from ...core.model import SurfaceModel, ToneImage
from ..materials import principled
from .plastics import REFLECTANCE, diffuse_material

_SHARP_RAD = math.radians(40.0)
_TONE = "tone"


def painted_model(model: SurfaceModel, background: float, scale: float) -> bpy.types.Object:
    """A mesh whose surface has the tones to be printed, as reflectances between those of both filaments.

    The object is not linked to any collection yet; it stands where the model stands.

    Args:
        model: what is printed.
        background: tone where nothing is painted.
        scale: units of the scene a mm.
    """
    mesh = _mesh(model, scale)
    tone = mesh.attributes.new(_TONE, "FLOAT", "CORNER")
    given = model.corner_tone if model.corner_tone is not None else np.full(len(model.corner_vertex), background)
    tone.data.foreach_set("value", np.nan_to_num(given, nan=background).astype(np.float32))
    mesh.materials.append(_paint(mesh.name, None, background))
    for picture in model.textures:
        mesh.materials.append(_paint(mesh.name, picture, background))
    mesh.polygons.foreach_set("material_index", (model.polygon_texture + 1).astype(np.int32))
    return bpy.data.objects.new(mesh.name, mesh)


def _mesh(model: SurfaceModel, scale: float) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new("Painted")
    mesh.vertices.add(len(model.vertices))
    mesh.vertices.foreach_set("co", (model.vertices * scale).astype(np.float32).ravel())
    mesh.loops.add(len(model.corner_vertex))
    mesh.loops.foreach_set("vertex_index", model.corner_vertex.astype(np.int32))
    mesh.polygons.add(len(model.polygon_start) - 1)
    mesh.polygons.foreach_set("loop_start", model.polygon_start[:-1].astype(np.int32))
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), dtype=bool))
    if model.corner_uv is not None:
        mesh.uv_layers.new(name="UVMap").uv.foreach_set("vector", model.corner_uv.astype(np.float32).ravel())
    mesh.update(calc_edges=True)
    mesh.set_sharp_from_angle(angle=_SHARP_RAD)
    return mesh


def _paint(name: str, picture: ToneImage | None, background: float) -> bpy.types.Material:
    """A matt material whose reflectance is the tone of a picture, or of the corners."""
    material = diffuse_material(name, REFLECTANCE["White"], 1.0, 1.0)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    if picture is None:
        source = nodes.new("ShaderNodeAttribute")
        source.attribute_name = _TONE
        tone = source.outputs["Fac"]
    else:
        source = nodes.new("ShaderNodeTexImage")
        source.image = _image(name, picture, background)
        tone = source.outputs["Color"]
    reflectance = nodes.new("ShaderNodeMapRange")
    reflectance.inputs["To Min"].default_value = REFLECTANCE["Black"]
    reflectance.inputs["To Max"].default_value = REFLECTANCE["White"]
    links.new(tone, reflectance.inputs["Value"])
    links.new(reflectance.outputs["Result"], principled(material).inputs["Base Color"])
    return material


def _image(name: str, picture: ToneImage, background: float) -> bpy.types.Image:
    tone = picture.alpha * picture.tone + (1 - picture.alpha) * np.float32(background)
    height, width = tone.shape
    image = bpy.data.images.new(name, width, height, float_buffer=True, is_data=True)
    pixels = np.ones((height, width, 4), dtype=np.float32)
    pixels[..., :3] = tone[..., None]
    image.pixels.foreach_set(pixels.ravel())
    return image
