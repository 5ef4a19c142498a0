"""The calibration tile as an object ready to print."""

from __future__ import annotations

import bpy

from ...core.calibration.step_wedge import wedge_plate, wedge_settings
from ...core.settings import PrintSettings
from ..properties import from_settings
from .picture_objects import picture_object

NAME = "Calibration Tile"
_TILE_KEY = "dualcolor_calibration_tile"


def add_calibration_tile(settings: PrintSettings) -> bpy.types.Object:
    """A new tile at the 3D cursor, selected, with its settings.

    Args:
        settings: that the table is to hold for; the tile keeps them but for calibration and what stands in the way.
    """
    obj = tile_object(settings)
    from_settings(obj.dualcolor, wedge_settings(settings))
    return obj


def tile_object(settings: PrintSettings) -> bpy.types.Object:
    """A new tile at the 3D cursor, selected; it is printed with `wedge_settings`."""
    shape, picture = wedge_plate(settings)
    obj = picture_object(picture, shape, NAME, settings)
    obj[_TILE_KEY] = True
    return obj


def is_calibration_tile(obj: bpy.types.Object) -> bool:
    """Whether an object was made by `tile_object`."""
    return bool(obj.get(_TILE_KEY))
