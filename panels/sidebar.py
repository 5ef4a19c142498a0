"""The tab Dual Color in the sidebar of the 3D view."""

from __future__ import annotations

import bpy

from ..bridge.curves import preview_of, source_of
from ..bridge.mesh_input import WITH_SURFACE
from ..bridge.plate import objects_to_print
from ..bridge.properties import report_of, values_of
from ..operators.export import DUALCOLOR_OT_export_gcode, DUALCOLOR_OT_export_x3g
from ..operators.generate import DUALCOLOR_OT_generate
from ..operators.job import JobOperator
from ..operators.render import DUALCOLOR_OT_render_prediction
from .presets import DUALCOLOR_PT_presets
from .results import figures, wrapped
from .sections import SECTIONS, TEXTURE, Section
from .supports import draw_supports
from .tab import ObjectPanel, Tab


class DUALCOLOR_PT_main(Tab, bpy.types.Panel):
    """The object, its picture, and the buttons."""

    bl_label = "Dual Color"

    def draw(self, context: bpy.types.Context) -> None:
        """What to print, and do it."""
        obj = source_of(context.object)
        layout = self.layout
        if obj is None or obj.type not in WITH_SURFACE:
            layout.label(text="Select a mesh object", icon="INFO")
            return
        more = len(objects_to_print(context)) - 1
        layout.label(text=f"{obj.name} and {more} more" if more else obj.name, icon="OBJECT_DATA")
        layout.template_ID(obj.dualcolor, "image", open="image.open", text="Image")
        _draw_settings(layout, obj, TEXTURE)
        buttons = layout.column(align=True)
        buttons.scale_y = 1.4
        buttons.operator(DUALCOLOR_OT_generate.bl_idname, icon="MOD_PHYSICS")
        buttons.operator(DUALCOLOR_OT_export_gcode.bl_idname, icon="EXPORT")
        buttons.operator(DUALCOLOR_OT_export_x3g.bl_idname, icon="EXPORT")
        buttons.operator(DUALCOLOR_OT_render_prediction.bl_idname, icon="RENDER_STILL")
        if running := JobOperator.running:
            layout.progress(factor=running.share, text=running.stage)
        if preview_of(obj):
            layout.prop(obj.dualcolor, "show_print", toggle=True, icon="HIDE_OFF")


class DUALCOLOR_PT_results(ObjectPanel, bpy.types.Panel):
    """What the last job found."""

    bl_label = "Results"
    bl_order = 1

    def draw(self, context: bpy.types.Context) -> None:
        """Figures, then warnings."""
        group = source_of(context.object).dualcolor
        report = report_of(group)
        if not report:
            self.layout.label(text="Nothing generated yet")
            return
        if report["settings"] != values_of(group):
            self.layout.label(text="Settings have changed since", icon="FILE_REFRESH")
        table = self.layout.column(align=True)
        for label, value in figures(report):
            row = table.split(factor=0.4)
            row.label(text=label)
            row.label(text=value)
        scale = context.preferences.system.ui_scale
        for warning in report["warnings"]:
            _draw_warning(self.layout, wrapped(warning, context.region.width, scale))


def _draw_warning(layout: bpy.types.UILayout, lines: list[str]) -> None:
    column = layout.column(align=True)
    column.scale_y = 0.8
    for number, line in enumerate(lines):
        column.label(text=line, icon="BLANK1" if number else "ERROR")


def _draw_settings(layout: bpy.types.UILayout, obj: bpy.types.Object, section: Section) -> None:
    column = layout.column()
    for name in section.settings:
        if obj.dualcolor.bl_rna.properties[name].type != "ENUM":
            column.prop(obj.dualcolor, name)
            continue
        row = column.split(factor=0.4)  # numbers have their names inside the field, choices beside it
        row.label(text=obj.dualcolor.bl_rna.properties[name].name)
        row.prop(obj.dualcolor, name, text="")


_MORE = {"supports": draw_supports}


def _section_panel(section: Section, order: int) -> type[bpy.types.Panel]:
    def draw(self: bpy.types.Panel, context: bpy.types.Context) -> None:
        obj = source_of(context.object)
        _draw_settings(self.layout, obj, section)
        if section.key in _MORE:
            _MORE[section.key](self.layout, obj)

    return type(
        f"DUALCOLOR_PT_{section.key}",
        (ObjectPanel, bpy.types.Panel),
        {
            "__doc__": f"The settings of {section.title}.",
            "__module__": __name__,
            "bl_label": section.title,
            "bl_order": order,
            "bl_options": set() if section.is_open else {"DEFAULT_CLOSED"},
            "draw": draw,
        },
    )


PANELS = (
    DUALCOLOR_PT_main,
    DUALCOLOR_PT_presets,
    *(_section_panel(section, order) for order, section in enumerate(SECTIONS, start=2)),
    DUALCOLOR_PT_results,
)
