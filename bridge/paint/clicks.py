"""Places that a user has clicked in the Image Editor, drawn over the picture."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import gpu
from gpu_extras.batch import batch_for_shader

_COLOR = (1.0, 0.55, 0.1, 1.0)
_ARM_PX = 12


def draw_clicks(places: Sequence[tuple[float, float]]) -> None:
    """Crosses at places, 0 to 1 from the picture's lower left, in the region that is being drawn."""
    ends = []
    for place in places:
        x, y = bpy.context.region.view2d.view_to_region(*place, clip=False)
        ends += [(x - _ARM_PX, y), (x + _ARM_PX, y), (x, y - _ARM_PX), (x, y + _ARM_PX)]
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    shader.uniform_float("color", _COLOR)
    batch_for_shader(shader, "LINES", {"pos": [(x, y, 0.0) for x, y in ends]}).draw(shader)
