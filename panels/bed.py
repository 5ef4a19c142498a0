"""The printer's volume, drawn around the active object; nothing of it is in the scene."""

from __future__ import annotations

import bpy
import gpu
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix

from ..bridge.bed import bed_origin_mm, bounds_mm, reach_lines, volume_lines
from ..bridge.input.plate import objects_to_print
from ..bridge.strands.preview import source_of
from ..bridge.units import mm_per_unit
from ..core.model import FloatArray
from ..core.settings.printer import printer_profile

Color = tuple[float, float, float, float]
_VOLUME: Color = (0.35, 0.65, 1.0, 0.9)
_BLACK_NOZZLE: Color = (0.02, 0.02, 0.02, 0.9)
_WHITE_NOZZLE: Color = (0.95, 0.95, 0.95, 0.9)
_handles: list[object] = []


def _draw_bed() -> None:
    context = bpy.context
    obj = source_of(context.object)
    if obj is None or not obj.dualcolor.show_bed or not context.space_data.overlay.show_overlays:
        return
    group = obj.dualcolor
    printer = printer_profile(group.printer)
    origin = bed_origin_mm(bounds_mm(objects_to_print(context) or [obj]), group.center_on_bed)
    unit = mm_per_unit(context.scene)
    with gpu.matrix.push_pop():
        gpu.matrix.multiply_matrix(Matrix.Translation(origin / unit) @ Matrix.Scale(1.0 / unit, 4))
        gpu.state.depth_test_set("LESS_EQUAL")
        gpu.state.blend_set("ALPHA")
        _draw_lines(volume_lines(printer), _VOLUME)
        for tool in (0, 1):
            _draw_lines(reach_lines(printer, tool), _BLACK_NOZZLE if tool == group.black_tool else _WHITE_NOZZLE)
        gpu.state.blend_set("NONE")
        gpu.state.depth_test_set("NONE")


def _draw_lines(ends: FloatArray, color: Color) -> None:
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    shader.uniform_float("color", color)
    batch_for_shader(shader, "LINES", {"pos": ends.tolist()}).draw(shader)


def register() -> None:
    """Draw the bed in all 3D views of objects that ask for it."""
    if not bpy.app.background:
        _handles.append(bpy.types.SpaceView3D.draw_handler_add(_draw_bed, (), "WINDOW", "POST_VIEW"))


def unregister() -> None:
    """Draw it no more."""
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
