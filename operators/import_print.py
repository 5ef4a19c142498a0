"""Import Replicator 2X G-code."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy_extras.io_utils import ImportHelper

from ..bridge.strands.preview import build_preview
from ..bridge.strands.print_file import read_print
from ..core.errors import PrintError
from .refusal import refused
from .viewing import show_imported


class DUALCOLOR_OT_import_print(ImportHelper, bpy.types.Operator):
    """Show the print in a G-code or X3G file as strands"""

    bl_idname = "dualcolor.import_print"
    bl_label = "Import Replicator 2X G-code"
    bl_options = {"UNDO"}  # noqa: RUF012  (Blender reads the class)
    filename_ext = ".gcode"
    filter_glob: bpy.props.StringProperty(default="*.gcode;*.x3g", options={"HIDDEN"})

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Read the file and build the strands."""
        try:
            read = read_print(Path(bpy.path.abspath(self.filepath)))
        except PrintError as problem:
            return refused(self, problem)
        show_imported(context, build_preview(read))
        self.report({"INFO"}, f"{read.name}: {read.summary}")
        return {"FINISHED"}
