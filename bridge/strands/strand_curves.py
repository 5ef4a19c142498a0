"""Strands as Blender `Curves`: rods of the right size and shape, and their attributes, read back as well."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ...core.model import FloatArray, IntArray
from ...core.strands.strands import Strands, split_by_roundness
from ..pictures.plastics import plastic
from .scrubber import STRANDS_KEY

LABELS = ("layer", "feature", "tool")
"""Attributes of each strand."""

_RATIO_STEP = 1.5  # strands whose height-to-width ratios round to the same power of this share an object
_ROUNDNESS_LEVELS = 4
"""From oval to round in three steps, each a change of the diameters by a twelfth."""


def strand_objects(
    laid: Strands,
    black_tool: int,
    unit: float,
    origin: FloatArray,
    attributes_of: Callable[[Strands], dict[str, NDArray[Any]]] = lambda laid: {},
    levels: int = _ROUNDNESS_LEVELS,
) -> list[bpy.types.Object]:
    """Strands as objects that are not linked to any collection yet, one per filament and height-to-width ratio.

    Args:
        laid: settled strands, mm.
        black_tool: the tool with the black filament.
        unit: mm that a scene unit is.
        origin: (3,) mm, where the strands' origin lies in the world.
        attributes_of: gives the attributes of the points of strands, by name.
        levels: of roundness, from oval to round.
    """
    parts, roundness = split_by_roundness(laid, levels)
    return [
        _strand_object(kind, part, ratio, unit, origin, attributes_of(part))
        for kind, members, ratio in _groups(parts, roundness, black_tool)
        for part in [parts.gathered(members)]
    ]


def set_drawing(scene: bpy.types.Scene) -> None:
    """Draw strands as wide as they are, and render them as round rods, with the least work."""
    scene.render.hair_type = "STRIP"  # STRAND draws lines of a pixel, in hardly less time
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
    """(color, numbers of strands, height to width) of every object: one a filament where all lines are alike.

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
        center = resting ** (1.0 - float(roundness[one]))
        color = "White" if is_white[one] else "Black"
        groups.append((color if plain and roundness[one] == 0 else f"{color} {center:.2f}", members, center))
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
