"""Colors of the strands of a preview by their attributes, and the legends of these colors."""

from __future__ import annotations

import colorsys

import bpy

from ...core.paths import Feature
from ...core.records import dataclass
from ..materials import new_material, principled

Color = tuple[float, float, float]


@dataclass(frozen=True)
class Legend:
    """The meaning of colors: one color for each of some whole numbers, or a ramp.

    Attributes:
        title: as the user knows it.
        description: of the choice.
        attribute: of the strands.
        low: value of the first color.
        high: value of the last one.
        entries: text and linear color, from the lowest value to the highest.
        ramp: whether there are values in between.
    """

    title: str
    description: str
    attribute: str
    low: float
    high: float
    entries: tuple[tuple[str, Color], ...]
    ramp: bool = True


def feature_color(feature: Feature) -> Color:
    """Color of a feature in the legend: hues far apart for features that are neighbors."""
    return colorsys.hsv_to_rgb(feature * 0.382 % 1.0, 0.75, 0.85)


def _scale(low: float, high: float, unit: str, colors: tuple[Color, ...]) -> tuple[tuple[str, Color], ...]:
    step = (high - low) / (len(colors) - 1)
    return tuple((f"{low + number * step:g} {unit}".strip(), color) for number, color in enumerate(colors))


_COLD_TO_HOT = ((0.02, 0.06, 0.5), (0.0, 0.4, 0.6), (0.1, 0.6, 0.1), (0.9, 0.6, 0.02), (0.8, 0.03, 0.02))
_GRAYS = ((0.0, 0.0, 0.0), (0.25, 0.25, 0.25), (0.5, 0.5, 0.5), (0.75, 0.75, 0.75), (1.0, 1.0, 1.0))
_NONE: tuple[str, Color] = ("no tone", (0.25, 0.1, 0.35))
_NAMES = tuple((feature.name.replace("_", " ").capitalize(), feature_color(feature)) for feature in Feature)

LEGENDS = {
    "FEATURE": Legend("Feature", "By what lines are for", "feature", 0, len(Feature) - 1, _NAMES, ramp=False),
    "TOOL": Legend("Tool", "By the nozzle", "tool", 0, 1, (("Tool 0, right", (0.05, 0.2, 0.8)),
                   ("Tool 1, left", (0.9, 0.4, 0.05))), ramp=False),
    "SPEED": Legend("Speed", "By the speed of the nozzle", "speed", 0, 100, _scale(0, 100, "mm/s", _COLD_TO_HOT)),
    "UNSUPPORTED": Legend("Unsupported", "By the distance from what carries the line", "unsupported", 0, 2,
                          _scale(0, 2, "mm", _COLD_TO_HOT)),
    "TONE": Legend("Tone", "By the tone that the outer wall should show", "tone", -0.25, 1,
                   (_NONE, *_scale(0, 1, "", _GRAYS))),
}  # fmt: skip


def legend_of(color_by: str) -> list[tuple[str, Color]]:
    """Text and color of each line of a legend, without features that are never extruded."""
    if color_by not in LEGENDS:
        return []
    entries = list(LEGENDS[color_by].entries)
    return entries[Feature.OUTER_WALL :] if color_by == "FEATURE" else entries


def paint(shown: bpy.types.Object, color_by: str) -> None:
    """The plastic belongs to the strands; another material is laid over it on the object."""
    if not shown.material_slots:
        return
    slot = shown.material_slots[0]
    if color_by in LEGENDS:
        slot.link = "OBJECT"
        slot.material = _material(LEGENDS[color_by])
    elif slot.link == "OBJECT":
        slot.material = None
        slot.link = "DATA"


def _material(legend: Legend) -> bpy.types.Material:
    """A material that colors each strand by an attribute."""
    name = f"Strands by {legend.title}"
    if name in bpy.data.materials:
        return bpy.data.materials[name]
    material = new_material(name)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    label, scale, ramp = (nodes.new(f"ShaderNode{kind}") for kind in ("Attribute", "MapRange", "ValToRGB"))
    label.attribute_name = legend.attribute
    # Of single values each has a band of its own around it.
    half = 0.0 if legend.ramp else 0.5
    scale.inputs["From Min"].default_value = legend.low - half
    scale.inputs["From Max"].default_value = legend.high + half
    ramp.color_ramp.interpolation = "LINEAR" if legend.ramp else "CONSTANT"
    count = len(legend.entries)
    for number, (_, color) in enumerate(legend.entries):
        stops = ramp.color_ramp.elements
        place = number / (count - 1 if legend.ramp else count)
        stop = stops[number] if number < 2 else stops.new(place)
        stop.position, stop.color = place, (*color, 1.0)
    links.new(label.outputs["Fac"], scale.inputs["Value"])
    links.new(scale.outputs["Result"], ramp.inputs[0])
    links.new(ramp.outputs[0], principled(material).inputs["Base Color"])
    return material
