"""The panel Calibrate: the tile, its photograph, and the tone table in use."""

from __future__ import annotations

from contextlib import suppress
from functools import lru_cache
from pathlib import Path

import bpy

from ..bridge.objects.calibration_tile import is_calibration_tile
from ..bridge.properties import to_settings
from ..bridge.strands.preview import source_of
from ..core.calibration.calibrate import table_for
from ..core.errors import PrintError
from ..core.settings import PrintSettings
from ..operators.calibrate import DUALCOLOR_OT_add_calibration_tile, DUALCOLOR_OT_read_calibration_photo
from .rows import draw_sentence, draw_settings
from .sections import CALIBRATE
from .tab import ObjectPanel, order_of


class DUALCOLOR_PT_calibrate(ObjectPanel, bpy.types.Panel):
    """Calibration of tones, by simulation or by a print of your own."""

    bl_label = CALIBRATE.title
    bl_order = order_of("calibrate")
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012  (Blender reads the class)

    def draw(self, context: bpy.types.Context) -> None:
        """The tile and its photograph, then the table."""
        obj, layout = source_of(context.object), self.layout
        column = layout.column(align=True)
        column.operator(DUALCOLOR_OT_add_calibration_tile.bl_idname, text="Add Calibration Tile", icon="MESH_GRID")
        column.operator(DUALCOLOR_OT_read_calibration_photo.bl_idname, icon="IMAGE_REFERENCE")
        draw_settings(layout, obj, CALIBRATE)
        for text, icon in table_words(obj):
            draw_sentence(layout, context, text, icon)


def table_words(obj: bpy.types.Object) -> list[tuple[str, str]]:
    """Notes about the tone table of an object: sentences and their icons."""
    if is_calibration_tile(obj):
        return [("The tile prints its tones as they are, whatever they look like", "INFO")]
    try:
        settings = to_settings(obj.dualcolor)
    except PrintError as problem:
        return [(str(problem), "ERROR")]
    if settings.calibration == "none":
        return [("No table: tones are printed as they are", "INFO")]
    changed = 0.0
    with suppress(OSError):  # the table that cannot be read reports it
        changed = Path(settings.calibration_file).stat().st_mtime
    return _words_of(settings, changed)


@lru_cache(maxsize=8)
def _words_of(settings: PrintSettings, _changed: float) -> list[tuple[str, str]]:
    """The table is read once, until the settings or the file change."""
    try:
        table = table_for(settings)
    except PrintError as problem:
        return [(str(problem), "ERROR")]
    low, high = table.reflectance[0, [0, -1]]
    whose = "Your own table" if settings.calibration == "file" else "The program's table"
    words = [(f"{whose}, by {table.provenance.source}: an upright wall shows {low:.2f} to {high:.2f}", "CHECKMARK")]
    differences = table.provenance.differences(settings)
    if differences:
        words.append((f"It holds for other settings: {', '.join(differences)}", "ERROR"))
    return words
