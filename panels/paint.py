"""The panel for the picture: chosen, made from a colored one, or painted."""

from __future__ import annotations

import bpy

from ..bridge.paint.painting import paint_note, picture_of, printed_attributes
from ..bridge.proof.proof_views import WITHOUT_MATERIALS
from ..bridge.proof.soft_proof import is_proofed, proof_notes
from ..bridge.strands.preview import source_of
from ..operators.painting import (
    DUALCOLOR_OT_bake_material,
    DUALCOLOR_OT_bake_occlusion,
    DUALCOLOR_OT_gray_from_color,
    DUALCOLOR_OT_set_up_painting,
)
from ..operators.soft_proof import DUALCOLOR_OT_soft_proof
from ..operators.unwrap import DUALCOLOR_OT_unwrap_smart, DUALCOLOR_OT_unwrap_xatlas, has_xatlas
from .prepare import why_gray
from .rows import draw_progress, draw_sentence, draw_settings
from .sections import PAINT
from .tab import ObjectPanel, order_of


class DUALCOLOR_PT_paint(ObjectPanel, bpy.types.Panel):
    """The picture, a UV map for it, and painting."""

    bl_label = "Paint"
    bl_order = order_of("paint")

    def draw(self, context: bpy.types.Context) -> None:
        """In the order of the work."""
        obj, layout = source_of(context.object), self.layout
        column = layout.column(align=True)
        column.operator(DUALCOLOR_OT_unwrap_xatlas.bl_idname, icon="UV")
        column.operator(DUALCOLOR_OT_unwrap_smart.bl_idname, icon="UV")
        draw_progress(layout, DUALCOLOR_OT_unwrap_xatlas)
        column = layout.column(align=True)
        column.operator(DUALCOLOR_OT_set_up_painting.bl_idname, icon="TPAINT_HLT")
        column.operator(DUALCOLOR_OT_gray_from_color.bl_idname, icon="IMAGE_DATA")
        column.operator(DUALCOLOR_OT_bake_material.bl_idname, icon="MATERIAL")
        column.operator(DUALCOLOR_OT_bake_occlusion.bl_idname, icon="SHADING_RENDERED")
        draw_progress(layout, DUALCOLOR_OT_bake_material, DUALCOLOR_OT_bake_occlusion)
        _draw_soft_proof(layout, context, obj)
        for hint in hints(obj, context.object):
            draw_sentence(layout, context, hint, "INFO")
        row = layout.split(factor=0.25)
        row.label(text="Image")
        row.template_ID(obj.dualcolor, "image", open="image.open")
        draw_settings(layout, obj, PAINT)


def _draw_soft_proof(layout: bpy.types.UILayout, context: bpy.types.Context, obj: bpy.types.Object) -> None:
    shown = obj.type == "MESH" and is_proofed(obj)
    layout.operator(DUALCOLOR_OT_soft_proof.bl_idname, icon="HIDE_OFF" if shown else "HIDE_ON", depress=shown)
    if not shown:
        return
    if context.space_data.shading.type in WITHOUT_MATERIALS:
        draw_sentence(layout, context, "The proof is seen in Material Preview (Z)", "INFO")
    for note in proof_notes(obj):
        draw_sentence(layout, context, note, "INFO")


def hints(obj: bpy.types.Object, active: bpy.types.Object | None = None) -> list[str]:
    """Why some of the buttons are gray, and where the tone comes from if no image is chosen.

    Args:
        obj: what is printed.
        active: what is selected: that, or strands of it.
    """
    if obj.type != "MESH":
        return ["Only meshes can be painted: Object > Convert > Mesh"]
    if reason := why_gray(obj, active or obj):
        return [reason]
    found = [] if has_xatlas() else ["xatlas is not installed here: Smart UV Project does it too"]
    picture = picture_of(obj)
    painted = [] if picture else printed_attributes(obj)
    if painted:
        found.append(f"No image: prints the color attribute {' and '.join(painted)} (Vertex Paint)")
    elif picture is None:
        found.append("No image yet: all prints in the background tone")
    elif not obj.data.uv_layers:
        found.append("The image needs a UV map: unwrap first")
    elif not obj.dualcolor.image:
        found.append(f"Prints the material's image {picture.name}")
    note = paint_note(obj)
    return [*found, note] if note else found
