"""The panel that shows a part of the strands, and the legend of their colors."""

from __future__ import annotations

import blf
import bpy
import bpy.utils.previews
import gpu
from gpu_extras.batch import batch_for_shader

from ..bridge.strands.preview import is_print_shown, preview_of, source_of
from ..bridge.strands.scrubber import KINDS, last_layer, moves_shown
from ..bridge.strands.strand_colors import LEGENDS, Color, legend_of
from ..core.pictures.viewing import encoded_tone
from .tab import Tab

_SWATCH_PIXELS = 16
_handles: list[object] = []
_swatches: list[bpy.utils.previews.ImagePreviewCollection] = []


class DUALCOLOR_PT_scrubber(Tab, bpy.types.Panel):
    """Layers, moves and features that are visible, of a generated print or an imported one."""

    bl_label = "Layers"
    bl_parent_id = "DUALCOLOR_PT_predict"
    bl_order = 0

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Strands are needed."""
        return context.object is not None and preview_of(context.object) is not None

    def draw(self, context: bpy.types.Context) -> None:
        """The range, the moves, the kinds, the colors."""
        collection = preview_of(context.object)
        view = collection.dualcolor_view
        column = self.layout.column(align=True)
        column.prop(view, "layer_from")
        column.prop(view, "layer_to")
        column.prop(view, "moves", slider=True)
        shown, moves = moves_shown(collection)
        column.label(text=f"All layers: 0 to {last_layer(collection)}")
        column.label(text=f"Last one shown: {shown} of {moves} moves")
        grid = self.layout.grid_flow(columns=3, align=True)
        for kind in KINDS:
            grid.prop(view, f"show_{kind}", toggle=True)
        row = self.layout.split(factor=0.3)
        row.label(text="Color")
        row.prop(view, "color_by", text="")
        if view.color_by in LEGENDS and context.space_data.shading.type in ("WIREFRAME", "SOLID"):
            self.layout.label(text="Seen in Material Preview", icon="INFO")
        legend = self.layout.column(align=True)
        legend.scale_y = 0.8
        for text, color in legend_of(view.color_by):
            legend.label(text=text, icon_value=swatch(color))


def swatch(color: Color) -> int:
    """Number of an icon in one color."""
    held, key = _swatches[0], repr(color)
    if key not in held:
        made = held.new(key)
        made.icon_size = (_SWATCH_PIXELS, _SWATCH_PIXELS)
        made.icon_pixels_float = (*(encoded_tone(value) for value in color), 1.0) * _SWATCH_PIXELS**2
    return int(held[key].icon_id)


def _draw_legend() -> None:
    """The legend in the corner of a 3D view whose strands are colored by something."""
    context = bpy.context
    obj = source_of(context.object)
    collection = preview_of(obj) if obj else None
    if collection is None or not is_print_shown(obj) or not context.space_data.overlay.show_overlays:
        return
    size = 14 * context.preferences.system.ui_scale
    entries = legend_of(collection.dualcolor_view.color_by)
    blf.size(0, size * 0.85)
    blf.color(0, *context.preferences.themes[0].view_3d.space.text_hi, 1.0)
    blf.enable(0, blf.SHADOW)  # whatever the view's background is
    blf.shadow(0, 3, 0.0, 0.0, 0.0, 0.8)
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    for number, (text, color) in enumerate(reversed(entries)):
        left, low = 2 * size, size * (2 + 1.2 * number)
        corners = [(left, low), (left + size, low), (left + size, low + size), (left, low + size)]
        shader.uniform_float("color", (*(encoded_tone(value) for value in color), 1.0))
        batch_for_shader(shader, "TRIS", {"pos": corners}, indices=[(0, 1, 2), (0, 2, 3)]).draw(shader)
        blf.position(0, left + 1.5 * size, low + 0.2 * size, 0)
        blf.draw(0, text)
    blf.disable(0, blf.SHADOW)


def register() -> None:
    """Draw the legend in all 3D views."""
    _swatches.append(bpy.utils.previews.new())
    if not bpy.app.background:
        _handles.append(bpy.types.SpaceView3D.draw_handler_add(_draw_legend, (), "WINDOW", "POST_PIXEL"))


def unregister() -> None:
    """Draw it no more."""
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
    while _swatches:
        bpy.utils.previews.remove(_swatches.pop())
