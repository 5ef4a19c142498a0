"""The nodes of the soft proof: a material that shows a texture as it will print, while it is painted.

Everything is computed where the surface is drawn, so a stroke shows at once. The picture is sampled at evenly spaced
places in a window on the surface, along the layers and across them. The gradients of its UVs on the surface come from
two Bump nodes, whose height is U and V: their normals tilt by exactly the gradient of the height. So nothing has to be
stored with the mesh, and the proof follows unwrapping, scaling and turning of the object at once.
"""

from __future__ import annotations

import math

import bpy

from ...core.analysis.soft_proof import TAPS
from ...core.printability.slopes import DEGRADED_DEG, GONE_DEG
from ...core.records import dataclass
from ...core.texture.decode import LUMINANCE
from ..input.base_color import BaseColor
from ..materials import principled
from ..pictures.plastics import diffuse_material

ACROSS, UP, GRADIENT, STRIPES, BACKGROUND = "Across", "Up", "Gradient", "Stripes", "Background"
"""Nodes with a number: width and height of the window, steepness of the bumps and width of the stripes in units of the
scene, and the tone where nothing is painted."""

RESPONSE, SHOWN = "Response", "Shown"
"""The nodes that look up the table and that give the color."""

_WARNING_COLOR = (0.8, 0.2, 0.01)
_DEGRADED_TINT, _GONE_TINT = 0.35, 0.5

Socket = bpy.types.NodeSocket


@dataclass(frozen=True)
class Paint:
    """Where the tone of a proof comes from, and whether its picture is repeated."""

    source: BaseColor
    repeats: bool


def proof_material(name: str, paint: Paint, response: bpy.types.Image) -> bpy.types.Material:
    """A matt material that shows what is painted as it will print.

    Args:
        name: of the material.
        paint: what is painted.
        response: reflectance by tone (to the right) and slope (upwards: from upright to flat), even steps.
    """
    material = diffuse_material(name, 0.5, 1.0, 1.0)
    graph = _Graph(material.node_tree)
    normal = graph.node("NewGeometry").outputs["True Normal"]
    tone = _tone(graph, paint, normal)
    rise = graph.part(normal, 2)
    shown = _marked(graph, _looked_up(graph, tone, rise, response), rise)
    graph.link(shown, principled(material).inputs["Base Color"])
    return material


def set_number(material: bpy.types.Material, name: str, value: float) -> None:
    """Give one of the nodes with a number its value, if the material has it."""
    node = material.node_tree.nodes.get(name)
    if node:
        node.outputs[0].default_value = value


