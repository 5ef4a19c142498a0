"""The results of the analysis on the object: a collection of colored curves, marks and faces."""

from __future__ import annotations

import json
from typing import Any

import bpy
import numpy as np

from ...core.analysis.analysis import Analysis
from ...core.analysis.surface_curves import (
    BIRTH_COLOR,
    DEATH_COLOR,
    DEGRADED_COLOR,
    DISCARDED_COLOR,
    FADED_COLOR,
    GONE_COLOR,
    HEAT_COLORS,
    HEAT_STOPS,
    SHORT_COLOR,
    TRACE_COLOR,
    Rgb,
    SurfaceCurves,
    faded_curves,
    heat_curves,
    loop_curves,
    sample_points,
    trace_curves,
)
from ...core.model import BoolArray, FloatArray
from ...core.printability.slopes import DEGRADED_DEG, GONE_DEG, from_flat_deg
from ...core.texture.decode import linear_from_srgb
from ..kept import kept_json
from ..materials import new_material
from ..strands.preview import bed_origin
from ..strands.strand_curves import new_curves, set_drawing
from ..units import mm_per_unit

SOURCE_KEY = "dualcolor_analysis_of"
REPORT_KEY = "dualcolor_analysis"
_REPORTED = ("pattern", "tracelines", "too_short", "slopes", "faded", "settings", "warnings")
COLOR_KEY = "dualcolor_overlay_color"
_HEAT_MM, _TRACE_MM, _MARK_MM, _FACE_LIFT_MM = 0.15, 0.08, 0.6, 0.08
_OCTAHEDRON = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=float)
_OCTAHEDRON_FACES = np.array(
    [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]], dtype=np.int64
)


def show_analysis(found: Analysis, source: bpy.types.Object) -> bpy.types.Collection:
    """Show an analysis where its object stands, in place of the one before, and keep its report with the object.

    The collection `<object> Analysis` holds an object for each kind of finding; they cannot be selected, so that the
    object stays the active one.

    Returns:
        The collection, linked to the scene.
    """
    scene = bpy.context.scene
    unit = mm_per_unit(scene)
    origin = bed_origin(found.mesh, source, unit) / unit
    new = [*_pattern_overlays(found, unit), *_guard_overlays(found, unit)]
    collection = overlays_of(source) or bpy.data.collections.new(f"{source.name} Analysis")
    hidden = {held.name.rsplit(".", 1)[0] for held in overlays_in(collection) if held.hide_viewport}
    _clear(collection)
    collection[SOURCE_KEY] = source
    for made in new:
        made.location = origin
        made.hide_select = True
        made.hide_viewport = made.hide_render = made.name.rsplit(".", 1)[0] in hidden
        collection.objects.link(made)
    if collection not in scene.collection.children_recursive:
        scene.collection.children.link(collection)
    set_drawing(scene)
    source[REPORT_KEY] = json.dumps(found.report)
    return collection


def overlays_of(source: bpy.types.Object) -> bpy.types.Collection | None:
    """The collection that shows the analysis of an object; None if there is none."""
    return next((held for held in bpy.data.collections if held.get(SOURCE_KEY) == source), None)


def overlays_in(collection: bpy.types.Collection) -> list[bpy.types.Object]:
    """The overlays of a collection, without what the user has put there."""
    return [held for held in collection.objects if COLOR_KEY in held]


def remove_analysis(source: bpy.types.Object) -> bool:
    """Remove the analysis of an object; False if there was none. Whatever else its collection holds stays."""
    source.pop(REPORT_KEY, None)
    collection = overlays_of(source)
    if collection is None:
        return False
    _clear(collection)
    del collection[SOURCE_KEY]
    if not collection.objects and not collection.children:
        bpy.data.collections.remove(collection)
    return True


def analysis_of(source: bpy.types.Object) -> dict[str, Any]:
    """The report of the last analysis of an object; empty before the first."""
    return kept_json(source.get(REPORT_KEY), {}, _REPORTED)


def _clear(collection: bpy.types.Collection) -> None:
    for held in overlays_in(collection):
        data = held.data
        bpy.data.objects.remove(held)
        if not data.users:
            (bpy.data.meshes if isinstance(data, bpy.types.Mesh) else bpy.data.hair_curves).remove(data)


