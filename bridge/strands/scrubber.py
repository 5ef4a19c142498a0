"""Which strands of a preview are visible: layers, moves and kinds of features, the others hidden by Geometry Nodes.

Hiding by an attribute takes about 25 ms with a million points; building the strands anew would take seconds.
"""

from __future__ import annotations

from typing import Any

import bpy

from ...core.model import IntArray
from ...core.paths import Feature
from ..node_inputs import set_input
from .strand_colors import LEGENDS, paint

STRANDS_KEY = "dualcolor_strands"
LAST_LAYER_KEY = "dualcolor_last_layer"
KINDS: dict[str, tuple[Feature, ...]] = {
    "walls": (Feature.OUTER_WALL, Feature.INNER_WALL),
    "fill": (Feature.SKIN, Feature.BRIDGE, Feature.INFILL),
    "supports": (Feature.SUPPORT, Feature.SUPPORT_INTERFACE),
    "tower": (Feature.TOWER, Feature.OOZE_SHIELD),
    "adhesion": (Feature.SKIRT, Feature.BRIM, Feature.RAFT),
}
_MOVES_KEY = "dualcolor_moves"
_GROUP = "Shown Strands"
_GROUP_KEY = "dualcolor_shown"
_INPUTS = ("First Layer", "Last Layer", "Hidden Features", "Last Move")
_MOST_LAYERS = 100_000


def apply_view(collection: bpy.types.Collection) -> None:
    """Show of the strands what the collection's view says; outside the extension they are all visible."""
    view = getattr(collection, "dualcolor_view", None)
    if view is None:
        return
    hidden = sum(1 << feature for kind, of in KINDS.items() if not getattr(view, f"show_{kind}") for feature in of)
    shown_moves, moves = moves_shown(collection)
    values = (view.layer_from, view.layer_to, hidden, shown_moves - 1)
    all_layers = view.layer_from == 0 and view.layer_to >= last_layer(collection)
    everything = not hidden and all_layers and shown_moves == moves
    for shown in strands_in(collection):
        modifier = shown.modifiers.get(_GROUP)
        if modifier is None and not everything:
            modifier = shown.modifiers.new(_GROUP, "NODES")
        if modifier is not None:
            modifier.node_group = modifier.node_group or _node_group()  # which may have been deleted
            sockets = {item.name: item.identifier for item in modifier.node_group.interface.items_tree}
            for name, value in zip(_INPUTS, values, strict=True):
                set_input(modifier, sockets[name], value)
            modifier.show_viewport = modifier.show_render = not everything
            shown.update_tag()
        paint(shown, view.color_by)


def show_all_layers(collection: bpy.types.Collection, moves: IntArray) -> None:
    """Note how many moves each layer has and show them all, as after the strands have been built."""
    last = max(len(moves) - 1, 0)
    collection[LAST_LAYER_KEY] = last
    collection[_MOVES_KEY] = moves.tolist() or [0]
    view = getattr(collection, "dualcolor_view", None)
    if view is not None:
        view.layer_from, view.layer_to, view.moves = 0, last, 100.0
        apply_view(collection)


def moves_shown(collection: bpy.types.Collection) -> tuple[int, int]:
    """How many moves of the last visible layer are shown, and how many it has."""
    view = collection.dualcolor_view
    moves = collection.get(_MOVES_KEY, [0])
    count = int(moves[min(view.layer_to, len(moves) - 1)])
    return round(count * view.moves / 100), count


def last_layer(collection: bpy.types.Collection) -> int:
    """Number of the topmost layer."""
    return int(collection.get(LAST_LAYER_KEY, 0))


def strands_in(collection: bpy.types.Collection) -> list[bpy.types.Object]:
    """The objects with strands of a preview."""
    return [held for held in collection.objects if held.get(STRANDS_KEY)]


