"""Scene units and millimeters: the only place where one becomes the other."""

from __future__ import annotations

import bpy

MM_PER_METER = 1000.0

LENGTH_DIGITS = 4
"""Precision of a length property: for properties with a unit Blender takes it as digits, not decimals."""


def mm_per_unit(scene: bpy.types.Scene) -> float:
    """Millimeters in one unit of the scene's coordinates.

    A unit is `scale_length` meters. A scene without a unit system has plain numbers, which are read as mm, as
    slicers read a mesh file.
    """
    units = scene.unit_settings
    if units.system == "NONE":
        return 1.0
    return float(f"{MM_PER_METER * units.scale_length:.6g}")  # Blender holds 0.001 as 0.00100000005


def use_millimeters(scene: bpy.types.Scene) -> None:
    """Make one unit of a scene one millimeter, and show lengths that way, also by the grid of all 3D views.

    The grid's finest lines are meters at first, none of which are seen around small things.
    """
    units = scene.unit_settings
    units.system, units.scale_length, units.length_unit = "METRIC", 1.0 / MM_PER_METER, "MILLIMETERS"
    spaces = (space for screen in bpy.data.screens for area in screen.areas for space in area.spaces)
    for overlay in (space.overlay for space in spaces if space.type == "VIEW_3D"):
        overlay.grid_scale = min(overlay.grid_scale, 1.0 / MM_PER_METER)
