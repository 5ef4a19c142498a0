"""The objects that the user has chosen to print together."""

from __future__ import annotations

from collections.abc import Sequence

import bpy

from ..core.model import SurfaceModel
from ..core.plate import plate
from ..core.settings import PrintSettings
from .curves import companions_of, source_of
from .mesh_input import WITH_SURFACE, surface_model
from .scrubber import STRANDS_KEY


def objects_to_print(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The active object, then all other selected meshes; strands stand for what they were made from."""
    active = source_of(context.object)
    if active is None or active.type not in WITH_SURFACE:
        return []
    if active != context.object:
        return [active, *companions_of(active)]
    selected = (obj for obj in context.view_layer.objects if obj.select_get() and obj.visible_get())
    others = {obj.name: obj for obj in selected if obj.type == "MESH" and not obj.get(STRANDS_KEY) and obj != active}
    return [active, *(others[name] for name in sorted(others))]


def plate_model(
    objects: Sequence[bpy.types.Object],
    depsgraph: bpy.types.Depsgraph,
    settings: PrintSettings,
    images: Sequence[bpy.types.Image | None],
) -> SurfaceModel:
    """Objects as they stand in the scene, or side by side with `arrange`, as one model.

    Args:
        objects: the first gives the print its name.
        depsgraph: evaluated, of their scene.
        settings: of the print.
        images: the picture chosen for each object, or None for its own.

    Raises:
        MeshError: an object cannot be printed, or the bed has no room for all.
        TextureError: a picture is missing or there is no UV map for it.
    """
    models = [surface_model(obj, depsgraph, settings, image) for obj, image in zip(objects, images, strict=True)]
    return plate(models, settings)
