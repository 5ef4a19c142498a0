"""Where seams of the pattern are visible: painted as weights of a vertex group, or as an image."""

from __future__ import annotations

import os
from pathlib import Path

import bpy
import numpy as np

from ...core.errors import SettingsError, TextureError
from ...core.model import FloatArray, ToneImage
from .image_input import image_tone, load_image


def painted_visibility(
    obj: bpy.types.Object, mesh: bpy.types.Mesh, name: str
) -> tuple[FloatArray | None, ToneImage | None]:
    """What the setting `seam_visibility` names: the weights (V,) of a vertex group, or an image; or neither.

    An image is one of this Blender file, or else a picture file.

    Args:
        obj: whose vertex groups are looked through first.
        mesh: of the object, evaluated.
        name: the setting.

    Raises:
        SettingsError: nothing has that name.
        TextureError: it is a file but no picture, or there is no UV map for it.
    """
    if not name:
        return None, None
    if group := obj.vertex_groups.get(name):
        return _weights(mesh, group.index), None
    if not mesh.uv_layers:
        raise TextureError(
            f"{obj.name} has no vertex group {name:.60}, and no UV map for an image",
            "clear seam_visibility, paint a vertex group of that name, or unwrap the object",
        )
    if image := bpy.data.images.get(name):
        return None, image_tone(image)
    path = Path(bpy.path.abspath(name))
    if not os.path.isfile(path):
        raise SettingsError(
            f"{obj.name} has no vertex group {name:.60}, and there is no such image",
            "clear seam_visibility, or name a vertex group, an image or a picture file",
        )
    image = load_image(path)
    try:
        return None, image_tone(image)
    finally:
        bpy.data.images.remove(image)


def _weights(mesh: bpy.types.Mesh, group: int) -> FloatArray:
    """(V,) weights of a vertex group, 0 outside of it; Blender hands them out one by one only."""
    entries = ((entry.weight for entry in vertex.groups if entry.group == group) for vertex in mesh.vertices)
    return np.fromiter((next(own, 0.0) for own in entries), dtype=np.float64, count=len(mesh.vertices))


def visibility_names(group: bpy.types.PropertyGroup, _context: bpy.types.Context, _typed: str) -> list[str]:
    """Names that the sidebar proposes: the object's vertex groups, then all images."""
    groups = getattr(group.id_data, "vertex_groups", ())
    return [*(found.name for found in groups), *(image.name for image in bpy.data.images if all(image.size))]