def _node_group() -> bpy.types.NodeTree:
    """Nodes that delete the curves of other layers, and of features whose bit is set in a mask."""
    made = next((held for held in bpy.data.node_groups if _GROUP_KEY in held), None)
    return made or _new_node_group()


def _new_node_group() -> bpy.types.NodeTree:
    group = bpy.data.node_groups.new(_GROUP, "GeometryNodeTree")
    group[_GROUP_KEY] = True  # the user may have one of that name
    group.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    for name in _INPUTS:
        group.interface.new_socket(name, in_out="INPUT", socket_type="NodeSocketInt")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    nodes, links = group.nodes, group.links
    given, result = nodes.new("NodeGroupInput"), nodes.new("NodeGroupOutput")

    def attribute(name: str) -> Any:
        node = nodes.new("GeometryNodeInputNamedAttribute")
        node.data_type = "INT"
        node.inputs[0].default_value = name
        return node.outputs[0]

    def math(operation: str, *values: Any) -> Any:
        node = nodes.new("ShaderNodeMath")
        node.operation = operation
        for socket, value in zip(node.inputs, values, strict=False):
            if isinstance(value, float):
                socket.default_value = value
            else:
                links.new(value, socket)
        return node.outputs[0]

    layer, feature = attribute("layer"), attribute("feature")
    outside = math("ADD", math("LESS_THAN", layer, given.outputs[1]), math("GREATER_THAN", layer, given.outputs[2]))
    shifted = math("FLOOR", math("DIVIDE", given.outputs[3], math("POWER", 2.0, feature)))
    unwanted = math("ADD", outside, math("MODULO", shifted, 2.0))
    is_last = math("COMPARE", layer, given.outputs[2], 0.5)
    later = math("MULTIPLY", is_last, math("GREATER_THAN", attribute("move"), given.outputs[4]))
    left = given.outputs[0]
    for domain, selection in (("CURVE", unwanted), ("POINT", later)):
        delete = nodes.new("GeometryNodeDeleteGeometry")
        delete.domain = domain
        links.new(left, delete.inputs["Geometry"])
        links.new(math("GREATER_THAN", selection, 0.5), delete.inputs["Selection"])
        left = delete.outputs[0]
    links.new(left, result.inputs[0])
    return group


def _changed(view: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    apply_view(view.id_data)


def _layer(name: str, description: str, default: int) -> Any:
    return bpy.props.IntProperty(
        name=name, description=description, default=default, min=0, max=_MOST_LAYERS, update=_changed
    )


StrandView = type(
    "DualColorStrandView",
    (bpy.types.PropertyGroup,),
    {
        "__doc__": "What is visible of a preview, stored with its collection.",
        "__module__": __name__,
        "__annotations__": {
            "layer_from": _layer("From Layer", "First visible layer", 0),
            "layer_to": _layer("To Layer", "Last visible layer", _MOST_LAYERS),
            "color_by": bpy.props.EnumProperty(
                name="Color",
                description="What the colors of the strands show; visible in Material Preview and in renders",
                items=[("FILAMENT", "Filament", "As it will be printed")]
                + [(key, legend.title, legend.description) for key, legend in LEGENDS.items()],
                update=_changed,
            ),
            "moves": bpy.props.FloatProperty(
                name="Moves",
                description="Share of the last visible layer that has been printed",
                default=100.0,
                min=0.0,
                max=100.0,
                subtype="PERCENTAGE",
                update=_changed,
            ),
        }
        | {
            f"show_{kind}": bpy.props.BoolProperty(
                name=kind.title(), description=f"Show {kind}", default=True, update=_changed
            )
            for kind in KINDS
        },
    },
)


def register() -> None:
    """Give every collection a view."""
    bpy.utils.register_class(StrandView)
    bpy.types.Collection.dualcolor_view = bpy.props.PointerProperty(type=StrandView)


def unregister() -> None:
    """Take them away."""
    del bpy.types.Collection.dualcolor_view
    bpy.utils.unregister_class(StrandView)
