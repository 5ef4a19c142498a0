"""The preview: a collection that shows the strands of a print in the place of its object, as `Curves`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import bpy
import numpy as np

from ...core.model import FloatArray, TriangleMesh
from ...core.strands.point_attributes import moves_of_layers, point_attributes, tone_of_moves
from ...core.strands.settling import settled
from ...core.strands.strands import Strands, strands
from ..input.mesh_input import evaluated_mesh
from ..mesh_data import corner_vertices, in_world, positions
from ..units import mm_per_unit
from .scrubber import LAST_LAYER_KEY, STRANDS_KEY, show_all_layers, strands_in
from .strand_curves import set_drawing, strand_objects

if TYPE_CHECKING:
    from ...core.pipeline import DualColorPrint
    from ...core.toolpaths.recovered import ReadPrint

SOURCE_KEY = "dualcolor_source"
_COMPANIONS_KEY = "dualcolor_companions"
DISPLAY_KEY = "dualcolor_display"
"""What an object that is drawn as its bounds looked like before."""


def strands_of(result: DualColorPrint | ReadPrint) -> Strands:
    """The strands of a print as they lie when they have cooled: the longest part of showing it, without Blender."""
    return settled(strands(result.moves), result.settings.sag)


def build_preview(
    result: DualColorPrint | ReadPrint,
    source: bpy.types.Object | None = None,
    companions: Sequence[bpy.types.Object] = (),
    laid: Strands | None = None,
) -> bpy.types.Collection:
    """Show the print as strands in the current scene, where its source stands, and the source as its bounds only.

    The collection `<object> Dual-Color` is made, or its strands are replaced once the new ones are complete. It holds
    one object a filament (and height-to-width ratio): poly lines with a `radius`, and `layer` and `feature` of each.

    Args:
        result: the print, generated or read from a file.
        source: the mesh object that it was generated from; without it the print stands on the bed, at the
            world's origin.
        companions: the other objects on its plate; they are shown as their bounds too.
        laid: its strands, if they are known.

    Returns:
        The collection, linked to the scene and to all others that the source is in.
    """
    scene = bpy.context.scene
    unit = mm_per_unit(scene)
    name = source.name if source else result.name
    origin = bed_origin(result.mesh, source, unit) if source else np.zeros(3)
    laid = strands_of(result) if laid is None else laid
    outlines = getattr(result, "outlines", None)  # what is read from a file tells nothing of tones
    tone = tone_of_moves(outlines, result.moves, result.settings.raft_layers) if outlines else None
    attributes_of = point_attributes(result.moves, tone)
    new = strand_objects(laid, result.settings.black_tool, unit, origin, attributes_of)
    collection = preview_of(source) if source else _read_before(name)
    collection = collection or bpy.data.collections.new(f"{name} Dual-Color")
    _replace_strands(collection, new, name)
    show_all_layers(collection, moves_of_layers(result.moves))
    for each in {scene, *(source.users_scene if source else ())}:  # in all of them the source is drawn as bounds
        if collection not in each.collection.children_recursive:
            each.collection.children.link(collection)
            set_drawing(each)  # later on it is the user's choice
    if source:
        show_print(source, False)  # what has left the plate is shown as it was
        collection[SOURCE_KEY] = source
        collection[_COMPANIONS_KEY] = {str(number): other for number, other in enumerate(companions)}
        show_print(source, True)
    bpy.context.view_layer.update()  # without it new objects do not know their place in the world
    return collection


def preview_of(source: bpy.types.Object) -> bpy.types.Collection | None:
    """The collection that holds the strands of an object, or the given strands; None if there is none."""
    if source.get(STRANDS_KEY):
        return next((held for held in source.users_collection if LAST_LAYER_KEY in held), None)
    return next((held for held in bpy.data.collections if held.get(SOURCE_KEY) == source), None)


def _read_before(name: str) -> bpy.types.Collection | None:
    """The strands of a file's print of that name; those of an object that it may have been made from are not."""
    held = (held for held in bpy.data.collections if LAST_LAYER_KEY in held and not held.get(SOURCE_KEY))
    return next((each for each in held if each.name.partition(" Dual-Color")[0] == name), None)


