"""Render Predicted Print."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy_extras.io_utils import ExportHelper

from ..bridge.curves import preview_of, source_of
from ..bridge.render import render_prediction
from ..core.errors import PrintError


class DUALCOLOR_OT_render_prediction(ExportHelper, bpy.types.Operator):
    """Render the strands in a small studio with Cycles; the scene stays as it is"""

    bl_idname = "dualcolor.render_prediction"
    bl_label = "Render Predicted Print"
    filename_ext = ".png"
    filter_glob: bpy.props.StringProperty(default="*.png", options={"HIDDEN"})
    width: bpy.props.IntProperty(name="Width", default=900, min=16, max=8192, subtype="PIXEL")
    height: bpy.props.IntProperty(name="Height", default=900, min=16, max=8192, subtype="PIXEL")
    samples: bpy.props.IntProperty(name="Samples", description="Most rays a pixel", default=64, min=1, max=4096)
    whole_plate: bpy.props.BoolProperty(name="Whole Plate", description="Show the cleaning tower and the skirt too")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Strands are needed."""
        obj = source_of(context.object)
        if obj is None or preview_of(obj) is None:
            cls.poll_message_set("Generate the toolpath first")
            return False
        return True

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the file."""
        if not self.filepath:
            self.filepath = bpy.path.clean_name(source_of(context.object).name) + self.filename_ext
        return ExportHelper.invoke(self, context, event)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Render and write the file."""
        path = Path(bpy.path.abspath(self.filepath))
        strands = preview_of(source_of(context.object))
        try:
            render_prediction(strands, path, (self.width, self.height), self.samples, whole_plate=self.whole_plate)
        except PrintError as problem:
            self.report({"ERROR"}, str(problem))
            return {"CANCELLED"}
        self.report({"INFO"}, f"Saved {path.name}")
        return {"FINISHED"}
