"""The source of a material's color, found in its nodes."""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from ...core.records import dataclass

Groups = tuple[bpy.types.Node, ...]
COLOR_INPUT = {"BSDF_PRINCIPLED": "Base Color", "BSDF_DIFFUSE": "Color", "EMISSION": "Color"}


@dataclass(frozen=True)
class BaseColor:
    """Where a material's color comes from: at most one of image, attribute and color.

    Attributes:
        image: the picture, or None.
        uv_map: name of the UV map that the picture asks for, "" for the one to render.
        attribute: name of a color attribute, or "".
        color: linear RGBA of a plain color, or None.
    """

    image: bpy.types.Image | None = None
    uv_map: str = ""
    attribute: str = ""
    color: tuple[float, float, float, float] | None = None


def base_color(material: bpy.types.Material | None) -> BaseColor:
    """The source of a material's base color.

    Follows the output's surface back through mixes, reroutes and groups to a Principled, Diffuse or Emission shader,
    and from its color input to the nearest image or color attribute. An image beats a plain color farther on.
    """
    if material is None:
        return BaseColor()
    without_nodes = bpy.app.version < (5, 0) and not material.use_nodes
    tree = None if without_nodes else material.node_tree
    output = tree.get_output_node("ALL") if tree else None
    if output is None:
        return BaseColor(color=tuple(material.diffuse_color))
    plain = BaseColor()
    for node, groups in _upstream(output.inputs["Surface"], ()):
        if node.type == "TEX_IMAGE" and node.image:
            return _of_image_node(node, groups)
        if node.type in COLOR_INPUT:
            found = _of_socket(node.inputs[COLOR_INPUT[node.type]], groups)
            if found.image or found.attribute:
                return found
            plain = plain if plain.color else found
    return plain


def chosen_color(colors: list[BaseColor], image: bpy.types.Image, mesh: bpy.types.Mesh) -> BaseColor:
    """Where the color of an object comes from whose picture the user has chosen, instead of its materials' `colors`.

    The picture lies as a material shows it; one that no material shows, by the active UV map, as strokes do.
    """
    active = mesh.uv_layers.active
    unseen = BaseColor(image=image, uv_map=active.name if active else "")
    return next((color for color in colors if color.image == image), unseen)


def picture_layer(color: BaseColor, mesh: bpy.types.Mesh) -> bpy.types.MeshUVLoopLayer | None:
    """The UV map by which a picture is seen: the one that it asks for, else the one to render; None without any."""
    layers = mesh.uv_layers
    return layers.get(color.uv_map) or next((layer for layer in layers if layer.active_render), layers.active)


def _of_socket(socket: bpy.types.NodeSocket, groups: Groups) -> BaseColor:
    if not socket.is_linked:
        return BaseColor(color=tuple(socket.default_value))
    plain = BaseColor()
    for node, within in _upstream(socket, groups):
        if node.type == "TEX_IMAGE" and node.image:
            return _of_image_node(node, within)
        if node.type == "VERTEX_COLOR":
            plain = BaseColor(attribute=node.layer_name)
        elif node.type == "ATTRIBUTE":
            plain = BaseColor(attribute=node.attribute_name)
        elif node.type == "RGB" and not plain.attribute:
            plain = BaseColor(color=tuple(node.outputs[0].default_value))
    return plain


def _of_image_node(node: bpy.types.ShaderNodeTexImage, groups: Groups) -> BaseColor:
    sources = (source for source, _ in _upstream(node.inputs["Vector"], groups))
    return BaseColor(image=node.image, uv_map=next((each.uv_map for each in sources if each.type == "UVMAP"), ""))


def _upstream(socket: bpy.types.NodeSocket, groups: Groups) -> Iterator[tuple[bpy.types.Node, Groups]]:
    """Nodes that feed a socket, nearest first, each once, with the groups that they are in.

    A mix's factor and a picture's coordinates are left out.

    Args:
        socket: an input.
        groups: the group nodes that the socket is in, the outermost first.
    """
    waiting = _feeding(socket, groups)
    seen: set[tuple[str, ...]] = set()
    while waiting:
        node, outlet, groups = waiting.pop(0)
        way = outlet.identifier if node.type in ("GROUP", "GROUP_INPUT") else ""
        place = (*(group.name for group in groups), node.name, way)
        if place in seen:
            continue
        seen.add(place)
        if node.type == "GROUP" and node.node_tree:
            ends = [each for each in node.node_tree.nodes if each.type == "GROUP_OUTPUT" and each.is_active_output]
            waiting[:0] = [each for end in ends for each in _feeding(_same(end.inputs, outlet), (*groups, node))]
        elif node.type == "GROUP_INPUT":
            waiting[:0] = _feeding(_same(groups[-1].inputs, outlet), groups[:-1]) if groups else []
        else:
            yield node, groups
            if node.type != "TEX_IMAGE" and node.type not in COLOR_INPUT:
                followed = [each for each in node.inputs if each.enabled and not each.name.startswith("Fac")]
                waiting.extend(source for each in followed for source in _feeding(each, groups))


def _feeding(
    socket: bpy.types.NodeSocket | None, groups: Groups
) -> list[tuple[bpy.types.Node, bpy.types.NodeSocket, Groups]]:
    """The nodes that a socket is linked to, the outputs that feed it, and the groups that all are in."""
    return [(link.from_node, link.from_socket, groups) for link in socket.links] if socket else []


def _same(sockets: bpy.types.NodeInputs, outlet: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
    """The socket on the other side of a group's border."""
    return next((each for each in sockets if each.identifier == outlet.identifier), None)
