"""The preview: a collection of `Curves` objects made from the strands of the toolpath."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.model import FloatArray, IntArray, TriangleMesh
from ..core.strands.beads import Strands, settled, split_by_roundness, strands
from ..core.strands.marks import marks, moves_of_layers, tone_of_moves
from .mesh_input import evaluated_mesh
from .plastics import plastic
from .scrubber import LAST_LAYER_KEY, STRANDS_KEY, show_all_layers, strands_in
from .units import mm_per_unit

if TYPE_CHECKING:
    from ..core.gcode.reader import ReadPrint
    from ..core.pipeline import DualColorPrint

SOURCE_KEY = "dualcolor_source"
_COMPANIONS_KEY = "dualcolor_companions"
LABELS = ("layer", "feature", "tool")
"""Attributes of each strand."""

DISPLAY_KEY = "dualcolor_display"
"""What an object that is drawn as its bounds looked like before."""

_RATIO_STEP = 1.5
_ROUNDNESS_LEVELS = 4
"""From oval to round in three steps, each a change of the diameters by a twelfth."""


def build_preview(
    result: DualColorPrint | ReadPrint,
    source: bpy.types.Object | None = None,
    companions: Sequence[bpy.types.Object] = (),
) -> bpy.types.Collection:
    """Show the print as strands in the current scene, where its source stands, and the source as its bounds only.

    The collection `<object> Dual-Color` is made, or its strands are replaced once the new ones are complete. It holds
    one object a filament (and height-to-width ratio): poly lines with a `radius`, and `layer` and `feature` of each.

    Args:
        result: the print, generated or read from a file.
        source: the mesh object that it was generated from; without it the print stands on the bed, at the
            world's origin.
        companions: the other objects on its plate; they are shown as their bounds too.

    Returns:
        The collection, linked to the scene.
    """
    scene = bpy.context.scene
    unit = mm_per_unit(scene)
    name = source.name if source else result.name
    origin = bed_origin(result.mesh, source, unit) if source else np.zeros(3)
    laid = settled(strands(result.moves), result.settings.sag)
    outlines = getattr(result, "outlines", None)  # what is read from a file tells nothing of tones
    tone = tone_of_moves(outlines, result.moves, result.settings.raft_layers) if outlines else None
    new = strand_objects(laid, result.settings.black_tool, unit, origin, partial(marks, moves=result.moves, tone=tone))
    collection = preview_of(source) if source else bpy.data.collections.get(f"{name} Dual-Color")
    collection = collection or bpy.data.collections.new(f"{name} Dual-Color")
    _replace_strands(collection, new, name)
    show_all_layers(collection, moves_of_layers(result.moves))
    if collection not in scene.collection.children_recursive:
        scene.collection.children.link(collection)
    set_drawing(scene)
    if source:
        show_print(source, False)  # what has left the plate is shown as it was
        collection[SOURCE_KEY] = source
        collection[_COMPANIONS_KEY] = {str(number): other for number, other in enumerate(companions)}
        show_print(source, True)
    bpy.context.view_layer.update()  # without it new objects do not know their place in the world
    return collection


def strand_objects(
    laid: Strands,
    black_tool: int,
    unit: float,
    origin: FloatArray,
    marks_of: Callable[[Strands], dict[str, NDArray[Any]]] = lambda laid: {},
    levels: int = _ROUNDNESS_LEVELS,
) -> list[bpy.types.Object]:
    """Strands as objects that are not linked to any collection yet, one a filament and height-to-width ratio.

    Args:
        laid: settled strands, mm.
        black_tool: the tool with the black filament.
        unit: mm that a scene unit is.
        origin: (3,) mm, where the strands' origin lies in the world.
        marks_of: gives columns of values for the points of strands.
        levels: of roundness, from oval to round.
    """
    parts, roundness = split_by_roundness(laid, levels)
    return [
        _strand_object(kind, part, ratio, unit, origin, marks_of(part))
        for kind, members, ratio in _groups(parts, roundness, black_tool)
        for part in [parts.gathered(members)]
    ]


def preview_of(source: bpy.types.Object) -> bpy.types.Collection | None:
    """The collection that holds the strands of an object, or the given strands; None if there is none."""
    if source.get(STRANDS_KEY):
        return next((held for held in source.users_collection if LAST_LAYER_KEY in held), None)
    return next((held for held in bpy.data.collections if held.get(SOURCE_KEY) == source), None)


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


def is_print_shown(source: bpy.types.Object) -> bool:
    """Whether the strands of an object are visible."""
    collection = preview_of(source)
    return collection is not None and not collection.hide_viewport and bool(strands_in(collection))


def set_drawing(scene: bpy.types.Scene) -> None:
    """Draw and render strands as round rods with the least work."""
    scene.render.hair_type = "STRAND"
    if hasattr(scene, "cycles_curves"):
        scene.cycles_curves.shape = "THICK_LINEAR" if draws_straight(scene) else "THICK"


def draws_straight(scene: bpy.types.Scene) -> bool:
    """Whether Cycles has straight rods with round ends; before Blender 5 it bends them, and their ends are open."""
    shapes = getattr(scene, "cycles_curves", None)
    return shapes is None or "THICK_LINEAR" in shapes.bl_rna.properties["shape"].enum_items


def new_curves(
    name: str,
    points: FloatArray,
    counts: IntArray,
    radius: FloatArray,
    labels: dict[str, IntArray],
    marked: dict[str, NDArray[Any]] | None = None,
) -> bpy.types.Curves:
    """Poly lines as a `Curves` datablock.

    Args:
        name: of the datablock.
        points: (N, 3) in local scene units.
        counts: (K,) points of each line.
        radius: (N,) in local scene units.
        labels: (K,) whole numbers of each line, by the name of the attribute that is to hold them.
        marked: (N,) numbers of each point, by the name of the attribute.
    """
    data = bpy.data.hair_curves.new(name)
    data.add_curves(counts.tolist())
    # Never through the curve_type attribute: writing that with foreach_set corrupts the heap.
    data.set_types(type="POLY")
    data.attributes["position"].data.foreach_set("vector", points.astype(np.float32).ravel())
    attribute = data.attributes.get("radius") or data.attributes.new("radius", "FLOAT", "POINT")
    attribute.data.foreach_set("value", radius.astype(np.float32))
    for label, values in labels.items():
        data.attributes.new(label, "INT", "CURVE").data.foreach_set("value", values.astype(np.int32))
    for mark, values in (marked or {}).items():
        whole = np.issubdtype(values.dtype, np.integer)
        held = data.attributes.new(mark, "INT" if whole else "FLOAT", "POINT")
        held.data.foreach_set("value", values.astype(np.int32 if whole else np.float32))
    data.update_tag()
    return data


def _groups(laid: Strands, roundness: FloatArray, black_tool: int) -> list[tuple[str, IntArray, float]]:
    """(colour, numbers of strands, height to width) of every object: one a filament where all lines are alike.

    An object's scale warps all its rods to ovals of one height-to-width ratio. So rounder lines, much thinner ones, or
    a first layer of another height, make objects of their own; smaller differences keep the area and give up the ratio.

    Args:
        laid: K strands of even roundness.
        roundness: (K,) of each.
        black_tool: the tool with the black filament.
    """
    if not len(laid):
        return []
    counts = np.diff(laid.start)
    ratio = laid.height / (np.add.reduceat(laid.width, laid.start[:-1]) / counts)
    by_ratio = np.argsort(ratio)
    points = np.cumsum(counts[by_ratio])
    usual = float(ratio[by_ratio[np.searchsorted(points, points[-1] / 2)]])
    # Round is round, whatever the width.
    step = np.where(roundness < 1, np.round(np.log(ratio / usual) / np.log(_RATIO_STEP)), 0).astype(np.int64)
    is_white = laid.tool != black_tool
    kind = (is_white * 1000 + np.rint(roundness * 100).astype(np.int64)) * 1000 + np.abs(step) * 2
    kind += step < 0
    order = np.argsort(kind, kind="stable")
    groups = []
    for members in np.split(order, np.flatnonzero(np.diff(kind[order])) + 1):
        one = members[0]
        plain = step[one] == 0
        resting = usual if plain else float(np.median(ratio[members]))
        centre = resting ** (1.0 - float(roundness[one]))
        colour = "White" if is_white[one] else "Black"
        groups.append((colour if plain and roundness[one] == 0 else f"{colour} {centre:.2f}", members, centre))
    return groups


def _strand_object(
    kind: str, laid: Strands, ratio: float, unit: float, origin: FloatArray, marked: dict[str, NDArray[Any]]
) -> bpy.types.Object:
    """Strands as an object that is not linked to any collection yet; its scale in z makes the rods oval.

    With z scaled by the ratio a rod of radius r becomes an oval of area π·r²·ratio, which must be width × height.
    """
    counts = np.diff(laid.start)
    radius = np.sqrt(laid.width * np.repeat(laid.height, counts) / (np.pi * ratio)) / unit
    points = laid.points / (unit, unit, unit * ratio)
    data = new_curves(kind, points, counts, radius, {label: getattr(laid, label) for label in LABELS}, marked)
    data.materials.append(plastic(kind.split()[0]))
    made = bpy.data.objects.new(kind, data)
    made.location = origin / unit
    made.scale = (1.0, 1.0, ratio)
    made[STRANDS_KEY] = kind
    return made


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
        local = np.empty(len(data.vertices) * 3, dtype=np.float32)
        data.attributes["position"].data.foreach_get("vector", local)
        corners = np.empty(len(data.loops), dtype=np.int32)
        data.loops.foreach_get("vertex_index", corners)
    matrix = np.array(source.matrix_world)
    world = local.reshape(-1, 3)[np.unique(corners)] @ matrix[:3, :3].T + matrix[:3, 3]
    return world.min(axis=0) * unit - mesh.bounds_of(0)[0]


def read_strands(shown: bpy.types.Object) -> tuple[FloatArray, IntArray, FloatArray, dict[str, IntArray]]:
    """What `new_curves` takes, read back from a strand object."""
    data = shown.data
    points = np.empty(len(data.points) * 3, dtype=np.float32)
    data.attributes["position"].data.foreach_get("vector", points)
    radius = np.empty(len(data.points), dtype=np.float32)
    data.attributes["radius"].data.foreach_get("value", radius)
    start = np.empty(len(data.curves) + 1, dtype=np.int32)
    data.curve_offset_data.foreach_get("value", start)
    labels = {}
    for label in LABELS:
        values = np.empty(len(data.curves), dtype=np.int32)
        data.attributes[label].data.foreach_get("value", values)
        labels[label] = values.astype(np.int64)
    return points.reshape(-1, 3).astype(np.float64), np.diff(start).astype(np.int64), radius.astype(np.float64), labels
