"""Soft Proof: the picture as it will print, while it is painted."""

from __future__ import annotations

import bpy

from ..bridge.proof.proof_views import show_as_before, show_materials
from ..bridge.proof.soft_proof import hide_proof, is_proofed, proof_notes, show_proof
from ..bridge.properties import as_shown, to_settings
from ..bridge.strands.preview import show_print
from ..core.errors import PrintError
from .polls import has_own_mesh
from .refusal import refused


class DUALCOLOR_OT_soft_proof(bpy.types.Operator):
    """Show the picture as it will print, even while it is painted: with the detail of the print, in tones that walls \
of that slope can show, striped where it is too flat for tones. Press again to see the object as it was"""

    bl_idname = "dualcolor.soft_proof"
    bl_label = "Soft Proof"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A mesh of this file is needed, in Object or a painting mode."""
        return has_own_mesh(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Turn it on or off."""
        obj = context.object
        if is_proofed(obj):
            hide_proof(obj)
            if not any(is_proofed(other) for other in context.scene.objects):
                show_as_before()
            return {"FINISHED"}
        try:
            show_proof(obj, to_settings(obj.dualcolor))
        except PrintError as problem:
            return refused(self, problem)
        show_print(obj, False)  # its strands would stand in front
        show_materials(context)
        for note in proof_notes(obj):
            self.report({"INFO"}, as_shown(note))
        return {"FINISHED"}
