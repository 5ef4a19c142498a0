"""The one place where scene units become millimetres."""

from __future__ import annotations

import bpy


def mm_per_unit(scene: bpy.types.Scene) -> float:
    """Millimetres in one scene unit; a scene without a unit system counts in mm, as STL files do."""
    if scene.unit_settings.system == "NONE":
        return 1.0
    return float(scene.unit_settings.scale_length) * 1000.0
