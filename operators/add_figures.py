"""Add → Dual-Color: a gradient cylinder, and the cylinders of the paper's Figure 3."""

from __future__ import annotations

import bpy

from ..bridge.objects.picture_objects import add_picture_object
from ..bridge.units import LENGTH_DIGITS
from ..core.errors import PrintError
from ..core.pictures.figure_cylinders import FIGURES, figure_cylinder
from ..core.settings import PrintSettings
from .polls import in_object_mode
from .refusal import refused
from .viewing import show_added

ICONS = {"gradient": "NODE_TEXTURE", "checkered": "TEXTURE", "phase_shifted": "MOD_WAVE", "attenuated": "IPO_SINE"}


class DUALCOLOR_OT_add_figure_cylinder(bpy.types.Operator):
    """Add a cylinder that shows what the pattern does"""

    bl_idname = "dualcolor.add_figure_cylinder"
    bl_label = "Pattern Cylinder"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)

    kind: bpy.props.EnumProperty(
        name="Shows",
        description="What the cylinder shows",
        items=[(kind.upper(), name, words) for kind, (name, words) in FIGURES.items()],
    )
    diameter: bpy.props.FloatProperty(
        name="Diameter",
        description="Diameter of the cylinder",
        default=20.0,
        min=4.0,
        max=140.0,
        unit="CAMERA",
        precision=LENGTH_DIGITS,
    )
    height: bpy.props.FloatProperty(
        name="Height", description="Height, made a whole number of layer pairs", default=36.0, min=2.0, max=150.0,
        unit="CAMERA", precision=LENGTH_DIGITS,
    )  # fmt: skip

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        """What this kind shows."""
        return FIGURES[properties.kind.lower()][1]

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Objects can be added only in object mode."""
        return in_object_mode(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Add the cylinder with the settings that it takes."""
        kind = self.kind.lower()
        settings = PrintSettings(texture_filter="lanczos")
        try:
            made = figure_cylinder(kind, self.diameter, self.height, settings)
        except PrintError as problem:
            return refused(self, problem)
        obj = add_picture_object(made.picture, made.shape, FIGURES[kind][0], made.settings)
        show_added(context, obj)
        return {"FINISHED"}


def draw_figure_entries(layout: bpy.types.UILayout) -> None:
    """An entry a kind."""
    for kind, (name, _) in FIGURES.items():
        entry = layout.operator(DUALCOLOR_OT_add_figure_cylinder.bl_idname, text=name, icon=ICONS[kind])
        entry.kind = kind.upper()
