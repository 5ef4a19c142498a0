"""What a material's colour comes from, read off its nodes."""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from ..core.records import dataclass

COLOUR_INPUT = {"BSDF_PRINCIPLED": "Base Color", "BSDF_DIFFUSE": "Color", "EMISSION": "Color"}


@dataclass(frozen=True)
class BaseColour:
    """Where a material's colour comes from: at most one of image, attribute and colour.

    Attributes:
        image: the picture, or None.
        uv_map: name of the UV map that the picture asks for, "" for the active one.
        attribute: name of a colour attribute, or "".
        colour: linear RGBA of a plain colour, or None.
    """

    image: bpy.types.Image | None = None
    uv_map: str = ""
    attribute: str = ""
    colour: tuple[float, float, float, float] | None = None


def base_colour(material: bpy.types.Material | None) -> BaseColour:
    """The source of a material's base colour.

    Follows the output's surface back through mixes and reroutes to a Principled, Diffuse or Emission shader, and
    from its colour input to the nearest image or colour attribute. An image beats a plain colour farther on.
    """
    if material is None:
        return BaseColour()
    without_nodes = bpy.app.version < (5, 0) and not material.use_nodes
    tree = None if without_nodes else material.node_tree
    output = tree.get_output_node("ALL") if tree else None
    if output is None:
        return BaseColour(colour=tuple(material.diffuse_color))
    plain = BaseColour()
    for node in _upstream(output.inputs["Surface"]):
        if node.type == "TEX_IMAGE" and node.image:
            return _of_image_node(node)
        if node.type in COLOUR_INPUT:
            found = _of_socket(node.inputs[COLOUR_INPUT[node.type]])
            if found.image or found.attribute:
                return found
            plain = plain if plain.colour else found
    return plain


def _of_socket(socket: bpy.types.NodeSocket) -> BaseColour:
    if not socket.is_linked:
        return BaseColour(colour=tuple(socket.default_value))
    plain = BaseColour()
    for node in _upstream(socket):
        if node.type == "TEX_IMAGE" and node.image:
            return _of_image_node(node)
        if node.type == "VERTEX_COLOR":
            plain = BaseColour(attribute=node.layer_name)
        elif node.type == "ATTRIBUTE":
            plain = BaseColour(attribute=node.attribute_name)
        elif node.type == "RGB" and not plain.attribute:
            plain = BaseColour(colour=tuple(node.outputs[0].default_value))
    return plain


def _of_image_node(node: bpy.types.ShaderNodeTexImage) -> BaseColour:
    names = (source.uv_map for source in _upstream(node.inputs["Vector"]) if source.type == "UVMAP")
    return BaseColour(image=node.image, uv_map=next(names, ""))


def _upstream(socket: bpy.types.NodeSocket) -> Iterator[bpy.types.Node]:
    """Nodes that feed a socket, nearest first, each once; a mix's factor and a picture's coordinates are left out."""
    waiting = [link.from_node for link in socket.links]
    seen: set[str] = set()
    while waiting:
        node = waiting.pop(0)
        if node.name in seen:
            continue
        seen.add(node.name)
        yield node
        if node.type == "TEX_IMAGE" or node.type in COLOUR_INPUT:
            continue
        followed = [each for each in node.inputs if each.enabled and not each.name.startswith("Fac")]
        waiting.extend(link.from_node for each in followed for link in each.links)
