"""The inputs of Geometry Nodes modifiers, which Blender keeps in different places since 5.2."""

from __future__ import annotations

from typing import Any

import bpy


def set_input(modifier: bpy.types.NodesModifier, identifier: str, value: Any) -> None:
    """Give one of the inputs a value."""
    if bpy.app.version >= (5, 2, 0):
        getattr(modifier.properties.inputs, identifier).value = value
    else:
        modifier[identifier] = value


def input_objects(modifier: bpy.types.NodesModifier) -> list[bpy.types.Object]:
    """The objects that the inputs name."""
    group = modifier.node_group
    sockets = [item for item in group.interface.items_tree if item.item_type == "SOCKET"] if group else []
    chosen = [item for item in sockets if item.in_out == "INPUT" and item.socket_type == "NodeSocketObject"]
    return [held for item in chosen if (held := _value(modifier, item.identifier))]


def _value(modifier: bpy.types.NodesModifier, identifier: str) -> Any:
    if bpy.app.version >= (5, 2, 0):
        return getattr(modifier.properties.inputs, identifier).value
    return modifier.get(identifier)
