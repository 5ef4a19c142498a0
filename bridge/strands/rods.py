"""The shape of the strands in a scene, for a mesh of them."""

from __future__ import annotations

import bpy
import numpy as np

from ...core.errors import PrintError
from ...core.ragged import starts
from ...core.strands.tubes import Rods
from ..mesh_data import in_world
from ..units import mm_per_unit
from .scrubber import strands_in
from .strand_curves import read_strands


def rods_of(collection: bpy.types.Collection) -> Rods:
    """The shape of the strands of a preview in world coordinates, mm.

    Raises:
        PrintError: there are none.
    """
    unit = mm_per_unit(bpy.context.scene)
    parts = []
    for shown in strands_in(collection):
        points, counts, radius, _ = read_strands(shown)
        matrix = np.array(shown.matrix_world)
        world = in_world(points, matrix) * unit
        across = radius * (unit * np.linalg.norm(matrix[:3, 0]))
        parts.append(Rods(world, starts(counts), across, radius * (unit * np.linalg.norm(matrix[:3, 2]))))
    if not parts:
        raise PrintError("there are no strands", "generate the toolpath first")
    return Rods.joined(parts)
