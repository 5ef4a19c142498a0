"""The materials that an object is printed with, even while the soft proof covers them."""

from __future__ import annotations

import bpy

PROOF_KEY = "dualcolor_soft_proof"
"""Marks a material of the soft proof: how the slot was linked that it is laid over, "" for none."""

COVERED_KEY = "dualcolor_covered"
"""On such a material, the one of the object's own that it is laid over."""


def printed_materials(obj: bpy.types.Object) -> list[bpy.types.Material | None]:
    """The material of each slot; where the soft proof is laid over it, the one below."""
    return [printed_material(obj, slot) for slot in obj.material_slots]


def printed_material(obj: bpy.types.Object, slot: bpy.types.MaterialSlot) -> bpy.types.Material | None:
    """The material of one slot."""
    shown = slot.material
    if not is_proof(shown):
        return shown
    return shown.get(COVERED_KEY) if shown[PROOF_KEY] == "OBJECT" else obj.data.materials[slot.slot_index]


def is_proof(material: bpy.types.Material | None) -> bool:
    """Whether a material is one of the soft proof."""
    return material is not None and PROOF_KEY in material
