"""What the panels of the tab Dual Color have in common."""

from __future__ import annotations

import bpy

from ..bridge.input.mesh_input import WITH_SURFACE
from ..bridge.input.metaballs import metaball_of
from ..bridge.strands.preview import source_of

STAGES = ("main", "prepare", "paint", "pattern", "print", "predict", "calibrate")
"""The tab's panels from the top, as the work goes; what belongs to one of them folds away inside it."""


def order_of(stage: str) -> int:
    """The place of a stage's panel in the tab."""
    return STAGES.index(stage)


class Tab:
    """Where all panels of this extension are."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Dual Color"


class ObjectPanel(Tab):
    """A panel that is there only for an object that can be printed."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """An object that can be printed is needed, no mere part of a metaball."""
        obj = source_of(context.object)
        return obj is not None and obj.type in WITH_SURFACE and metaball_of(obj, context.scene) == obj