def source_of(shown: bpy.types.Object | None) -> bpy.types.Object | None:
    """The mesh object that strands were made from, if that is what is given; otherwise the object itself."""
    if shown is None or not shown.get(STRANDS_KEY):
        return shown
    sources = (collection.get(SOURCE_KEY) for collection in shown.users_collection)
    return next((source for source in sources if source), shown)


def companions_of(source: bpy.types.Object) -> list[bpy.types.Object]:
    """The objects that the last print of an object holds beside it."""
    collection = preview_of(source)
    kept = collection.get(_COMPANIONS_KEY) if collection else None
    return [other for other in kept.values() if other] if kept else []


def show_print(source: bpy.types.Object, shown: bool) -> None:
    """Show the strands, and of the objects on the plate only their bounds; or the objects alone as they were.

    The objects are not hidden, for a hidden one is neither evaluated nor painted on.
    """
    collection = preview_of(source)
    if collection is None:
        return
    shown = shown and bool(strands_in(collection))  # they may have been deleted by hand
    companions = companions_of(source)
    for other in companions if shown else ():
        show_print(other, False)  # its own print, if it has one, stands in the same place
    for printed in (source, *companions):
        show_bounds(printed, shown)
    collection.hide_viewport = collection.hide_render = not shown
    if shown:
        _unhide(collection, bpy.context.view_layer.layer_collection)


def _unhide(collection: bpy.types.Collection, within: bpy.types.LayerCollection) -> bool:
    """Show a collection that was hidden or excluded in the outliner, and those that it is in; whether it is there."""
    found = within.collection == collection or any(_unhide(collection, inner) for inner in within.children)
    for hidden in ("exclude", "hide_viewport"):
        if found and getattr(within, hidden):
            setattr(within, hidden, False)
    return found


def show_bounds(obj: bpy.types.Object, shown: bool) -> None:
    """Draw an object as its bounds and do not render it, or as it was before that."""
    if shown and DISPLAY_KEY not in obj:
        obj[DISPLAY_KEY] = {"type": obj.display_type, "hide_render": obj.hide_render}
        obj.display_type, obj.hide_render = "BOUNDS", True
    elif not shown and DISPLAY_KEY in obj:
        former = obj[DISPLAY_KEY]
        obj.display_type, obj.hide_render = former["type"], bool(former["hide_render"])
        del obj[DISPLAY_KEY]
    elif not shown and obj.override_library and obj.display_type == "BOUNDS":  # with which no new key is saved
        former = obj.override_library.reference
        obj.display_type, obj.hide_render = former.display_type, former.hide_render


def is_print_shown(source: bpy.types.Object) -> bool:
    """Whether the strands of an object are visible."""
    collection = preview_of(source)
    return collection is not None and not collection.hide_viewport and bool(strands_in(collection))


def _replace_strands(collection: bpy.types.Collection, new: list[bpy.types.Object], name: str) -> None:
    """Take the former strands out of the collection and put the new ones in; whatever else it holds stays."""
    for former in strands_in(collection):
        data = former.data
        bpy.data.objects.remove(former)
        if not data.users:
            bpy.data.hair_curves.remove(data)
    collection.name = f"{name} Dual-Color"
    for made in new:
        collection.objects.link(made)
        made.name = made.data.name = f"{name} {made[STRANDS_KEY]}"


def bed_origin(mesh: TriangleMesh, source: bpy.types.Object, unit: float) -> FloatArray:
    """(3,) mm, where the bed's origin lies in the world so that the print stands in its source's place."""
    with evaluated_mesh(source, bpy.context.evaluated_depsgraph_get()) as data:
        local = positions(data)[corner_vertices(data)]
    world = in_world(local, np.array(source.matrix_world))
    return world.min(axis=0) * unit - mesh.bounds_of(0)[0]
