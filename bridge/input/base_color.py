"""The source of a material's color, found in its nodes."""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from ...core.records import dataclass

Groups = tuple[bpy.types.Node, ...]
COLOR_INPUT = {"BSDF_PRINCIPLED": "Base Color", "BSDF_DIFFUSE": "Color", "EMISSION": "Color"}
HOW_TO_BAKE = "(in Blender: Paint > Bake Material; on the command line: --bake-material)"
BAKE_HINT = f"bake it to print what is seen {HOW_TO_BAKE}"
_HARMLESS = ("REROUTE", "RGBTOBW")  # what prints is gray anyway


@dataclass(frozen=True)
class BaseColor:
    """Where a material's color comes from: at most one of image, attribute and color.

    Attributes:
        image: the picture, or None.
        uv_map: name of the UV map that the picture asks for, "" for the one to render.
        attribute: name of a color attribute, "" for the one to render, or None.
        color: linear RGBA of a plain color, or None.
        ignored: titles of the nodes that change it in the material, but not in the print; with nothing else, of those
            that make it.
    """

    image: bpy.types.Image | None = None
    uv_map: str = ""
    attribute: str | None = None
    color: tuple[float, float, float, float] | None = None
    ignored: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Found:
    """A node that feeds a socket.

    Attributes:
        node: the node.
        outlet: by which it does.
        groups: the group nodes that it is in, the outermost first.
        way: the nodes between the two, from the socket on.
    """

    node: bpy.types.Node
    outlet: bpy.types.NodeSocket
    groups: Groups
    way: tuple[bpy.types.Node, ...] = ()


def base_color(material: bpy.types.Material | None) -> BaseColor:
    """The source of a material's base color.

    Follows the output's surface back through mixes, reroutes and groups to a Principled, Diffuse or Emission shader,
    and from its color input to the nearest image or color attribute. An image beats a plain color farther on.
    """
    if material is None:
        return BaseColor()
    if not has_nodes(material):
        return BaseColor(color=tuple(material.diffuse_color))
    output = material.node_tree.get_output_node("ALL")
    plain = BaseColor()
    for found in _upstream(output.inputs["Surface"], ()):
        if found.node.type == "TEX_IMAGE" and found.node.image:
            return _of_image_node(found)
        if found.node.type in COLOR_INPUT:
            color = _of_socket(found.node.inputs[COLOR_INPUT[found.node.type]], found.groups)
            if color.image or color.attribute is not None:
                return color
            plain = plain if plain.color else color
    return plain


def has_nodes(material: bpy.types.Material) -> bool:
    """Whether it is nodes that say what a material looks like."""
    without = material.node_tree is None or (bpy.app.version < (5, 0) and not material.use_nodes)
    return not without and material.node_tree.get_output_node("ALL") is not None


def chosen_color(colors: list[BaseColor], image: bpy.types.Image, mesh: bpy.types.Mesh) -> BaseColor:
    """Where the color of an object comes from whose picture the user has chosen, instead of its materials' `colors`.

    The picture lies as a material shows it; one that no material shows, by the active UV map, as strokes do.
    """
    active = mesh.uv_layers.active
    unseen = BaseColor(image=image, uv_map=active.name if active else "")
    return next((color for color in colors if color.image == image), unseen)


def ignored_note(color: BaseColor, mesh: bpy.types.Mesh) -> str:
    """A sentence about what a material shows on a mesh otherwise than it prints; empty if there is nothing."""
    if color.attribute and color.attribute not in mesh.color_attributes:
        return f"the attribute {color.attribute} of the material is no color attribute and does not print: {BAKE_HINT}"
    if not color.ignored:
        return ""
    nodes = " and ".join(color.ignored)
    layer = None if color.attribute is None else color_layer(color, mesh)
    if not color.image and layer is None:
        return f"the material's color is made by {nodes}, which does not print: {BAKE_HINT}"
    paint = f"image {color.image.name}" if color.image else f"color attribute {layer.name}"
    return f"the material changes the {paint} by {nodes}, but it prints as it is: {BAKE_HINT}"


def picture_layer(color: BaseColor, mesh: bpy.types.Mesh) -> bpy.types.MeshUVLoopLayer | None:
    """The UV map by which a picture is seen: the one that it asks for, else the one to render; None without any."""
    layers = mesh.uv_layers
    return layers.get(color.uv_map) or next((layer for layer in layers if layer.active_render), layers.active)


def color_layer(color: BaseColor, mesh: bpy.types.Mesh, pictured: bool = False) -> bpy.types.Attribute | None:
    """The color attribute that is printed where a material has no picture: the one that it shows, else the active one.

    Args:
        color: of the material.
        mesh: of the object.
        pictured: whether another material of the object has a picture; plain ones then show their own color.
    """
    attributes = mesh.color_attributes
    shown = None if color.attribute is None else attributes.get(color.attribute or attributes.default_color_name)
    return shown or (None if pictured else attributes.active_color)


