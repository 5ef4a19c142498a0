"""Suggest Orientation, and turn the object into a suggested one."""

from __future__ import annotations

import bpy

from ..bridge.analysis.orientations import keep_orientations, orientations_of, turn
from ..bridge.analysis.overlays import remove_analysis
from ..bridge.strands.preview import source_of
from ..core.analysis.analysis import orientations
from ..core.errors import PrintError
from .generate import active_model
from .job import JobOperator, Steps
from .polls import has_printable
from .refusal import refused


class DUALCOLOR_OT_suggest_orientation(JobOperator, bpy.types.Operator):
    """Look for the ways to stand the object on the bed that show most of its picture with little support and height"""

    bl_idname = "dualcolor.suggest_orientation"
    bl_label = "Suggest Orientation"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """An object with a surface is needed."""
        return has_printable(cls, context)

    def steps(self, context: bpy.types.Context) -> Steps:
        """Rank the orientations of the active object and keep them."""
        yield 0.0, "reading the object"
        obj, model, settings = active_model(context)
        yield 0.3, "comparing orientations"
        found = orientations(model, settings)
        keep_orientations(obj, found)
        return f"{obj.name}: the best of {len(found)} orientations shows {found[0].contrast:.0%} of the contrast"


class DUALCOLOR_OT_apply_orientation(bpy.types.Operator):
    """Turn the object this way up, about its middle; its lowest point keeps its height"""

    bl_idname = "dualcolor.apply_orientation"
    bl_label = "Turn"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)

    number: bpy.props.IntProperty(name="Number", min=0, max=100, description="Place in the list, from 0")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Suggestions are needed."""
        obj = source_of(context.object)
        if obj is None or not orientations_of(obj):
            cls.poll_message_set("Run Suggest Orientation first")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Turn it; the overlays of its former orientation go."""
        obj = source_of(context.object)
        count = len(orientations_of(obj))
        if self.number >= count:
            self.report({"ERROR"}, f"There are only {count} orientations")
            return {"CANCELLED"}
        try:
            degrees = turn(obj, self.number)
        except PrintError as problem:
            return refused(self, problem)
        remove_analysis(obj)
        self.report({"INFO"}, f"{obj.name} turned by {degrees:.0f}°")
        return {"FINISHED"}


OPERATORS = (DUALCOLOR_OT_suggest_orientation, DUALCOLOR_OT_apply_orientation)
