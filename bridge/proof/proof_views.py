"""3D views turned to Material Preview while a soft proof is shown, and back afterwards."""

from __future__ import annotations

import bpy

_SHADING_KEY = "dualcolor_shading"
WITHOUT_MATERIALS = ("WIREFRAME", "SOLID")


def show_materials(context: bpy.types.Context) -> None:
    """Turn the views of all windows to Material Preview where they show no materials."""
    for window in context.window_manager.windows:
        former = dict(window.screen.get(_SHADING_KEY, {}))
        for number, area in enumerate(window.screen.areas):
            shading = area.spaces.active.shading if area.type == "VIEW_3D" else None
            if shading and shading.type in WITHOUT_MATERIALS:
                former[str(number)] = shading.type
                shading.type = "MATERIAL"
        if former:
            window.screen[_SHADING_KEY] = former


def show_as_before() -> None:
    """Turn these views back, unless the user has chosen otherwise meanwhile."""
    for screen in bpy.data.screens:
        former = dict(screen.get(_SHADING_KEY, {}))
        for number, area in enumerate(screen.areas):
            shading = area.spaces.active.shading if area.type == "VIEW_3D" else None
            if shading and shading.type == "MATERIAL" and str(number) in former:
                shading.type = former[str(number)]
        if former:
            del screen[_SHADING_KEY]
