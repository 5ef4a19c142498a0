"""All that the extension adds to Blender, and takes away again."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import bpy

from .bridge import properties, results
from .bridge.proof import soft_proof
from .bridge.strands import former_looks, scrubber
from .operators import add
from .operators.analyze import OPERATORS as ANALYZE_OPERATORS
from .operators.calibrate import OPERATORS as CALIBRATE_OPERATORS
from .operators.calibrate import draw_image_entry
from .operators.check_model import OPERATORS as CHECK_OPERATORS
from .operators.export import DUALCOLOR_OT_export_gcode, DUALCOLOR_OT_export_x3g
from .operators.generate import DUALCOLOR_OT_generate
from .operators.import_print import DUALCOLOR_OT_import_print
from .operators.job import stop_job
from .operators.orientation import OPERATORS as ORIENTATION_OPERATORS
from .operators.painting import OPERATORS as PAINTING_OPERATORS
from .operators.presets import OPERATORS as PRESET_OPERATORS
from .operators.render import OPERATORS as RENDER_OPERATORS
from .operators.size import DUALCOLOR_OT_scale_to_height
from .operators.soft_proof import DUALCOLOR_OT_soft_proof
from .operators.supports import DUALCOLOR_OT_mark_support, DUALCOLOR_OT_select_support
from .operators.unwrap import OPERATORS as UNWRAP_OPERATORS
from .panels import bed
from .panels import scrubber as scrubber_panel
from .panels.object_menu import DUALCOLOR_MT_object, draw_faces_entries, draw_object_entry, draw_paint_entry
from .panels.presets import MENUS
from .panels.sidebar import PANELS

PROGRAM = "dualcolor"

CLASSES = (
    DUALCOLOR_OT_generate,
    DUALCOLOR_OT_export_gcode,
    DUALCOLOR_OT_export_x3g,
    DUALCOLOR_OT_import_print,
    *RENDER_OPERATORS,
    DUALCOLOR_OT_mark_support,
    DUALCOLOR_OT_select_support,
    *PRESET_OPERATORS,
    *MENUS,
    *CALIBRATE_OPERATORS,
    *add.CLASSES,
    DUALCOLOR_OT_scale_to_height,
    *CHECK_OPERATORS,
    *ANALYZE_OPERATORS,
    *ORIENTATION_OPERATORS,
    *UNWRAP_OPERATORS,
    *PAINTING_OPERATORS,
    DUALCOLOR_OT_soft_proof,
    *PANELS,
    DUALCOLOR_MT_object,
)

_handles: list[Any] = []


def register() -> None:
    """Add the settings, the operators, the sidebar tab, the entries of the menus and the command line."""
    properties.register()
    results.register()
    scrubber.register()
    former_looks.register()
    for added in CLASSES:
        bpy.utils.register_class(added)
    scrubber_panel.register()
    bed.register()
    bpy.types.TOPBAR_MT_file_export.append(_draw_export_entry)
    bpy.types.TOPBAR_MT_file_import.append(_draw_import_entry)
    bpy.types.VIEW3D_MT_add.append(add.draw_add_entry)
    bpy.types.VIEW3D_MT_object.append(draw_object_entry)
    bpy.types.VIEW3D_MT_editor_menus.append(draw_paint_entry)
    bpy.types.VIEW3D_MT_edit_mesh_faces.append(draw_faces_entries)
    bpy.types.IMAGE_MT_image.append(draw_image_entry)
    _handles.append(bpy.utils.register_cli_command(PROGRAM, _command_line))


def unregister() -> None:
    """Remove them in the reverse order."""
    stop_job(bpy.context)
    soft_proof.hide_all_proofs()
    while _handles:
        bpy.utils.unregister_cli_command(_handles.pop())
    bed.unregister()
    scrubber_panel.unregister()
    bpy.types.IMAGE_MT_image.remove(draw_image_entry)
    bpy.types.VIEW3D_MT_edit_mesh_faces.remove(draw_faces_entries)
    bpy.types.VIEW3D_MT_editor_menus.remove(draw_paint_entry)
    bpy.types.VIEW3D_MT_object.remove(draw_object_entry)
    bpy.types.VIEW3D_MT_add.remove(add.draw_add_entry)
    bpy.types.TOPBAR_MT_file_import.remove(_draw_import_entry)
    bpy.types.TOPBAR_MT_file_export.remove(_draw_export_entry)
    for added in reversed(CLASSES):
        bpy.utils.unregister_class(added)
    former_looks.unregister()
    scrubber.unregister()
    results.unregister()
    properties.unregister()


def _command_line(arguments: Sequence[str]) -> int:
    """`blender --command dualcolor …`; its modules are not needed before."""
    from .cli import main

    return main(arguments)


def _draw_export_entry(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    self.layout.operator(DUALCOLOR_OT_export_gcode.bl_idname, text="Dual-Color G-code (.gcode)")
    self.layout.operator(DUALCOLOR_OT_export_x3g.bl_idname, text="Dual-Color X3G (.x3g)")


def _draw_import_entry(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    self.layout.operator(DUALCOLOR_OT_import_print.bl_idname, text="Dual-Color G-code (.gcode, .x3g)")
