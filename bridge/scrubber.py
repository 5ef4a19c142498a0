"""Which strands of a preview are visible: a range of layers and kinds of features, hidden by Geometry Nodes.

Hiding by an attribute takes about 25 ms with a million points; building the strands anew would take seconds.
"""

from __future__ import annotations

import colorsys
from typing import Any

import bpy

from ..core.toolpaths.moves import Feature

STRANDS_KEY = "dualcolor_strands"
LAST_LAYER_KEY = "dualcolor_last_layer"
KINDS: dict[str, tuple[Feature, ...]] = {
    "walls": (Feature.OUTER_WALL, Feature.INNER_WALL),
    "fill": (Feature.SKIN, Feature.BRIDGE, Feature.INFILL),
    "supports": (Feature.SUPPORT, Feature.SUPPORT_INTERFACE),
    "tower": (Feature.TOWER, Feature.OOZE_SHIELD),
    "adhesion": (Feature.SKIRT, Feature.BRIM, Feature.RAFT),
}
_GROUP = "Visible Strands"
_INPUTS = ("First Layer", "Last Layer", "Hidden Features")
_MOST_LAYERS = 100_000


def apply_view(collection: bpy.types.Collection) -> None:
    """Show of the strands what the collection's view says; outside the extension they are all visible."""
    view = getattr(collection, "dualcolor_view", None)
    if view is None:
        return
    hidden = sum(1 << feature for kind, of in KINDS.items() if not getattr(view, f"show_{kind}") for feature in of)
    values = (view.layer_from, view.layer_to, hidden)
    everything = not hidden and view.layer_from == 0 and view.layer_to >= last_layer(collection)
    for shown in strand_objects(collection):
        modifier = shown.modifiers.get(_GROUP)
        if modifier is None and not everything:
            modifier = shown.modifiers.new(_GROUP, "NODES")
            modifier.node_group = bpy.data.node_groups.get(_GROUP) or _node_group()
        if modifier is not None:
            sockets = {item.name: item.identifier for item in modifier.node_group.interface.items_tree}
            for name, value in zip(_INPUTS, values, strict=True):
                modifier[sockets[name]] = value
            modifier.show_viewport = modifier.show_render = not everything
            shown.update_tag()
        _colour(shown, view.colour_by)


def show_all_layers(collection: bpy.types.Collection, last: int) -> None:
    """Note the number of the last layer and show them all, as after the strands have been built."""
    collection[LAST_LAYER_KEY] = last
    view = getattr(collection, "dualcolor_view", None)
    if view is not None:
        view.layer_from, view.layer_to = 0, last
        apply_view(collection)


def last_layer(collection: bpy.types.Collection) -> int:
    """Number of the topmost layer."""
    return int(collection.get(LAST_LAYER_KEY, 0))


def strand_objects(collection: bpy.types.Collection) -> list[bpy.types.Object]:
    """The objects with strands of a preview."""
    return [held for held in collection.objects if held.get(STRANDS_KEY)]


def _node_group() -> bpy.types.NodeTree:
    """Nodes that delete the curves of other layers, and of features whose bit is set in a mask."""
    group = bpy.data.node_groups.new(_GROUP, "GeometryNodeTree")
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
    delete = nodes.new("GeometryNodeDeleteGeometry")
    delete.domain = "CURVE"
    links.new(given.outputs[0], delete.inputs["Geometry"])
    links.new(math("GREATER_THAN", unwanted, 0.5), delete.inputs["Selection"])
    links.new(delete.outputs[0], result.inputs[0])
    return group


def feature_colour(feature: Feature) -> tuple[float, float, float, float]:
    """Colour of a feature in the legend: hues far apart for features that are neighbours."""
    return (*colorsys.hsv_to_rgb(feature * 0.382 % 1.0, 0.75, 0.85), 1.0)


def _feature_material() -> bpy.types.Material:
    """A material that colours each strand by its attribute `feature`; seen in Material Preview and when rendered."""
    name = "Strand Features"
    if name in bpy.data.materials:
        return bpy.data.materials[name]
    material = bpy.data.materials.new(name)
    if material.node_tree is None:
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    shader = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    label, scale, ramp = (nodes.new(f"ShaderNode{kind}") for kind in ("Attribute", "Math", "ValToRGB"))
    label.attribute_name = "feature"
    scale.operation = "DIVIDE"
    scale.inputs[1].default_value = float(len(Feature))
    ramp.color_ramp.interpolation = "CONSTANT"
    for number, feature in enumerate(Feature):
        stops = ramp.color_ramp.elements
        place = max((feature - 0.5) / len(Feature), 0.0)
        stop = stops[number] if number < 2 else stops.new(place)
        stop.position, stop.color = place, feature_colour(feature)
    links.new(label.outputs["Fac"], scale.inputs[0])
    links.new(scale.outputs[0], ramp.inputs[0])
    links.new(ramp.outputs[0], shader.inputs["Base Color"])
    return material


def _colour(shown: bpy.types.Object, colour_by: str) -> None:
    """The plastic belongs to the strands; another material is laid over it on the object."""
    if not shown.material_slots:
        return
    slot = shown.material_slots[0]
    if colour_by == "FEATURE":
        slot.link = "OBJECT"
        slot.material = _feature_material()
    elif slot.link == "OBJECT":
        slot.material = None
        slot.link = "DATA"


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
            "colour_by": bpy.props.EnumProperty(
                name="Colour",
                items=[
                    ("FILAMENT", "Filament", "As it will be printed"),
                    ("FEATURE", "Feature", "By what lines are for; seen in Material Preview and when rendered"),
                ],
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
