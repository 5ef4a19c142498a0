"""Pictures to paint on: made in the right size, shown on the object, filled from a colored picture."""

from __future__ import annotations

import math

import bpy
import numpy as np

from ...core.errors import TextureError
from ...core.model import FloatArray
from ...core.settings.printer import printer_profile
from ...core.texture.decode import linear_from_srgb, srgb_from_linear
from ...core.texture.grade import Grade, graded
from ..bed import bounds_mm
from ..input.base_color import BaseColor, base_color, chosen_color, color_layer, ignored_note, picture_layer
from ..input.image_input import image_size, stored_pixels
from ..input.printed_materials import printed_materials
from ..materials import new_material, picture_node
from ..mesh_data import corner_vertices, positions
from ..units import mm_per_unit
from .unwrap import GAP_MM, smart_project

PALETTE = "Dual-Color Grays"
GRAYS = 11
SMALLEST, LARGEST = 256, 8192


def set_up_painting(obj: bpy.types.Object, texel_mm: float, background_tone: float) -> bpy.types.Image:
    """Make an object ready to be painted in Texture Paint mode, and enter it.

    A picture that the object has already is kept and painted on; so are its UV maps and materials.

    Args:
        obj: the active mesh object.
        texel_mm: greatest side of a texel on the surface.
        background_tone: what a new picture is filled with.

    Returns:
        The picture that strokes go to.

    Raises:
        MeshError: the object has no faces.
        TextureError: its UV map has no area, or its picture cannot be painted on and printed.
    """
    if not obj.data.uv_layers:
        smart_project(obj)
    image = picture_of(obj)
    if image is None:
        image = give_picture(obj, picture_size(obj, texel_mm, obj.dualcolor.printer), background_tone)
    width, height = image_size(image)
    picture_uv(obj).active = True  # by which strokes go
    if obj.mode != "TEXTURE_PAINT":
        bpy.ops.object.mode_set(mode="TEXTURE_PAINT")
    paint = bpy.context.scene.tool_settings.image_paint
    paint.mode, paint.canvas = "IMAGE", image
    paint.palette = _palette()
    paint.seam_bleed = max(paint.seam_bleed, round(GAP_MM / 2 * max(width, height) / _side_mm(obj)))
    _take_black(paint)
    return image


def give_picture(obj: bpy.types.Object, side: int, tone: float) -> bpy.types.Image:
    """Give an object that has a UV map a new square picture of one tone, with `side` texels each way."""
    image = _new_picture(f"{obj.name} Tone", side, tone)
    if any(obj.data.materials):
        obj.dualcolor.image = image  # the materials stay as they are
    else:
        _show_in_new_material(obj, image)
        obj.data.uv_layers.active.active_render = True
    return image


def picture_of(obj: bpy.types.Object) -> bpy.types.Image | None:
    """The picture that an object is printed with: the chosen one, else that of its materials."""
    return _picture_color(obj).image


def picture_uv(obj: bpy.types.Object) -> bpy.types.MeshUVLoopLayer | None:
    """The UV map by which that picture is seen; None without any."""
    return picture_layer(_picture_color(obj), obj.data)


def _picture_color(obj: bpy.types.Object) -> BaseColor:
    colors = [base_color(material) for material in printed_materials(obj)]
    if obj.dualcolor.image:
        return chosen_color(colors, obj.dualcolor.image, obj.data)
    return next((color for color in colors if color.image), BaseColor())


def paint_note(obj: bpy.types.Object) -> str:
    """A sentence about what the materials of an object show otherwise than it prints; empty if there is nothing."""
    mesh = _shown_mesh(obj)
    colors = [base_color(material) for material in printed_materials(obj)]
    colors = [_picture_color(obj)] if obj.dualcolor.image else colors
    return next(filter(None, (ignored_note(color, mesh) for color in colors)), "")


def printed_attributes(obj: bpy.types.Object) -> list[str]:
    """Names of the color attributes that an object without a picture is printed with."""
    mesh = _shown_mesh(obj)
    colors = [base_color(material) for material in printed_materials(obj)] or [BaseColor()]
    layers = [color_layer(color, mesh) for color in colors]
    return list(dict.fromkeys(layer.name for layer in layers if layer))


def _shown_mesh(obj: bpy.types.Object) -> bpy.types.Mesh:
    """The mesh of an object with its modifiers, some of which make attributes; its own where there is no other."""
    found = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    return found if isinstance(found, bpy.types.Mesh) else obj.data


