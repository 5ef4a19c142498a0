"""Plates, cylinders and lamp shades that bear a picture, as objects ready to print."""

from __future__ import annotations

import bpy
import numpy as np

from ...core.model import ToneImage
from ...core.pictures.shapes import PictureShape
from ...core.settings import PrintSettings
from ...core.texture.decode import srgb_from_linear
from ..input.mesh_input import WITH_SURFACE
from ..materials import new_material, picture_node, principled
from ..properties import from_settings
from ..units import mm_per_unit, use_millimeters

UV_LAYER = "Picture"


def add_picture_object(picture: ToneImage, shape: PictureShape, name: str, settings: PrintSettings) -> bpy.types.Object:
    """A new object as `picture_object` makes it, which keeps the settings."""
    obj = picture_object(picture, shape, name, settings)
    from_settings(obj.dualcolor, settings)
    return obj


def picture_object(picture: ToneImage, shape: PictureShape, name: str, settings: PrintSettings) -> bpy.types.Object:
    """A new object at the 3D cursor that bears a picture, selected; a scene without meshes gets millimeters for units.

    The picture becomes an image of its own, packed into the file, so that it can be painted on texel by texel. What
    bears no picture has the settings' background tone.

    Args:
        picture: fitted to the shape.
        shape: made with the same settings.
        name: of the object, its material and its image.
        settings: those that the shape was made with.
    """
    if not any(other.type in WITH_SURFACE for other in bpy.context.scene.objects):
        use_millimeters(bpy.context.scene)
    obj = bpy.data.objects.new(name, _mesh(shape, name))
    obj.data.materials.append(_material(name, tone_as_image(picture, name)))
    obj.data.materials.append(_material(f"{name} Plain", settings.background_tone))
    obj.location = bpy.context.scene.cursor.location
    bpy.context.collection.objects.link(obj)
    for other in bpy.context.selected_objects:
        other.select_set(False)
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    return obj


def tone_as_image(picture: ToneImage, name: str) -> bpy.types.Image:
    """Tones as a gray image of 8 bits, sRGB-encoded like any other picture, packed into the file."""
    height, width = picture.tone.shape
    pixels = np.empty((height, width, 4), dtype=np.float32)
    pixels[..., :3] = srgb_from_linear(picture.tone.astype(np.float64))[..., None]
    pixels[..., 3] = picture.alpha
    image = bpy.data.images.new(name, width, height, alpha=True)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image


def _mesh(shape: PictureShape, name: str) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new(name)
    unit = mm_per_unit(bpy.context.scene)
    corners = np.split(shape.corner_vertex, shape.polygon_start[1:-1])
    mesh.from_pydata((shape.vertices / unit).tolist(), [], [polygon.tolist() for polygon in corners])
    layer = mesh.uv_layers.new(name=UV_LAYER)
    layer.uv.foreach_set("vector", shape.corner_uv.astype(np.float32).ravel())
    mesh.polygons.foreach_set("material_index", (~shape.has_picture).astype(np.int32))
    mesh.update()
    return mesh


def _material(name: str, color: bpy.types.Image | float) -> bpy.types.Material:
    """A material whose base color is a picture, its texels shown as squares, or one even tone."""
    material = new_material(name)
    if isinstance(color, float):
        principled(material).inputs["Base Color"].default_value = material.diffuse_color = (color, color, color, 1.0)
    else:
        node = picture_node(material)
        node.image, node.interpolation = color, "Closest"
    return material
