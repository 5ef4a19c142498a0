"""The panels for what comes before the print: a sound mesh, a UV map, a picture."""

from __future__ import annotations

import bpy

from ..bridge.curves import source_of
from ..bridge.model_check import TITLES
from ..bridge.properties import findings_of
from ..operators.check_model import DUALCOLOR_OT_check_model, DUALCOLOR_OT_repair_model, DUALCOLOR_OT_select_finding
from ..operators.painting import DUALCOLOR_OT_grey_from_color, DUALCOLOR_OT_set_up_painting
from ..operators.unwrap import DUALCOLOR_OT_unwrap_smart, DUALCOLOR_OT_unwrap_xatlas
from .tab import ObjectPanel


class DUALCOLOR_PT_prepare(ObjectPanel, bpy.types.Panel):
    """Check the mesh and mend it."""

    bl_label = "Prepare"
    bl_order = 0
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012  (Blender reads the class)

    def draw(self, context: bpy.types.Context) -> None:
        """The buttons, and what the check has found."""
        row = self.layout.row(align=True)
        row.operator(DUALCOLOR_OT_check_model.bl_idname, icon="VIEWZOOM")
        row.operator(DUALCOLOR_OT_repair_model.bl_idname, icon="TOOL_SETTINGS")
        found = findings_of(source_of(context.object).dualcolor)
        if found and not any(found.values()):
            self.layout.label(text="Nothing is wrong", icon="CHECKMARK")
        for kind, count in found.items():
            if count:
                row = self.layout.row()
                row.label(text=f"{TITLES[kind]}: {count}", icon="ERROR")
                row.operator(DUALCOLOR_OT_select_finding.bl_idname).kind = kind


class DUALCOLOR_PT_paint(ObjectPanel, bpy.types.Panel):
    """Unwrap and paint."""

    bl_label = "Paint"
    bl_order = 0
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012  (Blender reads the class)

    def draw(self, _context: bpy.types.Context) -> None:
        """The buttons in the order of the work."""
        column = self.layout.column(align=True)
        column.operator(DUALCOLOR_OT_unwrap_xatlas.bl_idname, icon="UV")
        column.operator(DUALCOLOR_OT_unwrap_smart.bl_idname, icon="UV")
        column = self.layout.column(align=True)
        column.operator(DUALCOLOR_OT_set_up_painting.bl_idname, icon="TPAINT_HLT")
        column.operator(DUALCOLOR_OT_grey_from_color.bl_idname, icon="IMAGE_DATA")
