"""The printer's bed around an object, and how large the object is on it."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from mathutils import Matrix

from ..core.model import FloatArray
from ..core.settings.printer import PrinterProfile
from .mesh_data import in_world, positions
from .rig import move, movers
from .units import mm_per_unit

_ROUNDING_MM = 1e-3
_BOX_EDGES = ((0, 1), (0, 2), (1, 3), (2, 3), (4, 5), (4, 6), (5, 7), (6, 7), (0, 4), (1, 5), (2, 6), (3, 7))


def bounds_mm(objects: Sequence[bpy.types.Object]) -> FloatArray:
    """(2, 3) mm, least and greatest corner of objects in the world, modifiers included."""
    corners = np.concatenate([_corners(obj) for obj in objects])
    return np.stack([corners.min(axis=0), corners.max(axis=0)]) * mm_per_unit(bpy.context.scene)


def bed_origin_mm(bounds: FloatArray, center_on_bed: bool) -> FloatArray:
    """(3,) mm, where in the world the bed's middle lies: below the objects if they are moved there for the print."""
    if not center_on_bed:
        return np.zeros(3)
    return np.append(bounds.mean(axis=0)[:2], bounds[0, 2])


def what_does_not_fit(bounds: FloatArray, printer: PrinterProfile, center_on_bed: bool) -> str:
    """A sentence that says how much too large objects are, or that they lie beyond the reach; empty if all is well.

    Args:
        bounds: (2, 3) mm of the objects in the world.
        printer: whose nozzles must both get there.
        center_on_bed: whether the objects are moved to the middle of the bed.
    """
    placed = bounds - bed_origin_mm(bounds, center_on_bed)
    room = np.subtract(printer.reach_max, printer.reach_min)
    over = np.ptp(placed, axis=0) - room
    wide = [f"{name} by {more:.1f} mm" for name, more in zip("XYZ", over, strict=True) if more > _ROUNDING_MM]
    if wide:
        return f"Too large for both nozzles: {', '.join(wide)}"
    below, above = np.subtract(printer.reach_min, placed[0]), np.subtract(placed[1], printer.reach_max)
    outside = np.maximum(below, above) > _ROUNDING_MM
    return "Lies beyond the reach of both nozzles: move it, or turn on Center on Bed" if outside.any() else ""


def volume_lines(printer: PrinterProfile) -> FloatArray:
    """(24, 3) mm, ends of the edges of the box that both nozzles reach; the bed's middle is the origin."""
    return _box(printer.reach_min, printer.reach_max)[np.array(_BOX_EDGES).ravel()]


def reach_lines(printer: PrinterProfile, tool: int) -> FloatArray:
    """(8, 3) mm, ends of the edges of what one nozzle reaches on the bed."""
    low, high = np.array(printer.bed_min), np.array(printer.bed_max)
    high[0] = min(high[0], printer.reach_x_max[tool])
    low[2] = high[2] = 0.0
    return _box(low, high)[np.array(_BOX_EDGES[:4]).ravel()]


def scale_to_height(objects: Sequence[bpy.types.Object], height_mm: float) -> float:
    """Scale objects evenly about the first one's origin until they are together that high in the world.

    Their armatures and the like are scaled with them.

    Returns:
        The factor; 1 for objects without a height, which stay as they are.

    Raises:
        MeshError: one of them or what shapes it belongs to another file.
    """
    obj, now = objects[0], float(np.ptp(bounds_mm(objects), axis=0)[2])
    if not now > 0:
        return 1.0
    factor = height_mm / now
    if movers(*objects) == [obj]:  # no matrix, in which shear from a turned parent would be lost
        obj.scale = [side * factor for side in obj.scale]
        bpy.context.view_layer.update()
    else:
        origin = Matrix.Translation(obj.matrix_world.translation)
        move(objects, origin @ Matrix.Scale(factor, 4) @ origin.inverted())
    return factor


def _box(low: Sequence[float] | FloatArray, high: Sequence[float] | FloatArray) -> FloatArray:
    """(8, 3) corners; x changes first."""
    ends = np.array([low, high], dtype=float)
    number = np.arange(8)
    return np.stack([ends[number & 1, 0], ends[number >> 1 & 1, 1], ends[number >> 2 & 1, 2]], axis=1)


def _corners(obj: bpy.types.Object) -> FloatArray:
    """(N, 3) points in the world, in scene units, that have the object's extent."""
    matrix = np.array(obj.matrix_world)
    points = np.array(obj.bound_box)
    turned = np.count_nonzero(np.abs(matrix[:3, :3]) > 1e-6 * np.abs(matrix[:3, :3]).max()) > 3
    if turned and obj.type == "MESH" and obj.mode != "EDIT":
        mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        points = positions(mesh) if len(mesh.vertices) else points
    return in_world(points, matrix)
