"""Scale to Height."""

from __future__ import annotations

import math

import bpy
import numpy as np

from ..bridge.bed import bounds_mm, scale_to_height
from ..bridge.input.plate import objects_to_print
from ..bridge.properties import repaint_proof
from ..bridge.rig import movers
from ..bridge.strands.preview import source_of
from ..bridge.units import LENGTH_DIGITS, mm_per_unit, use_millimeters
from ..core.errors import PrintError
from .polls import has_own_settings
from .refusal import refused
from .viewing import frame_in_other_views, frame_selected

_USUAL_MM, _LEAST_MM, _MOST_MM = 60.0, 5.0, 150.0
_CLOSE = 1e-3


class DUALCOLOR_OT_scale_to_height(bpy.types.Operator):
    """Scale the object evenly to the height that it is to be printed with"""

    bl_idname = "dualcolor.scale_to_height"
    bl_label = "Scale to Height"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)

    height: bpy.props.FloatProperty(
        name="Height", default=_USUAL_MM, min=1.0, max=1000.0, precision=LENGTH_DIGITS, unit="CAMERA",
        description="Height of the printed object",
    )  # fmt: skip
    together: bpy.props.BoolProperty(
        name="All Selected",
        description="Make all selected objects together that high, as parts of one thing; "
        "otherwise only the active one is scaled",
        options={"SKIP_SAVE"},
    )
    scene_in_mm: bpy.props.BoolProperty(
        name="Scene in Millimeters",
        description="Make a unit of the scene a millimeter, so that brushes, grid and views suit small things. "
        "The numbers of all other objects stay, so they become smaller",
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """An object with a surface is needed, not in Edit Mode."""
        if not has_own_settings(cls, context):
            return False
        if source_of(context.object).mode == "EDIT":
            cls.poll_message_set("Leave Edit Mode first")
            return False
        return True

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Ask for the height, which is as it was if it can be; a scene in meters is best changed at this moment."""
        now = _height(source_of(context.object))
        self.height = now if _LEAST_MM < now <= _MOST_MM else _USUAL_MM
        self.scene_in_mm = mm_per_unit(context.scene) != 1.0
        return context.window_manager.invoke_props_dialog(self)

    def draw(self, context: bpy.types.Context) -> None:
        """The height, of what, and the scene's unit."""
        self.layout.prop(self, "height")
        if len(objects_to_print(context)) > 1:
            self.layout.prop(self, "together")
        self.layout.prop(self, "scene_in_mm")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Scale, and show the object as large as the view allows."""
        obj = source_of(context.object)
        objects = objects_to_print(context) if self.together else [obj]
        if not _height(*objects) > 0:
            self.report({"ERROR"}, f"{obj.name} is flat: it has no height to scale")
            return {"CANCELLED"}
        if self.scene_in_mm:
            use_millimeters(context.scene)
        others = [each.name for each in movers(*objects) if each not in objects]
        try:
            scale_to_height(objects, self.height)
        except PrintError as problem:
            return refused(self, problem)
        frame_selected(context)
        if self.scene_in_mm:
            frame_in_other_views(context, obj)
            for other in context.scene.objects:
                repaint_proof(other)
        now = _height(*objects)
        more = f" with {len(objects) - 1} more" if len(objects) > 1 else ""
        if math.isclose(now, self.height, rel_tol=_CLOSE):
            along = f"; scaled with it: {', '.join(others)}" if others else ""
            self.report({"INFO"}, f"{obj.name}{more} is {now:.1f} mm high{along}")
        else:
            why = "a constraint, driver or keyframe sets its size"
            self.report({"WARNING"}, f"{obj.name}{more} is {now:.1f} mm high: {why}")
        return {"FINISHED"}


def _height(*objects: bpy.types.Object) -> float:
    return float(np.ptp(bounds_mm(objects), axis=0)[2])