class _Graph:
    """A node tree that grows to the right as formulas are written down; numbers stand for themselves."""

    def __init__(self, tree: bpy.types.NodeTree) -> None:
        self._tree, self._count = tree, 0

    def node(self, kind: str, **attributes: object) -> bpy.types.Node:
        made = self._tree.nodes.new(f"ShaderNode{kind}")
        made.location = (-4000 + 170 * (self._count // 6), -200 * (self._count % 6) - 300)
        self._count += 1
        for name, value in attributes.items():
            setattr(made, name, value)
        return made

    def link(self, source: Socket | float | tuple[float, ...], target: Socket) -> None:
        if isinstance(source, bpy.types.NodeSocket):
            self._tree.links.new(source, target)
        else:
            target.default_value = source

    def number(self, name: str) -> Socket:
        found = self._tree.nodes.get(name) or self.node("Value", name=name, label=name)
        return found.outputs[0]

    def math(self, operation: str, *values: Socket | float, clamp: bool = False) -> Socket:
        made = self.node("Math", operation=operation, use_clamp=clamp)
        for value, socket in zip(values, made.inputs, strict=False):
            self.link(value, socket)
        return made.outputs[0]

    def vector(self, operation: str, *values: Socket | tuple[float, ...] | float) -> Socket:
        made = self.node("VectorMath", operation=operation)
        sockets = [socket for socket in made.inputs if socket.name != "Scale"]
        targets = [sockets[0], made.inputs["Scale"]] if operation == "SCALE" else sockets
        for value, socket in zip(values, targets, strict=False):
            self.link(value, socket)
        return made.outputs["Value" if operation in ("DOT_PRODUCT", "LENGTH") else "Vector"]

    def part(self, vector: Socket, number: int) -> Socket:
        made = self.node("SeparateXYZ")
        self.link(vector, made.inputs[0])
        return made.outputs[number]

    def combined(self, *values: Socket | float) -> Socket:
        made = self.node("CombineXYZ")
        for value, socket in zip(values, made.inputs, strict=False):
            self.link(value, socket)
        return made.outputs[0]


def _tone(graph: _Graph, paint: Paint, normal: Socket) -> Socket:
    """The tone asked for, as finely as it can print."""
    source = paint.source
    if source.image:
        return _picture_tone(graph, paint, normal)
    if source.attribute:
        color = graph.node("VertexColor", layer_name=source.attribute)
        return _painted(graph, color.outputs["Color"], color.outputs["Alpha"])
    if source.color:
        return _painted(graph, graph.combined(*source.color[:3]), source.color[3])
    return graph.number(BACKGROUND)


def _painted(graph: _Graph, color: Socket, alpha: Socket | float) -> Socket:
    """Luminance, blended over the background."""
    tone = graph.vector("DOT_PRODUCT", color, LUMINANCE)
    if alpha == 1.0:
        return graph.math("MAXIMUM", tone, 0.0, clamp=True)
    background = graph.number(BACKGROUND)
    over = graph.math("SUBTRACT", tone, background)
    return graph.math("MULTIPLY_ADD", over, alpha, background, clamp=True)


def _picture_tone(graph: _Graph, paint: Paint, normal: Socket) -> Socket:
    """Mean tone of the picture at places spread evenly over the window."""
    place = graph.node("UVMap", uv_map=paint.source.uv_map).outputs[0]
    along, above = _window(graph, place, normal)
    steps = [(number + 0.5) / TAPS - 0.5 for number in range(TAPS)]
    total: Socket | float = 0.0
    for across in steps:
        column = graph.vector("MULTIPLY_ADD", along, (across,) * 3, place)
        for up in steps:
            at = graph.vector("MULTIPLY_ADD", above, (up,) * 3, column)
            total = graph.math("ADD", _texel(graph, paint, at), total)
    return graph.math("DIVIDE", total, float(TAPS**2))


def _texel(graph: _Graph, paint: Paint, place: Socket) -> Socket:
    image = paint.source.image
    extension = "REPEAT" if paint.repeats else "EXTEND"
    node = graph.node("TexImage", image=image, interpolation="Linear", extension=extension)
    graph.link(place, node.inputs[0])
    node.id_data.nodes.active = node  # strokes go to the picture, not to the table
    covers = image.alpha_mode in ("STRAIGHT", "PREMUL")
    return _painted(graph, node.outputs["Color"], node.outputs["Alpha"] if covers else 1.0)


def _window(graph: _Graph, place: Socket, normal: Socket) -> tuple[Socket, Socket]:
    """How far the UVs go from side to side of the window: along the layers, and up the wall across them."""
    level = graph.vector("CROSS_PRODUCT", (0.0, 0.0, 1.0), normal)
    upright = graph.vector("LENGTH", level)  # 1 for a wall, 0 for a floor: so much nearer are its layers
    along = graph.vector("NORMALIZE", level)
    above = graph.vector("CROSS_PRODUCT", normal, along)
    height = graph.math("DIVIDE", graph.number(UP), graph.math("MAXIMUM", upright, math.sin(math.radians(GONE_DEG))))
    tilts = [_tilt(graph, graph.part(place, number), normal) for number in (0, 1)]
    width = graph.number(ACROSS)
    return _run(graph, tilts, along, width), _run(graph, tilts, above, height)


def _tilt(graph: _Graph, height: Socket, normal: Socket) -> Socket:
    """The normal less the gradient of a height on the surface times `GRADIENT`."""
    bump = graph.node("Bump")
    bump.inputs["Strength"].default_value = 1.0
    graph.link(graph.number(GRADIENT), bump.inputs["Distance"])
    graph.link(height, bump.inputs["Height"])
    graph.link(normal, bump.inputs["Normal"])
    tilted = bump.outputs["Normal"]  # of length 1
    longer = graph.math("DIVIDE", 1.0, graph.vector("DOT_PRODUCT", tilted, normal))
    return graph.vector("SCALE", tilted, longer)


def _run(graph: _Graph, tilts: list[Socket], direction: Socket, length: Socket) -> Socket:
    """How far U and V go over a length on the surface in a direction."""
    scale = graph.math("DIVIDE", length, graph.number(GRADIENT))
    less = [graph.vector("DOT_PRODUCT", tilt, direction) for tilt in tilts]
    return graph.combined(*(graph.math("MULTIPLY", graph.math("MULTIPLY", each, -1.0), scale) for each in less))


def _looked_up(graph: _Graph, tone: Socket, rise: Socket, response: bpy.types.Image) -> Socket:
    """The reflectance, from the table."""
    slope = graph.math("DIVIDE", graph.math("ARCSINE", graph.math("MAXIMUM", rise, 0.0, clamp=True)), math.pi / 2)
    columns, rows = response.size
    across, up = (
        graph.math("MULTIPLY_ADD", share, (count - 1) / count, 0.5 / count)
        for share, count in ((tone, columns), (slope, rows))
    )
    node = graph.node(
        "TexImage", name=RESPONSE, label=RESPONSE, image=response, interpolation="Linear", extension="EXTEND"
    )
    graph.link(graph.combined(across, up, 0.0), node.inputs[0])
    return node.outputs["Color"]


def _marked(graph: _Graph, reflectance: Socket, rise: Socket) -> Socket:
    """Striped where the surface is too flat to show the tone well, tinted all over where it shows none."""
    flat = graph.math("ABSOLUTE", rise)
    degraded, gone = (
        graph.math("GREATER_THAN", flat, math.cos(math.radians(angle - 1e-3))) for angle in (DEGRADED_DEG, GONE_DEG)
    )
    place = graph.node("NewGeometry").outputs["Position"]
    diagonal = graph.math("DIVIDE", graph.vector("DOT_PRODUCT", place, (0.7, 0.7, 0.7)), graph.number(STRIPES))
    stripe = graph.math("LESS_THAN", graph.math("FRACT", diagonal), 0.5)
    striped = graph.math("MULTIPLY", graph.math("MULTIPLY", degraded, stripe), _DEGRADED_TINT)
    tint = graph.math("MULTIPLY_ADD", gone, _GONE_TINT, striped)
    away = graph.vector("SUBTRACT", _WARNING_COLOR, reflectance)
    shown = graph.vector("MULTIPLY_ADD", away, graph.combined(tint, tint, tint), reflectance)
    shown.node.name = shown.node.label = SHOWN
    return shown
