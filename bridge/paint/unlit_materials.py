"""Copies of materials that shine in the colors of their shaders, so that these can be baked without any light."""

from __future__ import annotations

import bpy

from ..input.base_color import has_nodes
from ..materials import new_material

_COLORS = ("Base Color", "Color")
_JOINING = ("MIX_SHADER", "ADD_SHADER", "GROUP")  # shaders that only pass others on
_CLEAR = ("BSDF_TRANSPARENT", "HOLDOUT")


def unlit_copy(
    material: bpy.types.Material | None, background: float
) -> tuple[bpy.types.Material, list[bpy.types.NodeTree]]:
    """A material that emits what another one shows, and the node groups that were made for it.

    Each shader becomes an emission of its color, and of what it emits itself; mixes of shaders stay.

    Args:
        material: is kept; None shows the background.
        background: tone where the material is transparent.
    """
    if material is None or not has_nodes(material):
        gray = (background,) * 3 if material is None else material.diffuse_color[:3]
        copy = new_material("Unlit")
        copy.node_tree.nodes.clear()
        output = copy.node_tree.nodes.new("ShaderNodeOutputMaterial")
        copy.node_tree.links.new(_emission(copy.node_tree, gray), output.inputs["Surface"])
        return copy, []
    copy = material.copy()
    tree = copy.node_tree
    output = tree.get_output_node("ALL")
    for other in [node for node in tree.nodes if node.type == "OUTPUT_MATERIAL" and node != output]:
        tree.nodes.remove(other)
    output.target = "ALL"
    for link in [*output.inputs["Volume"].links, *output.inputs["Displacement"].links]:
        tree.links.remove(link)
    groups: dict[bpy.types.NodeTree, bpy.types.NodeTree] = {}
    _unlight(tree, background, groups)
    return copy, list(groups.values())


def _unlight(tree: bpy.types.NodeTree, background: float, groups: dict[bpy.types.NodeTree, bpy.types.NodeTree]) -> None:
    """Exchange the shaders of a node tree for emissions; `groups` are the groups with shaders, and their copies."""
    for node in [node for node in tree.nodes if not node.mute and _makes_shader(node)]:
        if node.type == "GROUP" and node.node_tree:
            inner = node.node_tree
            if inner not in groups:
                groups[inner] = inner.copy()
                _unlight(groups[inner], background, groups)
            node.node_tree = groups[inner]
        elif node.type not in _JOINING:
            shining = _shining(tree, node, background)
            for link in list(node.outputs[0].links):
                tree.links.new(shining, link.to_socket)


def _makes_shader(node: bpy.types.Node) -> bool:
    return node.type != "GROUP_INPUT" and any(outlet.type == "SHADER" for outlet in node.outputs)


def _shining(tree: bpy.types.NodeTree, node: bpy.types.Node, background: float) -> bpy.types.NodeSocket:
    """What takes the place of a shader."""
    clear = (background,) * 3
    if node.type in _CLEAR:
        return _emission(tree, clear)
    color = next((node.inputs[name] for name in _COLORS if name in node.inputs), None)
    made = _emission(tree, color)
    if node.type == "EMISSION":
        _follow(tree, made.node.inputs["Strength"], node.inputs["Strength"])
    elif "Emission Color" in node.inputs:
        own = _emission(tree, node.inputs["Emission Color"])
        _follow(tree, own.node.inputs["Strength"], node.inputs["Emission Strength"])
        both = tree.nodes.new("ShaderNodeAddShader")
        tree.links.new(made, both.inputs[0])
        tree.links.new(own, both.inputs[1])
        made = both.outputs[0]
    alpha = node.inputs.get("Alpha")
    if alpha and (alpha.is_linked or alpha.default_value < 1.0):
        mix = tree.nodes.new("ShaderNodeMixShader")
        _follow(tree, mix.inputs[0], alpha)
        tree.links.new(_emission(tree, clear), mix.inputs[1])
        tree.links.new(made, mix.inputs[2])
        made = mix.outputs[0]
    return made


def _emission(tree: bpy.types.NodeTree, color: bpy.types.NodeSocket | tuple[float, ...] | None) -> bpy.types.NodeSocket:
    """An emission of a socket's color, of a plain one, or of none."""
    node = tree.nodes.new("ShaderNodeEmission")
    if isinstance(color, bpy.types.NodeSocket):
        _follow(tree, node.inputs["Color"], color)
    else:
        node.inputs["Color"].default_value = (*(color or (0.0,) * 3), 1.0)
    return node.outputs[0]


def _follow(tree: bpy.types.NodeTree, socket: bpy.types.NodeSocket, other: bpy.types.NodeSocket) -> None:
    """Give an input what another one gets; a light brighter than white is white."""
    if other.is_linked:
        tree.links.new(other.links[0].from_socket, socket)
    elif socket.type == "VALUE":
        socket.default_value = min(other.default_value, 1.0)
    else:
        socket.default_value = other.default_value
