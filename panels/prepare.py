"""The panel for what comes before the picture: the right size, a sound mesh."""

from __future__ import annotations

import bpy
import numpy as np

from ..bridge.analysis.model_check import TITLES
from ..bridge.bed import bounds_mm, what_does_not_fit
from ..bridge.input.plate import objects_to_print
from ..bridge.properties import findings_of
from ..bridge.strands.preview import source_of
from ..core.settings.printer import printer_profile
from ..operators.check_model import DUALCOLOR_OT_check_model, DUALCOLOR_OT_repair_model, DUALCOLOR_OT_select_finding
from ..operators.size import DUALCOLOR_OT_scale_to_height
from .rows import draw_progress, draw_sentence
from .tab import ObjectPanel, order_of


class DUALCOLOR_PT_prepare(ObjectPanel, bpy.types.Panel):
    """How large the print is, and whether the mesh is sound."""

    bl_label = "Prepare"
    bl_order = order_of("prepare")

    def draw(self, context: bpy.types.Context) -> None:
        """Size, bed, check."""
        obj, layout = source_of(context.object), self.layout
        _draw_size(layout, context, obj)
        row = layout.row(align=True)
        row.operator(DUALCOLOR_OT_check_model.bl_idname, icon="VIEWZOOM")
        row.operator(DUALCOLOR_OT_repair_model.bl_idname, icon="TOOL_SETTINGS")
        draw_progress(layout, DUALCOLOR_OT_check_model, DUALCOLOR_OT_select_finding)
        if obj.type != "MESH":
            draw_sentence(layout, context, "Only meshes can be checked: Object > Convert > Mesh", "INFO")
        elif reason := why_gray(obj, context.object):
            draw_sentence(layout, context, reason, "INFO")
        _draw_findings(layout, obj)


def why_gray(obj: bpy.types.Object, active: bpy.types.Object) -> str:
    """Why the buttons that look at a mesh or change it are gray though it can be printed; empty if they are not."""
    if active != obj:
        return f"Strands are selected: select {obj.name} for the buttons that are gray"
    keys = {"EDIT": "Edit Mode (Tab)", "SCULPT": "Sculpt Mode (Ctrl Tab)"}
    return f"Leave {keys[obj.mode]} for the buttons that are gray" if obj.mode in keys else ""


def _draw_size(layout: bpy.types.UILayout, context: bpy.types.Context, obj: bpy.types.Object) -> None:
    group = obj.dualcolor
    size = np.ptp(bounds_mm([obj]), axis=0)
    row = layout.split(factor=0.25)
    row.label(text="Size")
    row.label(text=" × ".join(f"{side:.1f}" for side in size) + " mm")
    row = layout.row(align=True)
    row.operator(DUALCOLOR_OT_scale_to_height.bl_idname, icon="FULLSCREEN_ENTER")
    row.prop(group, "show_bed", toggle=True, icon="CUBE")
    bounds = bounds_mm(objects_to_print(context) or [obj])
    if not group.arrange and (
        problem := what_does_not_fit(bounds, printer_profile(group.printer), group.center_on_bed)
    ):
        draw_sentence(layout, context, problem)


def _draw_findings(layout: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    found = findings_of(obj.dualcolor)
    if found and not any(found.values()):
        layout.label(text="Nothing is wrong", icon="CHECKMARK")
    for kind, count in found.items():
        if count:
            row = layout.row()
            row.label(text=f"{TITLES[kind]}: {count}", icon="ERROR")
            button = row.row()
            button.alignment = "RIGHT"
            button.operator(DUALCOLOR_OT_select_finding.bl_idname).kind = kind
