"""Support enforcers and blockers from files, in the place and size of the model that they belong to."""

from __future__ import annotations

import os
from pathlib import Path

import bpy
from mathutils import Matrix

from ...core.errors import PrintError
from ...core.files import title
from ..units import mm_per_unit
from .model_file import SCALE_KEY, UNTURNED, Angles, baked, check_file, import_objects, printable, turn_upright


def open_marker(name: str, model: bpy.types.Object, up: str = "", rotate_deg: Angles = UNTURNED) -> bpy.types.Object:
    """An object that enforces or blocks supports, turned and scaled as its model was; it is not rendered.

    Args:
        name: of a model file, or of an object in the scene.
        model: as `open_models` has made it.
        up: as for the model.
        rotate_deg: as for the model.

    Raises:
        PrintError: no such file or object, or one that cannot be read.
        MeshError: nothing in it.
    """
    path, scene = Path(name), bpy.context.scene
    scale = Matrix.Scale(model.get(SCALE_KEY, 1.0), 4)
    if os.path.isfile(path):
        check_file(path, alone=False)
        units = scene.unit_settings
        kept = units.system, units.scale_length, units.length_unit
        found = printable(path, import_objects(path), joined=True)
        units.system, units.scale_length, units.length_unit = kept
        scale = scale @ Matrix.Scale(1.0 / mm_per_unit(scene), 4)
        kind = path.suffix.lower()
    elif name in scene.objects:
        found, kind = [scene.objects[name]], ".blend"
    else:
        raise PrintError(f"there is no file {name} and no object of that name", "give a model file")
    made = baked(found, scale @ turn_upright(kind, up, rotate_deg), title(path))
    made.display_type, made.hide_render = "WIRE", True
    made.select_set(False)
    bpy.context.view_layer.objects.active = model
    bpy.context.view_layer.update()
    return made