def _of_socket(socket: bpy.types.NodeSocket, groups: Groups) -> BaseColor:
    if not socket.is_linked:
        return BaseColor(color=tuple(socket.default_value))
    plain, made_by = BaseColor(), ""
    for found in _upstream(socket, groups):
        node = found.node
        if node.type == "TEX_IMAGE" and node.image:
            return _of_image_node(found)
        if (attribute := _attribute_of(node)) is not None:
            plain = BaseColor(attribute=attribute, ignored=_changers(found))
        elif node.type == "RGB" and plain.attribute is None:
            plain = BaseColor(color=tuple(node.outputs[0].default_value), ignored=_changers(found))
        if node.type != "TEX_IMAGE":
            made_by = made_by or node.bl_label
    if made_by and plain.attribute is None and not plain.color:
        return BaseColor(ignored=(made_by,))
    return plain


def _attribute_of(node: bpy.types.Node) -> str | None:
    """Name of the attribute of the mesh that a node shows, "" for the color attribute to render; None without one."""
    if node.type == "VERTEX_COLOR":
        return str(node.layer_name)
    if node.type == "ATTRIBUTE" and node.attribute_type == "GEOMETRY":
        return node.attribute_name or None
    return None


def _of_image_node(found: _Found) -> BaseColor:
    node = found.node
    sources = list(_upstream(node.inputs["Vector"], found.groups))
    uv_map = next((each.node.uv_map for each in sources if each.node.type == "UVMAP"), "")
    moved = [title for title in map(_mover, sources) if title]
    if node.projection != "FLAT":
        moved.append(f"{node.projection.title()} projection")
    return BaseColor(image=node.image, uv_map=uv_map, ignored=(*_changers(found), *dict.fromkeys(moved)))


def _changers(found: _Found) -> tuple[str, ...]:
    """Titles of the nodes that change a color on its way to the shader."""
    return tuple(dict.fromkeys(node.bl_label for node in found.way if not node.mute and node.type not in _HARMLESS))


def _mover(source: _Found) -> str:
    """Title of a node that feeds a picture's coordinates if it makes others of the UV map, else ""."""
    node = source.node
    if node.mute or node.type in ("UVMAP", "REROUTE"):
        return ""
    if node.type == "TEX_COORD":
        return "" if source.outlet.name == "UV" else f"{source.outlet.name} coordinates"
    if node.type == "MAPPING":
        same = {"Location": (0, 0, 0), "Rotation": (0, 0, 0), "Scale": (1, 1, 1)}
        inputs = [socket for socket in node.inputs if socket.name in same and socket.enabled]
        if all(not socket.is_linked and tuple(socket.default_value) == same[socket.name] for socket in inputs):
            return ""
    return str(node.bl_label)


def _upstream(socket: bpy.types.NodeSocket, groups: Groups) -> Iterator[_Found]:
    """Nodes that feed a socket, nearest first, each once.

    A mix's factor and a picture's coordinates are left out.

    Args:
        socket: an input.
        groups: the group nodes that the socket is in, the outermost first.
    """
    waiting = _feeding(socket, groups, ())
    seen: set[tuple[str, ...]] = set()
    while waiting:
        found = waiting.pop(0)
        node, outlet, groups = found.node, found.outlet, found.groups
        way = outlet.identifier if node.type in ("GROUP", "GROUP_INPUT") else ""
        place = (*(group.name for group in groups), node.name, way)
        if place in seen:
            continue
        seen.add(place)
        if node.type == "GROUP" and node.node_tree:
            ends = [each for each in node.node_tree.nodes if each.type == "GROUP_OUTPUT" and each.is_active_output]
            inner = [_same(end.inputs, outlet) for end in ends]
            waiting[:0] = [each for end in inner for each in _feeding(end, (*groups, node), found.way)]
        elif node.type == "GROUP_INPUT":
            waiting[:0] = _feeding(_same(groups[-1].inputs, outlet), groups[:-1], found.way) if groups else []
        else:
            yield found
            if node.type != "TEX_IMAGE" and node.type not in COLOR_INPUT:
                followed = [each for each in node.inputs if each.enabled and not _is_factor(each)]
                waiting.extend(each for link in followed for each in _feeding(link, groups, (*found.way, node)))


def _is_factor(socket: bpy.types.NodeSocket) -> bool:
    """Whether an input says how much of the others; that of a color ramp is what it makes colors of."""
    return socket.name.startswith("Fac") and socket.node.type != "VALTORGB"


def _feeding(socket: bpy.types.NodeSocket | None, groups: Groups, way: tuple[bpy.types.Node, ...]) -> list[_Found]:
    """The nodes that a socket is linked to, at the end of a way."""
    return [_Found(link.from_node, link.from_socket, groups, way) for link in socket.links] if socket else []


def _same(sockets: bpy.types.NodeInputs, outlet: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
    """The socket on the other side of a group's border."""
    return next((each for each in sockets if each.identifier == outlet.identifier), None)
