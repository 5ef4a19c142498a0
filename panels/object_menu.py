"""The menu Dual-Color, in the menu Object or beside View: the sidebar's buttons for search (F3), favorites and keys."""

from __future__ import annotations

import bpy

from ..operators.analyze import DUALCOLOR_OT_analyze, DUALCOLOR_OT_remove_analysis
from ..operators.calibrate import DUALCOLOR_OT_read_calibration_photo
from ..operators.check_model import DUALCOLOR_OT_check_model, DUALCOLOR_OT_repair_model
from ..operators.export import DUALCOLOR_OT_export_gcode, DUALCOLOR_OT_export_x3g
from ..operators.generate import DUALCOLOR_OT_generate
from ..operators.orientation import DUALCOLOR_OT_suggest_orientation
from ..operators.painting import (
    DUALCOLOR_OT_bake_material,
    DUALCOLOR_OT_bake_occlusion,
    DUALCOLOR_OT_gray_from_color,
    DUALCOLOR_OT_set_up_painting,
)
from ..operators.presets import (
    DUALCOLOR_OT_export_settings,
    DUALCOLOR_OT_import_settings,
    DUALCOLOR_OT_reset_settings,
)
from ..operators.render import DUALCOLOR_OT_export_strands, DUALCOLOR_OT_render_prediction
from ..operators.size import DUALCOLOR_OT_scale_to_height
from ..operators.soft_proof import DUALCOLOR_OT_soft_proof
from ..operators.supports import DUALCOLOR_OT_mark_support, DUALCOLOR_OT_select_support
from ..operators.unwrap import DUALCOLOR_OT_unwrap_smart, DUALCOLOR_OT_unwrap_xatlas

ENTRIES = (
    (
        DUALCOLOR_OT_scale_to_height,
        DUALCOLOR_OT_check_model,
        DUALCOLOR_OT_repair_model,
        DUALCOLOR_OT_suggest_orientation,
    ),
    (
        DUALCOLOR_OT_unwrap_xatlas,
        DUALCOLOR_OT_unwrap_smart,
        DUALCOLOR_OT_set_up_painting,
        DUALCOLOR_OT_gray_from_color,
        DUALCOLOR_OT_bake_material,
        DUALCOLOR_OT_bake_occlusion,
        DUALCOLOR_OT_soft_proof,
    ),
    (DUALCOLOR_OT_analyze, DUALCOLOR_OT_remove_analysis),
    (DUALCOLOR_OT_generate, DUALCOLOR_OT_export_x3g, DUALCOLOR_OT_export_gcode),
    (DUALCOLOR_OT_render_prediction, DUALCOLOR_OT_export_strands),
    (DUALCOLOR_OT_read_calibration_photo,),
    (DUALCOLOR_OT_reset_settings, DUALCOLOR_OT_import_settings, DUALCOLOR_OT_export_settings),
)
"""In the order of the work, with a line between its stages."""


class DUALCOLOR_MT_object(bpy.types.Menu):
    """What can be done with the active object."""

    bl_label = "Dual-Color"

    def draw(self, _context: bpy.types.Context) -> None:
        """One entry an action."""
        for number, stage in enumerate(ENTRIES):
            if number:
                self.layout.separator()
            for action in stage:
                self.layout.operator(action.bl_idname)


def draw_object_entry(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """The entry of the menu Object."""
    self.layout.separator()
    self.layout.menu(DUALCOLOR_MT_object.__name__)


def draw_faces_entries(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """The entries of the menu Face in Edit Mode, one for each mark."""
    self.layout.separator()
    self.layout.operator_menu_enum(DUALCOLOR_OT_mark_support.bl_idname, "mark")
    self.layout.operator_menu_enum(DUALCOLOR_OT_select_support.bl_idname, "mark")


def draw_paint_entry(self: bpy.types.Menu, context: bpy.types.Context) -> None:
    """The same menu beside the menu View in painting modes, in which there is no menu Object."""
    if context.mode in ("PAINT_TEXTURE", "PAINT_VERTEX"):
        self.layout.menu(DUALCOLOR_MT_object.__name__)
