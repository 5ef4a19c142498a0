"""The panel Print: what matters first, generate, export; and what the last job found."""

from __future__ import annotations

import bpy

from ..bridge.input.base_color import BAKE_HINT
from ..bridge.properties import report_of
from ..bridge.strands.preview import source_of
from ..core.settings.printer import printer_profile
from ..operators.export import DUALCOLOR_OT_export_gcode, DUALCOLOR_OT_export_x3g
from ..operators.generate import DUALCOLOR_OT_generate
from ..operators.painting import DUALCOLOR_OT_bake_material
from .results import figures
from .rows import draw_figures, draw_outdated, draw_progress, draw_sentence, draw_settings, fitting
from .sections import PRINT
from .tab import ObjectPanel, order_of

_EXPORTS = {"x3g": DUALCOLOR_OT_export_x3g, "gcode": DUALCOLOR_OT_export_gcode}


class DUALCOLOR_PT_print(ObjectPanel, bpy.types.Panel):
    """From the object to the printer's file."""

    bl_label = "Print"
    bl_order = order_of("print")

    def draw(self, context: bpy.types.Context) -> None:
        """Settings, then the buttons."""
        layout = self.layout
        draw_settings(layout, source_of(context.object), PRINT)
        buttons = layout.column(align=True)
        buttons.scale_y = 1.4
        generate = fitting(context, DUALCOLOR_OT_generate.bl_label, "Generate")
        buttons.operator(DUALCOLOR_OT_generate.bl_idname, text=generate, icon="PLAY")
        for kind, text in export_texts(context, source_of(context.object).dualcolor.printer).items():
            buttons.operator(_EXPORTS[kind].bl_idname, text=text, icon="EXPORT")
        draw_progress(layout, DUALCOLOR_OT_generate, DUALCOLOR_OT_export_gcode, DUALCOLOR_OT_export_x3g)


def export_texts(context: bpy.types.Context, printer: str) -> dict[str, str]:
    """Kind of file and the text of its button, of those that a printer reads; with its name if there is room."""
    name = printer.replace("_", " ").title()
    kinds = ({} if printer_profile(printer).marlin else {"x3g": "X3G"}) | {"gcode": "G-code"}
    return {key: fitting(context, f"Export {name} {kind}", f"Export {kind}") for key, kind in kinds.items()}


class DUALCOLOR_PT_results(ObjectPanel, bpy.types.Panel):
    """What the last job found."""

    bl_label = "Results"
    bl_parent_id = "DUALCOLOR_PT_print"
    bl_order = 0

    def draw(self, context: bpy.types.Context) -> None:
        """Figures, then warnings."""
        group, layout = source_of(context.object).dualcolor, self.layout
        report = report_of(group)
        if not report:
            layout.label(text="Nothing generated yet")
            return
        draw_outdated(layout, report, group)
        draw_figures(layout, figures(report), factor=0.4)
        about_nodes = next((warning for warning in report["warnings"] if BAKE_HINT in warning), "")
        for warning in report["warnings"]:
            draw_sentence(layout, context, warning)
            if warning == about_nodes:
                layout.operator(DUALCOLOR_OT_bake_material.bl_idname, icon="MATERIAL")


PANELS = (DUALCOLOR_PT_print, DUALCOLOR_PT_results)
