"""Unwrap with xatlas, or quickly by Smart UV Project."""

from __future__ import annotations

import importlib.util
from dataclasses import fields
from functools import cache

import bpy

from ..bridge.paint.unwrap import smart_project, unwrap_steps
from ..bridge.properties import repaint_proof
from ..bridge.units import LENGTH_DIGITS
from ..core.errors import PrintError
from ..core.mesh.unwrapping import ChartOptions, PackOptions
from .job import JobOperator, Steps
from .polls import has_own_mesh
from .refusal import refused


@cache
def has_xatlas() -> bool:
    """Whether xatlas is installed; it is not looked for at every move of the mouse."""
    return importlib.util.find_spec("xatlas") is not None


class DUALCOLOR_OT_unwrap_xatlas(JobOperator, bpy.types.Operator):
    """Make a new UV map of few large charts for painting; the old UV maps are kept. Splits polygons into triangles"""

    bl_idname = "dualcolor.unwrap_xatlas"
    bl_label = "Unwrap with xatlas"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)

    max_cost: bpy.props.FloatProperty(
        name="Max Cost", default=ChartOptions.max_cost, min=0.1, max=64.0,
        description="The higher, the fewer and the more bent charts",
    )  # fmt: skip
    max_iterations: bpy.props.IntProperty(
        name="Max Iterations", default=ChartOptions.max_iterations, min=1, max=16,
        description="How often charts are grown anew from better seeds",
    )  # fmt: skip
    normal_deviation_weight: bpy.props.FloatProperty(
        name="Normal Deviation Weight", default=ChartOptions.normal_deviation_weight, min=0.0, max=100.0,
        description="Weight of faces that look elsewhere than their chart",
    )  # fmt: skip
    roundness_weight: bpy.props.FloatProperty(
        name="Roundness Weight", default=ChartOptions.roundness_weight, min=0.0, max=100.0,
        description="Weight of charts that are not round",
    )  # fmt: skip
    straightness_weight: bpy.props.FloatProperty(
        name="Straightness Weight", default=ChartOptions.straightness_weight, min=0.0, max=100.0,
        description="Weight of charts with ragged borders",
    )  # fmt: skip
    normal_seam_weight: bpy.props.FloatProperty(
        name="Normal Seam Weight", default=ChartOptions.normal_seam_weight, min=0.0, max=1000.0,
        description="Weight of cutting where the surface is smooth",
    )  # fmt: skip
    texel_size: bpy.props.FloatProperty(
        name="Texel Size", default=0.0, min=0.0, max=10.0, precision=LENGTH_DIGITS, unit="CAMERA",
        description="Side of a texel, to which the padding is measured; 0 is half a layer",
    )  # fmt: skip
    padding: bpy.props.IntProperty(
        name="Padding", default=PackOptions.padding, min=0, max=64, description="Texels between charts"
    )
    rotate_charts: bpy.props.BoolProperty(
        name="Rotate Charts", default=PackOptions.rotate_charts, description="Turn charts to pack them more closely"
    )
    brute_force: bpy.props.BoolProperty(
        name="Brute Force", default=PackOptions.bruteForce, description="Search for the best packing; slow"
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A mesh in Object Mode is needed, and xatlas."""
        if not has_xatlas():
            cls.poll_message_set("xatlas is not installed; use Smart UV Project")
            return False
        return has_own_mesh(cls, context)

    def steps(self, context: bpy.types.Context) -> Steps:
        """Unwrap the active object."""
        obj = context.object
        charting = (declared.name for declared in fields(ChartOptions) if hasattr(self, declared.name))
        chart = ChartOptions(**{name: getattr(self, name) for name in charting})
        texel = self.texel_size or obj.dualcolor.layer_height / 2
        pack = PackOptions(1.0 / texel, self.padding, self.rotate_charts, self.brute_force)
        for share in unwrap_steps(obj, chart, pack):
            yield share, "unwrapping"
        repaint_proof(obj)
        return f"{obj.name}: unwrapped into the UV map {obj.data.uv_layers.active.name}"


class DUALCOLOR_OT_unwrap_smart(bpy.types.Operator):
    """Make a new UV map of many small charts, without waiting; the old UV maps are kept"""

    bl_idname = "dualcolor.unwrap_smart"
    bl_label = "Smart UV Project"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A mesh in Object Mode is needed."""
        return has_own_mesh(cls, context, leaves_mode=True)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Unwrap the active object."""
        try:
            smart_project(context.object)
        except PrintError as problem:
            return refused(self, problem)
        repaint_proof(context.object)
        return {"FINISHED"}


OPERATORS = (DUALCOLOR_OT_unwrap_xatlas, DUALCOLOR_OT_unwrap_smart)
