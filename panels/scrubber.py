"""The panel that shows a part of the strands."""

from __future__ import annotations

import bpy

from ..bridge.curves import preview_of
from ..bridge.scrubber import KINDS, last_layer
from ..operators.render import DUALCOLOR_OT_export_strands


class DUALCOLOR_PT_scrubber(bpy.types.Panel):
    """Layers and features that are visible, of a generated print or an imported one."""

    bl_label = "Dual Color Layers"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Dual Color"
    bl_order = 1

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Strands are needed."""
        return context.object is not None and preview_of(context.object) is not None

    def draw(self, context: bpy.types.Context) -> None:
        """The range, the kinds, the colours."""
        collection = preview_of(context.object)
        view = collection.dualcolor_view
        column = self.layout.column(align=True)
        column.prop(view, "layer_from")
        column.prop(view, "layer_to")
        column.label(text=f"of 0 to {last_layer(collection)}")
        grid = self.layout.grid_flow(columns=3, align=True)
        for kind in KINDS:
            grid.prop(view, f"show_{kind}", toggle=True)
        self.layout.row().prop(view, "colour_by", expand=True)
        self.layout.operator(DUALCOLOR_OT_export_strands.bl_idname, icon="EXPORT")