def exchange_picture(obj: bpy.types.Object, former: bpy.types.Image, picture: bpy.types.Image) -> None:
    """Print and show another picture wherever an object has the former one; strokes go to it too."""
    pictures = {base_color(material).image for material in printed_materials(obj)} - {None}
    if obj.dualcolor.image == former or (not obj.dualcolor.image and pictures <= {former}):
        obj.dualcolor.image = picture  # which covers all of it
    for material in filter(None, printed_materials(obj)):
        for node in material.node_tree.nodes if material.node_tree else ():
            if node.type == "TEX_IMAGE" and node.image == former:
                node.image = picture
    paint = bpy.context.scene.tool_settings.image_paint
    if paint.canvas == former:
        paint.canvas = picture


def picture_size(obj: bpy.types.Object, texel_mm: float, printer: str) -> int:
    """Side of a square picture, a power of two, whose texels are no larger than `texel_mm` on the surface.

    Objects too large for the printer count as large as it can print: the cube of a new scene is two meters wide.

    Raises:
        TextureError: the UV map has no area.
    """
    profile = printer_profile(printer)
    size = np.ptp(bounds_mm([obj]), axis=0)
    too_large = max(1.0, float((size / np.subtract(profile.reach_max, profile.reach_min)).max()))
    texels = _side_mm(obj) / texel_mm / too_large
    return int(min(max(2 ** math.ceil(math.log2(max(texels, 1.0))), SMALLEST), LARGEST))


def _side_mm(obj: bpy.types.Object) -> float:
    """What the side of a picture is on the surface, on average over its charts.

    Raises:
        TextureError: the UV map has no area.
    """
    mesh = obj.data
    mesh.calc_loop_triangles()
    corner = np.empty(len(mesh.loop_triangles) * 3, dtype=np.int32)
    mesh.loop_triangles.foreach_get("loops", corner)
    uv = np.empty(len(mesh.loops) * 2, dtype=np.float32)
    mesh.uv_layers.active.uv.foreach_get("vector", uv)
    matrix = np.array(obj.matrix_world.to_3x3()) * mm_per_unit(bpy.context.scene)
    places = (positions(mesh) @ matrix.T)[corner_vertices(mesh)[corner]].reshape(-1, 3, 3)
    charted = np.abs(_area(uv.reshape(-1, 2)[corner].reshape(-1, 3, 2))).sum()
    surface = np.linalg.norm(np.cross(places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]), axis=1).sum() / 2
    if not charted > 0:
        raise TextureError(f"the UV map of {obj.name} has no area", "unwrap the mesh again")
    return math.sqrt(surface / charted)


def gray_picture(image: bpy.types.Image, grade: Grade) -> bpy.types.Image:
    """A new, packed gray picture made from a colored one, which is kept.

    Raises:
        TextureError: the picture has no pixels, or the grade makes no sense.
    """
    pixels, encoded, premultiplied = stored_pixels(image)
    gray = graded(pixels, grade, encoded, premultiplied)
    height, width = gray.shape
    made = bpy.data.images.new(f"{image.name} Gray", width, height, alpha=True)
    pixels[..., :3] = gray[..., None]
    np.clip(pixels[..., 3], 0.0, 1.0, out=pixels[..., 3])
    made.pixels.foreach_set(pixels.ravel())
    made.pack()
    return made


def _area(uv: FloatArray) -> FloatArray:
    """(T,) signed area of triangles (T, 3, 2)."""
    a, b = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    return (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2


def _new_picture(name: str, side: int, tone: float) -> bpy.types.Image:
    image = bpy.data.images.new(name, side, side, alpha=False)
    gray = float(srgb_from_linear(np.array(tone)))
    image.pixels.foreach_set(np.tile(np.array([gray, gray, gray, 1.0], dtype=np.float32), side * side))
    image.pack()
    return image


def _show_in_new_material(obj: bpy.types.Object, image: bpy.types.Image) -> None:
    material = new_material(f"{obj.name} Tone")
    picture_node(material).image = image
    if obj.data.materials:
        obj.data.materials[0] = material
    else:
        obj.data.materials.append(material)


def _take_black(paint: bpy.types.ImagePaint) -> None:
    """Set the brush color to black, whether brushes have a color each or, as usual, one for all."""
    # Before Blender 5 all painting modes shared one.
    shared = getattr(paint, "unified_paint_settings", None) or bpy.context.tool_settings.unified_paint_settings
    for holder in filter(None, (paint.brush, shared)):
        holder.color = (0.0, 0.0, 0.0)


def _palette() -> bpy.types.Palette:
    """Grays from the black filament to the white one, in perceptually equal steps."""
    palette = bpy.data.palettes.get(PALETTE)
    if palette is None:
        palette = bpy.data.palettes.new(PALETTE)
        grays = np.linspace(0.0, 1.0, GRAYS)
        if bpy.types.PaletteColor.bl_rna.properties["color"].subtype == "COLOR":  # linear, since Blender 5
            grays = linear_from_srgb(grays)
        for gray in grays.tolist():
            palette.colors.new().color = (gray, gray, gray)
    return palette