def _pattern_overlays(found: Analysis, unit: float) -> list[bpy.types.Object]:
    """Seams and tracelines; none without waves."""
    if found.errors is None or found.traced is None:
        return []
    lines, plane, samples, traced = found.lines, found.layers.plane, found.samples, found.traced
    seams, discarded = heat_curves(lines, plane, found.errors)
    shown = [
        _curve_object(f"Seam Error from {stop:g}", color, curves, _HEAT_MM, unit)
        for stop, color, curves in zip(HEAT_STOPS, HEAT_COLORS, seams, strict=True)
    ]
    shown += [
        _curve_object("Not Compared", DISCARDED_COLOR, discarded, _TRACE_MM, unit),
        _curve_object("Tracelines", TRACE_COLOR, trace_curves(lines, plane, samples, traced), _TRACE_MM, unit),
        _mark_object("Births", BIRTH_COLOR, sample_points(lines, plane, samples, traced.birth), unit),
        _mark_object("Deaths", DEATH_COLOR, sample_points(lines, plane, samples, traced.death), unit),
    ]
    return [made for made in shown if made]


def _guard_overlays(found: Analysis, unit: float) -> list[bpy.types.Object]:
    """Where the wave is faded or missing, and where the surface is too flat."""
    plane = found.layers.plane
    angle = from_flat_deg(found.mesh)
    shown = [
        _curve_object("Wave Faded", FADED_COLOR, faded_curves(found.lines, plane, found.faded), _TRACE_MM, unit),
        _curve_object("Too Short", SHORT_COLOR, loop_curves(found.lines, plane, found.too_short), _HEAT_MM, unit),
        _face_object(
            f"Below {DEGRADED_DEG:.0f}° from Flat", DEGRADED_COLOR, found,
            (angle < DEGRADED_DEG) & (angle >= GONE_DEG), unit,
        ),
        _face_object(f"Below {GONE_DEG:.0f}° from Flat", GONE_COLOR, found, angle < GONE_DEG, unit),
    ]  # fmt: skip
    return [made for made in shown if made]


def _curve_object(
    name: str, color: Rgb, curves: SurfaceCurves, radius_mm: float, unit: float
) -> bpy.types.Object | None:
    if not len(curves.points):
        return None
    radius = np.full(len(curves.points), radius_mm / unit)
    return _object(name, color, new_curves(name, curves.points / unit, np.diff(curves.start), radius, {}))


def _mark_object(name: str, color: Rgb, points: FloatArray, unit: float) -> bpy.types.Object | None:
    """Octahedra, which every display mode of the viewport shows."""
    corners = (points[:, None] + _MARK_MM * _OCTAHEDRON).reshape(-1, 3)
    faces = _OCTAHEDRON_FACES + len(_OCTAHEDRON) * np.arange(len(points))[:, None, None]
    return _mesh_object(name, color, corners / unit, faces.reshape(-1, 3))


def _face_object(name: str, color: Rgb, found: Analysis, chosen: BoolArray, unit: float) -> bpy.types.Object | None:
    """Copies of faces a little above them."""
    corners = found.mesh.vertices[found.mesh.faces[chosen]] + _FACE_LIFT_MM * found.paint.normal[chosen][:, None]
    return _mesh_object(name, color, corners.reshape(-1, 3) / unit, np.arange(3 * len(corners)).reshape(-1, 3))


def _mesh_object(name: str, color: Rgb, corners: FloatArray, faces: np.ndarray) -> bpy.types.Object | None:
    if not len(faces):
        return None
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners.tolist(), [], faces.tolist())
    return _object(name, color, mesh)


def _object(name: str, color: Rgb, data: bpy.types.ID) -> bpy.types.Object:
    linear = tuple(float(value) for value in linear_from_srgb(np.array(color)))
    data.materials.append(_paint(name, linear))
    made = bpy.data.objects.new(name, data)
    made[COLOR_KEY] = linear
    return made


def _paint(name: str, linear: tuple[float, ...]) -> bpy.types.Material:
    """An emissive material, so that shading does not change its color."""
    name = f"Overlay {name}"
    material = bpy.data.materials.get(name)
    if material:
        return material
    material = new_material(name)
    material.diffuse_color = (*linear, 1.0)
    nodes = material.node_tree.nodes
    nodes.clear()
    shine, output = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    shine.inputs["Color"].default_value = (*linear, 1.0)
    material.node_tree.links.new(shine.outputs["Emission"], output.inputs["Surface"])
    return material
