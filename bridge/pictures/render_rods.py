"""Copies of strands that this Blender's Cycles draws as round rods."""

from __future__ import annotations

import bpy

from ...core.model import FloatArray, IntArray
from ...core.strands.smooth_rods import for_smooth_curves
from ..strands.strand_curves import draws_straight, new_curves


def render_rods(
    shown: bpy.types.Object, points: FloatArray, counts: IntArray, radius: FloatArray, scene: bpy.types.Scene
) -> bpy.types.Curves:
    """Rods with the material of a strand object, for its copy; with more points where Cycles would bend them.

    Args:
        shown: made by `strand_objects`.
        points: (N, 3), of all rods or some, in any unit.
        counts: (K,) points of each.
        radius: (N,) in the unit of the points.
        scene: that they are rendered in.
    """
    rods = points, counts, radius
    data = new_curves(shown.name, *(rods if draws_straight(scene) else for_smooth_curves(*rods)), {})
    data.materials.append(shown.data.materials[0])
    return data
