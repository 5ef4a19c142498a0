"""Add Calibration Tile, and Read Calibration Photo: with marks that are found, or clicked in the Image Editor."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
from bpy_extras.io_utils import ImportHelper

from ..bridge.input.mesh_input import WITH_SURFACE
from ..bridge.objects.calibration_tile import add_calibration_tile, is_calibration_tile
from ..bridge.paint.clicks import draw_clicks
from ..bridge.properties import as_shown, to_settings
from ..bridge.strands.preview import source_of
from ..core.calibration.read_photo import table_of_photo
from ..core.calibration.table import write_table
from ..core.errors import PrintError
from ..core.settings import PrintSettings
from .polls import has_printable, in_object_mode
from .refusal import refused
from .viewing import show_added

_CORNERS = ("upper left", "upper right", "lower right", "lower left")


class DUALCOLOR_OT_add_calibration_tile(bpy.types.Operator):
    """Add a step wedge to print and photograph, with the active object's settings"""

    bl_idname = "dualcolor.add_calibration_tile"
    bl_label = "Calibration Tile"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Objects can be added only in object mode."""
        return in_object_mode(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Add the tile."""
        source = source_of(context.object)
        try:
            settings = to_settings(source.dualcolor) if _is_printable(source) else PrintSettings()
            obj = add_calibration_tile(settings)
        except PrintError as problem:
            return refused(self, problem)
        show_added(context, obj)
        self.report({"INFO"}, f"{obj.name}: print it, photograph it, then Read Calibration Photo")
        return {"FINISHED"}


class _ReadsPhoto:
    """What both ways to give the photograph have in common."""

    def read(self, context: bpy.types.Context, path: Path, corners: list[tuple[float, float]] | None) -> set[str]:
        """Make the table of the active object's settings, write it beside the photograph, let the object use it."""
        obj = source_of(context.object)
        table_path = path.with_name(f"{path.stem}_tones.json")
        try:
            given = None if corners is None else np.array(corners, dtype=np.float64)
            made = table_of_photo(path, to_settings(obj.dualcolor), given, as_stored=True)
            write_table(table_path, made.table)
        except PrintError as problem:
            return refused(self, problem)
        if is_calibration_tile(obj):
            done = f"{table_path.name} written: choose it as Calibration File of what you print"
        else:
            obj.dualcolor.calibration_file, obj.dualcolor.calibration = str(table_path), "file"
            done = f"{obj.name} is calibrated by {table_path.name}"
        self.report({"INFO"}, done)
        for note in made.notes:  # the last message stays in sight
            self.report({"WARNING"}, as_shown(note))
        return {"FINISHED"}


