"""What the panels of the tab Dual Color have in common."""

from __future__ import annotations

import bpy

from ..bridge.curves import source_of
from ..bridge.mesh_input import WITH_SURFACE


class Tab:
    """Where all panels of this extension are."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Dual Color"


class ObjectPanel(Tab):
    """A panel that is there only for an object that can be printed."""

    bl_parent_id = "DUALCOLOR_PT_main"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """An object that can be printed is needed."""
        obj = source_of(context.object)
        return obj is not None and obj.type in WITH_SURFACE
