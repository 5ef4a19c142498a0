"""Analyze Pattern, and remove its overlays."""

from __future__ import annotations

import bpy

from ..bridge.analysis.orientations import keep_orientations
from ..bridge.analysis.overlays import overlays_of, remove_analysis, show_analysis
from ..bridge.properties import as_shown
from ..bridge.strands.preview import source_of
from ..core.analysis.analysis import analysis_steps
from .generate import active_model
from .job import JobOperator, Steps
from .polls import has_printable
from .viewing import show_in_local_views


class DUALCOLOR_OT_analyze(JobOperator, bpy.types.Operator):
    """Show the pattern's seams, its tracelines and slopes too flat for tones on the object"""

    bl_idname = "dualcolor.analyze"
    bl_label = "Analyze Pattern"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """An object with a surface is needed."""
        return has_printable(cls, context)

    def steps(self, context: bpy.types.Context) -> Steps:
        """Analyze the active object alone."""
        yield 0.0, "reading the object"
        obj, model, settings = active_model(context)
        found = yield from analysis_steps(model, settings)
        show_in_local_views(context, obj, show_analysis(found, obj))
        keep_orientations(obj, found.orientations)
        for warning in found.warnings:
            self.report({"WARNING"}, as_shown(warning))
        pattern = found.report["pattern"]
        return f"{obj.name}: {pattern['salient']:.2%} salient seams" if pattern else f"{obj.name}: no waves, no seams"


class DUALCOLOR_OT_remove_analysis(bpy.types.Operator):
    """Remove the overlays of the analysis"""

    bl_idname = "dualcolor.remove_analysis"
    bl_label = "Remove Analysis"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """An analysis is needed."""
        obj = source_of(context.object)
        if obj is None or overlays_of(obj) is None:
            cls.poll_message_set("Nothing is analyzed yet")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Remove it."""
        remove_analysis(source_of(context.object))
        return {"FINISHED"}


OPERATORS = (DUALCOLOR_OT_analyze, DUALCOLOR_OT_remove_analysis)