class DUALCOLOR_OT_read_calibration_photo(_ReadsPhoto, ImportHelper, bpy.types.Operator):
    """Make a tone table from a photograph of the printed calibration tile, and calibrate the active object by it"""

    bl_idname = "dualcolor.read_calibration_photo"
    bl_label = "Read Calibration Photo"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)

    filename_ext = ""
    filter_glob: bpy.props.StringProperty(default="*.jpg;*.jpeg;*.png;*.tif;*.tiff", options={"HIDDEN"})
    filepath: bpy.props.StringProperty(
        name="Photograph", description="The photograph's file", subtype="FILE_PATH", options={"SKIP_SAVE", "HIDDEN"}
    )
    find_marks: bpy.props.BoolProperty(
        name="Find Marks",
        description="Look for the corner marks; otherwise they are where they are given",
        default=True,
    )
    corners: bpy.props.FloatVectorProperty(
        name="Corners",
        description="Where the squares of each corner mark meet, clockwise, in pixels to the right and down from the "
        "photograph's upper left",
        size=8,
        min=0.0,
        default=(0.0,) * 8,
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """An object whose settings the tile was printed with is needed."""
        return has_printable(cls, context)

    def draw(self, _context: bpy.types.Context) -> None:
        """The corners, a mark a row, if they are not looked for."""
        layout = self.layout
        layout.prop(self, "find_marks")
        column = layout.column(align=True)
        column.enabled = not self.find_marks
        for number, corner in enumerate(_CORNERS):
            row = column.row(align=True)
            row.prop(self, "corners", index=2 * number, text=corner.title())
            row.prop(self, "corners", index=2 * number + 1, text="")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Read the file."""
        corners = None if self.find_marks else [tuple(pair) for pair in np.reshape(self.corners, (4, 2)).tolist()]
        return self.read(context, Path(bpy.path.abspath(self.filepath)), corners)


class DUALCOLOR_OT_click_calibration_photo(_ReadsPhoto, bpy.types.Operator):
    """Make a tone table from the photograph shown here: click where the squares of each corner mark meet"""

    bl_idname = "dualcolor.click_calibration_photo"
    bl_label = "Read Calibration Photo"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A photograph from a file, shown in the Image Editor, and an object are needed."""
        image = getattr(context.space_data, "image", None)
        if image is None or not image.filepath:
            cls.poll_message_set("Open the photograph in the Image Editor first")
            return False
        return has_printable(cls, context)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Wait for four clicks."""
        image = context.space_data.image
        self._path, self._size = Path(bpy.path.abspath(image.filepath)), tuple(image.size)
        self.clicks: list[tuple[float, float]] = []
        self._handle = bpy.types.SpaceImageEditor.draw_handler_add(draw_clicks, (self.clicks,), "WINDOW", "POST_PIXEL")
        context.window_manager.modal_handler_add(self)
        self._ask(context)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """A click more, a click less, the end; zooming and panning go on."""
        if event.type in {"ESC", "RIGHTMOUSE"} or context.area.type != "IMAGE_EDITOR":
            self.cancel(context)
            return {"CANCELLED"}
        if event.value == "PRESS" and event.type == "BACK_SPACE" and self.clicks:
            self.clicks.pop()
        elif event.value == "PRESS" and event.type == "LEFTMOUSE" and _is_inside(context.region, event):
            at = context.region.view2d.region_to_view(event.mouse_region_x, event.mouse_region_y)
            self.clicks.append((at[0], at[1]))
        else:
            return {"PASS_THROUGH"}
        if len(self.clicks) < len(_CORNERS):
            self._ask(context)
            return {"RUNNING_MODAL"}
        self.cancel(context)
        wide, high = self._size
        return self.read(context, self._path, [(x * wide, (1.0 - y) * high) for x, y in self.clicks])

    def cancel(self, context: bpy.types.Context) -> None:
        """Take away what was drawn and said; Blender calls this too when its window closes."""
        bpy.types.SpaceImageEditor.draw_handler_remove(self._handle, "WINDOW")
        context.workspace.status_text_set(None)
        context.area.tag_redraw()

    def _ask(self, context: bpy.types.Context) -> None:
        context.workspace.status_text_set(
            f"Click where the four squares of the {_CORNERS[len(self.clicks)]} mark meet    Backspace: the last one "
            "again    Esc: cancel"
        )
        context.area.tag_redraw()


def _is_inside(region: bpy.types.Region, event: bpy.types.Event) -> bool:
    return 0 <= event.mouse_region_x < region.width and 0 <= event.mouse_region_y < region.height


def _is_printable(obj: bpy.types.Object | None) -> bool:
    return obj is not None and obj.type in WITH_SURFACE


def draw_image_entry(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """The entry of the Image Editor's menu Image."""
    self.layout.separator()
    self.layout.operator(DUALCOLOR_OT_click_calibration_photo.bl_idname, text="Read Dual-Color Calibration Photo")


OPERATORS = (
    DUALCOLOR_OT_add_calibration_tile,
    DUALCOLOR_OT_read_calibration_photo,
    DUALCOLOR_OT_click_calibration_photo,
)
