"""The panel Predict: the strands of the future print, pictures and a mesh of them."""

from __future__ import annotations

import bpy

from ..bridge.input.mesh_input import WITH_SURFACE
from ..bridge.strands.preview import preview_of, source_of
from ..operators.render import DUALCOLOR_OT_export_strands, DUALCOLOR_OT_render_prediction
from .rows import draw_progress
from .tab import Tab, order_of


class DUALCOLOR_PT_predict(Tab, bpy.types.Panel):
    """How the print will look; of a generated print or an imported one."""

    bl_label = "Predict"
    bl_order = order_of("predict")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """An object that can be printed, or strands, are needed."""
        obj = source_of(context.object)
        return obj is not None and (obj.type in WITH_SURFACE or preview_of(obj) is not None)

    def draw(self, context: bpy.types.Context) -> None:
        """What to see, what to save."""
        obj, layout = source_of(context.object), self.layout
        has_strands = preview_of(obj) is not None
        if not has_strands:
            layout.label(text="Generate the toolpath first", icon="INFO")
        elif obj.type in WITH_SURFACE:
            layout.prop(obj.dualcolor, "show_print", toggle=True, icon="HIDE_OFF")
        draw_progress(layout, DUALCOLOR_OT_render_prediction)
        column = layout.column(align=True)
        column.operator(DUALCOLOR_OT_render_prediction.bl_idname, icon="RENDER_STILL")
        column.operator(DUALCOLOR_OT_export_strands.bl_idname, icon="EXPORT")
