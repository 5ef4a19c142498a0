"""Check Model, select what it found, and Repair."""

from __future__ import annotations

from collections.abc import Generator

import bpy

from ..bridge.analysis.model_check import MEANINGS, TITLES, Findings, check_steps, repair, select
from ..bridge.properties import set_findings
from ..bridge.units import LENGTH_DIGITS
from ..core.progress import Progress, translated
from .job import JobOperator, Steps
from .polls import has_mesh, has_own_mesh
from .viewing import frame_selected

_LINES_OF_A_WALL = 2
_KIND_ITEMS = [(kind, title, MEANINGS[kind].capitalize()) for kind, title in TITLES.items()]


class DUALCOLOR_OT_check_model(JobOperator, bpy.types.Operator):
    """Look for open edges, flipped faces, faces that cross, and walls thinner than two lines"""

    bl_idname = "dualcolor.check_model"
    bl_label = "Check Model"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A mesh in Object Mode is needed."""
        return has_mesh(cls, context)

    def steps(self, context: bpy.types.Context) -> Steps:
        """Check the active object and keep what was found."""
        obj = context.object
        found = yield from _checked(obj)
        counts = found.counts()
        set_findings(obj.dualcolor, counts)
        wrong = [f"{TITLES[kind].lower()}: {count}" for kind, count in counts.items() if count]
        return f"{obj.name}: {', '.join(wrong) or 'nothing is wrong'}"


class DUALCOLOR_OT_select_finding(JobOperator, bpy.types.Operator):
    """Show in Edit Mode what the check has found"""

    bl_idname = "dualcolor.select_finding"
    bl_label = "Select"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)

    kind: bpy.props.EnumProperty(
        name="Kind",
        items=_KIND_ITEMS,
        description="Which findings are selected",
    )

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        """What is selected."""
        return f"Show in Edit Mode the {MEANINGS[properties.kind]}"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A mesh in Object Mode is needed."""
        return has_own_mesh(cls, context)

    def steps(self, context: bpy.types.Context) -> Steps:
        """Check once more, since the mesh may have changed, and select."""
        found = yield from _checked(context.object)
        select(context.object, self.kind, found)
        frame_selected(context)
        return (
            f"{TITLES[self.kind]}: {len(getattr(found, self.kind))} selected; X-Ray (Alt Z) shows those behind others"
        )


class DUALCOLOR_OT_repair_model(bpy.types.Operator):
    """Merge vertices at the same place, fill holes, remove loose vertices and turn all faces outwards"""

    bl_idname = "dualcolor.repair_model"
    bl_label = "Repair"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)

    merge_distance: bpy.props.FloatProperty(
        name="Merge Distance", default=0.001, min=0.0, max=1.0, precision=LENGTH_DIGITS, unit="CAMERA",
        description="Vertices nearer than this become one",
    )  # fmt: skip
    hole_sides: bpy.props.IntProperty(
        name="Largest Hole", default=0, min=0, max=10000,
        description="Holes with more edges than this stay open; 0 fills all holes",
    )  # fmt: skip

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A mesh in Object Mode is needed."""
        return has_own_mesh(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Repair the active object."""
        obj = context.object
        self.report({"INFO"}, f"{obj.name}: {repair(obj, self.merge_distance, self.hole_sides)}")
        set_findings(obj.dualcolor, {})
        return {"FINISHED"}


def _checked(obj: bpy.types.Object) -> Generator[Progress, None, Findings]:
    least_wall = _LINES_OF_A_WALL * obj.dualcolor.extrusion_width
    return translated(check_steps(obj, least_wall), lambda share: (share, "checking the model"))


OPERATORS = (DUALCOLOR_OT_check_model, DUALCOLOR_OT_select_finding, DUALCOLOR_OT_repair_model)
