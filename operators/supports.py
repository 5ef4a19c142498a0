"""Mark Faces for Supports, Select Marked Faces."""

from __future__ import annotations

import bpy

from ..bridge.input.support_marks import mark_selected_faces, select_marked_faces
from ..core.model import SupportMark

_MARKS = [
    (SupportMark.ENFORCER.name, "Enforce", "Overhangs here get supports, however steep they are"),
    (SupportMark.BLOCKER.name, "Block", "Overhangs here get no supports"),
    (SupportMark.NONE.name, "Clear", "The threshold angle decides"),
]


class _EditMode:
    """What both operators need: meshes in Edit Mode."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Edit Mode is needed."""
        if context.mode != "EDIT_MESH":
            cls.poll_message_set("Select faces in Edit Mode first")
            return False
        return True

    @staticmethod
    def meshes(context: bpy.types.Context) -> list[bpy.types.Mesh]:
        """Of all objects that are edited, each once."""
        return [obj.data for obj in context.objects_in_mode_unique_data]


class DUALCOLOR_OT_mark_support(_EditMode, bpy.types.Operator):
    """Enforce or block supports under the overhangs of the selected faces"""

    bl_idname = "dualcolor.mark_support"
    bl_label = "Mark Selected Faces for Supports"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)
    mark: bpy.props.EnumProperty(name="Supports", description="What the faces are for", items=_MARKS)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Write the attribute."""
        count = sum(mark_selected_faces(mesh, SupportMark[self.mark]) for mesh in self.meshes(context))
        if not count:
            self.report({"WARNING"}, "No face is selected")
            return {"CANCELLED"}
        self.report({"INFO"}, f"{count} faces: {self.mark.lower()}")
        return {"FINISHED"}


class DUALCOLOR_OT_select_support(_EditMode, bpy.types.Operator):
    """Select the faces that are marked, to see or change them"""

    bl_idname = "dualcolor.select_support"
    bl_label = "Select Faces Marked for Supports"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)
    mark: bpy.props.EnumProperty(name="Supports", description="Which faces", items=_MARKS[:2])

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Change the selection."""
        count = sum(select_marked_faces(mesh, SupportMark[self.mark]) for mesh in self.meshes(context))
        self.report({"INFO"}, f"{count} faces")
        return {"FINISHED"}
