"""Where operators can be used, with the reason where they cannot."""

from __future__ import annotations

import bpy

from ..bridge.input.mesh_input import MAKE_REAL, WITH_SURFACE
from ..bridge.input.metaballs import metaball_of
from ..bridge.strands.preview import source_of

MAKE_LOCAL = "Make the object and its data local first (Object > Relations)"


def has_printable(cls: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """Whether an object that can be printed, or the strands of one, is active; sets the poll message."""
    obj = source_of(context.object)
    if obj is None or obj.type not in WITH_SURFACE:
        instanced = obj is not None and obj.instance_type == "COLLECTION"
        how = MAKE_REAL if instanced else "Select a mesh object"
        cls.poll_message_set(f"{how} first")
        return False
    whole = metaball_of(obj, context.scene)
    if whole != obj:
        cls.poll_message_set(f"Select {whole.name} first: it has the surface of this metaball")
        return False
    return True


def has_own_settings(cls: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """Whether the settings of what is active can be changed: they are not another file's; sets the poll message."""
    if not has_printable(cls, context):
        return False
    if source_of(context.object).library:
        cls.poll_message_set(MAKE_LOCAL)
        return False
    return True


def has_mesh(cls: type[bpy.types.Operator], context: bpy.types.Context, leaves_mode: bool = False) -> bool:
    """Whether a mesh with faces is active and not in Edit Mode; sets the poll message.

    Nor in Sculpt Mode, whose strokes are not in the mesh yet, unless the operator leaves that first by itself.
    """
    obj = context.object
    if obj is None or obj.type != "MESH" or not len(obj.data.polygons):
        source = source_of(obj)
        named = "a mesh object with faces" if source == obj else f"{source.name}, whose strands these are,"
        cls.poll_message_set(f"Select {named} first")
        return False
    if obj.mode == "EDIT" or (obj.mode == "SCULPT" and not leaves_mode):
        cls.poll_message_set(f"Leave {obj.mode.title()} Mode first")
        return False
    return True


def has_own_mesh(cls: type[bpy.types.Operator], context: bpy.types.Context, leaves_mode: bool = False) -> bool:
    """Whether the active mesh can be changed: as `has_mesh`, visible, and of this file; sets the poll message."""
    if not has_mesh(cls, context, leaves_mode):
        return False
    if is_of_library(context.object):
        cls.poll_message_set(MAKE_LOCAL)
        return False
    if not context.object.visible_get():
        cls.poll_message_set("Unhide the object first")
        return False
    return True


def is_of_library(obj: bpy.types.Object) -> bool:
    """Whether the object or its mesh comes from another file, so that changes would be refused or not be saved."""
    return any(held is not None and not held.is_editable for held in (obj, obj.data))


def in_object_mode(cls: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """Whether objects can be added; sets the poll message."""
    if context.mode != "OBJECT":
        cls.poll_message_set("Switch to Object Mode first")
        return False
    return True
