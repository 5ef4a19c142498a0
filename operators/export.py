"""Export Replicator 2X G-code and X3G."""

from __future__ import annotations

from pathlib import Path

import bpy

from ..bridge.properties import set_report
from ..bridge.strands.preview import source_of
from ..core.exports import export_gcode, export_x3g
from ..core.files import file_size
from .file_choice import FileJob
from .generate import printed, with_warnings
from .job import Steps
from .polls import has_printable


class PrintExport(FileJob):
    """What both exports share; the class gives the suffix, the writer and the report's entry."""

    kind = ""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """An object with a surface is needed."""
        return has_printable(cls, context)

    def steps(self, context: bpy.types.Context) -> Steps:
        """Print the chosen objects unless that is done, and write the file."""
        obj = source_of(context.object)
        path = Path(bpy.path.abspath(self.filepath))
        result = yield from printed(context, reuse=True, begin_gcode=self.kind == "gcode")
        # In one step with the strands: whoever stops the job then finds nothing changed.
        result = WRITERS[self.kind](result, path)
        set_report(obj.dualcolor, result.report)
        # No report of a warning: one that follows a file browser pops up.
        return with_warnings(f"{path.name}: {file_size(result.report[self.kind]['bytes'])}", result)


WRITERS = {"gcode": export_gcode, "x3g": export_x3g}


class DUALCOLOR_OT_export_gcode(PrintExport, bpy.types.Operator):
    """Write the toolpath of the object as it is now; it is generated again if anything has changed"""

    bl_idname = "dualcolor.export_gcode"
    bl_label = "Export Replicator 2X G-code"
    bl_options = {"UNDO"}  # noqa: RUF012  (Blender reads the class)
    kind = "gcode"
    filename_ext = ".gcode"
    filter_glob: bpy.props.StringProperty(default="*.gcode", options={"HIDDEN"})


class DUALCOLOR_OT_export_x3g(PrintExport, bpy.types.Operator):
    """Write the X3G file that the printer reads from its card; it is generated again if anything has changed"""

    bl_idname = "dualcolor.export_x3g"
    bl_label = "Export Replicator 2X X3G"
    bl_options = {"UNDO"}  # noqa: RUF012  (Blender reads the class)
    kind = "x3g"
    filename_ext = ".x3g"
    filter_glob: bpy.props.StringProperty(default="*.x3g", options={"HIDDEN"})
