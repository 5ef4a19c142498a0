"""The objects that the user has chosen to print together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import bpy

from ...core.errors import MeshError
from ...core.mesh.plate import plate
from ...core.model import SupportMark, SurfaceModel
from ...core.settings import PrintSettings
from ..strands.preview import companions_of, source_of
from ..strands.scrubber import STRANDS_KEY
from .mesh_input import WITH_SURFACE, surface_model
from .metaballs import metaball_of
from .support_marks import support_volume, volume_objects


def objects_to_print(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The active object, then all other selected ones with a surface that do not only enforce or block supports.

    Strands stand for what they were made from.
    """
    active = source_of(context.object)
    if active is None or active.type not in WITH_SURFACE:
        return []
    if active != context.object:
        return [active, *companions_of(active)]
    selected = (obj for obj in context.view_layer.objects if obj.select_get() and obj.visible_get())
    others = {obj.name: obj for obj in selected if obj != active and _has_surface(obj, context.scene)}
    markers = {name for obj in (active, *others.values()) for name in volume_objects(obj)}
    return [active, *(others[name] for name in sorted(others) if name not in markers)]


def _has_surface(obj: bpy.types.Object, scene: bpy.types.Scene) -> bool:
    """Whether an object beside the active one is printed: a curve without width is a mere path."""
    if obj.type == "CURVE" and not (obj.data.bevel_depth or obj.data.extrude or obj.data.bevel_object):
        return False
    return obj.type in WITH_SURFACE and not obj.get(STRANDS_KEY) and metaball_of(obj, scene) == obj


def check_present(objects: Sequence[bpy.types.Object]) -> None:
    """Check that objects that a long job has read still exist.

    Raises:
        MeshError: there are none, or one of them is gone.
    """
    try:
        names = [obj.name for obj in objects]
    except ReferenceError:  # how Blender tells that what a name stood for is gone
        names = []
    if not names:
        raise MeshError("the object was deleted while it was worked on", "undo that, or choose another object")


def plate_model(
    objects: Sequence[bpy.types.Object],
    depsgraph: bpy.types.Depsgraph,
    settings: PrintSettings,
    images: Sequence[bpy.types.Image | None],
    markers: Sequence[tuple[bpy.types.Object, SupportMark]] = (),
) -> SurfaceModel:
    """Objects as they stand in the scene, or side by side with `arrange`, as one model.

    Args:
        objects: the first gives the print its name.
        depsgraph: evaluated, of their scene.
        settings: of the print. A vertex group that it names need not be on every object; those without are seen.
        images: the picture chosen for each object, or None for its own.
        markers: objects that enforce or block supports, beside those in the collections of each object.

    Raises:
        MeshError: an object cannot be printed, or the bed has no room for all.
        TextureError: a picture is missing or there is no UV map for it.
    """
    models = []
    group = settings.seam_visibility
    grouped = any(group in obj.vertex_groups for obj in objects)
    for obj, image in zip(objects, images, strict=True):
        own = settings.changed({"seam_visibility": ""}) if grouped and group not in obj.vertex_groups else settings
        chosen = [*volume_objects(obj).values(), *(() if models else markers)]
        volumes = tuple(support_volume(each, mark, depsgraph) for each, mark in chosen)
        models.append(replace(surface_model(obj, depsgraph, own, image), volumes=volumes))
    return plate(models, settings)
