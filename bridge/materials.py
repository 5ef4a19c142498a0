"""New materials, with nodes in all versions of Blender."""

from __future__ import annotations

import bpy


def new_material(name: str) -> bpy.types.Material:
    """A material with the usual nodes, which before Blender 5 have to be asked for."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None:  # Blender 5 gives every material its nodes and warns about the next line
        material.use_nodes = True
    return material


def principled(material: bpy.types.Material) -> bpy.types.ShaderNodeBsdfPrincipled:
    """The Principled shader of a material that this program has made."""
    return next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")


def picture_node(material: bpy.types.Material) -> bpy.types.ShaderNodeTexImage:
    """A node for the picture that becomes a new material's base color; it is active, to bake and paint into."""
    tree = material.node_tree
    shader = principled(material)
    node = tree.nodes.new("ShaderNodeTexImage")
    node.location = (-320, 280)
    tree.links.new(node.outputs["Color"], shader.inputs["Base Color"])
    tree.nodes.active = node
    return node
