"""What the supports' panel shows below its settings: collections of volumes, and buttons for faces."""

from __future__ import annotations

import bpy

from ..bridge.input.support_marks import COLLECTIONS
from ..core.model import SupportMark
from ..operators.supports import DUALCOLOR_OT_mark_support, DUALCOLOR_OT_select_support

_MARK = {SupportMark.ENFORCER: "Enforce", SupportMark.BLOCKER: "Block", SupportMark.NONE: "Clear"}
_SELECT = {SupportMark.ENFORCER: "Select Enforced", SupportMark.BLOCKER: "Select Blocked"}


def draw_supports(layout: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    """Enforcers and blockers of an object."""
    column = layout.column()
    column.active = obj.dualcolor.support_enable
    for name in COLLECTIONS.values():
        column.prop(obj.dualcolor, name)
    column = layout.column(align=True)
    column.label(text="Selected faces (Edit Mode)")
    row = column.row(align=True)
    for mark, title in _MARK.items():
        row.operator(DUALCOLOR_OT_mark_support.bl_idname, text=title).mark = mark.name
    row = column.row(align=True)
    for mark, title in _SELECT.items():
        row.operator(DUALCOLOR_OT_select_support.bl_idname, text=title).mark = mark.name
