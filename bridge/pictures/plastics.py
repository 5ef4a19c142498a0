"""The two plastics of the predicted print."""

from __future__ import annotations

import bpy

from ..materials import new_material

REFLECTANCE = {"Black": 0.02, "White": 0.8}
"""Diffuse reflectance, linear, of ABS in both colors."""

_ROUGHNESS = 0.4
_REFRACTIVE_INDEX = 1.53


def plastic(color: str) -> bpy.types.Material:
    """The material `<color> ABS`; one that is there already is used as it is, so that a user may change it.

    Args:
        color: "Black" or "White".
    """
    name = f"{color} ABS"
    return bpy.data.materials.get(name) or diffuse_material(name, REFLECTANCE[color], _ROUGHNESS, _REFRACTIVE_INDEX)


def diffuse_material(name: str, reflectance: float, roughness: float, refractive_index: float) -> bpy.types.Material:
    """A new gray dielectric, the same in the viewport and in Cycles."""
    material = new_material(name)
    material.diffuse_color = (reflectance, reflectance, reflectance, 1.0)
    material.roughness = roughness
    nodes = material.node_tree.nodes
    nodes.clear()
    surface = nodes.new("ShaderNodeBsdfPrincipled")
    surface.inputs["Base Color"].default_value = (reflectance, reflectance, reflectance, 1.0)
    surface.inputs["Roughness"].default_value = roughness
    surface.inputs["IOR"].default_value = refractive_index
    output = nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(surface.outputs["BSDF"], output.inputs["Surface"])
    return material
