"""Scale to Height."""

from __future__ import annotations

import math

import bpy
import numpy as np

from ..bridge.bed import bounds_mm, scale_to_height
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

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Scale, and show the object as large as the view allows."""
        obj = source_of(context.object)
        if not _height(obj) > 0:
            self.report({"ERROR"}, f"{obj.name} is flat: it has no height to scale")
            return {"CANCELLED"}
        if self.scene_in_mm:
            use_millimeters(context.scene)
        others = [each.name for each in movers(obj) if each != obj]
        try:
            scale_to_height(obj, self.height)
        except PrintError as problem:
            return refused(self, problem)
        frame_selected(context)
        if self.scene_in_mm:
            frame_in_other_views(context, obj)
            for other in context.scene.objects:
                repaint_proof(other)
        now = _height(obj)
        if math.isclose(now, self.height, rel_tol=_CLOSE):
            along = f"; scaled with it: {', '.join(others)}" if others else ""
            self.report({"INFO"}, f"{obj.name} is {now:.1f} mm high{along}")
        else:
            self.report({"WARNING"}, f"{obj.name} is {now:.1f} mm high: a constraint, driver or keyframe sets its size")
        return {"FINISHED"}


def _height(obj: bpy.types.Object) -> float:
    return float(np.ptp(bounds_mm([obj]), axis=0)[2])
