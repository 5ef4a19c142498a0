"""Render Predicted Print, and Export Predicted Print as Mesh."""

from __future__ import annotations

from pathlib import Path

import bpy

from ..bridge.input.mesh_input import WITH_SURFACE, surface_model
from ..bridge.pictures.render import RenderStoppedError
from ..bridge.pictures.views import picture_steps
from ..bridge.properties import to_settings
from ..bridge.strands.preview import preview_of, source_of
from ..bridge.strands.rods import rods_of
from ..core.errors import PrintError
from ..core.files import OutputFiles
from ..core.pictures.viewing import DISTANCES_MM, TURNTABLE, VIEWS, PictureOptions, view_files
from ..core.strands.mesh_files import write_mesh
from .file_choice import FileChoice, FileJob
from .job import JobOperator, Steps
from .refusal import refused
from .viewing import show_file

_VIEW_ITEMS = [
    (view.upper().replace("-", "_"), view.title(), f"Picture named …_{view}", 1 << number)
    for number, view in enumerate((*VIEWS, TURNTABLE))
]
_DISTANCE_ITEMS = [("ALL", "Everything", "Leave all detail in")] + [
    (name.upper(), f"{name.title()} ({mm:.0f} mm)", f"Leave out what an eye at {mm:.0f} mm does not see any more")
    for name, mm in DISTANCES_MM.items()
]


class _ForStrands:
    """What operators that save something of the active object's strands have in common."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Strands are needed."""
        obj = source_of(context.object)
        if obj is None or preview_of(obj) is None:
            cls.poll_message_set("Generate the toolpath first")
            return False
        return True


class DUALCOLOR_OT_render_prediction(_ForStrands, FileJob, bpy.types.Operator):
    """Render the strands in a small studio with Cycles, which takes about a minute, and show the picture"""

    _written: tuple[Path, ...] = ()
    bound_to_scene = False  # it has one of its own

    bl_idname = "dualcolor.render_prediction"
    bl_label = "Render Predicted Print"
    filename_ext = ".png"
    filter_glob: bpy.props.StringProperty(default="*.png", options={"HIDDEN"})
    width: bpy.props.IntProperty(
        name="Width", description="Of the picture", default=900, min=16, max=8192, subtype="PIXEL"
    )
    height: bpy.props.IntProperty(
        name="Height", description="Of the picture", default=900, min=16, max=8192, subtype="PIXEL"
    )
    samples: bpy.props.IntProperty(name="Samples", description="Most rays a pixel", default=64, min=1, max=4096)
    views: bpy.props.EnumProperty(
        name="Views", description="Sides of which pictures are taken", items=_VIEW_ITEMS, options={"ENUM_FLAG"},
        default={"THREE_QUARTER"},
    )  # fmt: skip
    azimuth: bpy.props.FloatProperty(
        name="Front (°)", description="Side of the object that is its front: 0° is -Y, 90° is +X", min=-360, max=360
    )
    distance: bpy.props.EnumProperty(
        name="Distance", description="Where the print is looked at from", items=_DISTANCE_ITEMS
    )
    contact_sheet: bpy.props.BoolProperty(
        name="Contact Sheet",
        description="Also save …_sheet.png: texture on the model, predicted print, and print at viewing distance",
    )
    whole_plate: bpy.props.BoolProperty(name="Whole Plate", description="Show the cleaning tower and the skirt too")

    def draw(self, _context: bpy.types.Context) -> None:
        """The views in a column, since in a row their names would be cut off."""
        layout = self.layout
        layout.use_property_split = True
        for name in ("width", "height", "samples", "azimuth", "distance", "contact_sheet", "whole_plate"):
            layout.prop(self, name)
        layout.column(align=True).prop(self, "views")

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Wait for the renderer, then show the last picture; Esc is for the renderer."""
        if event.type == "ESC" and bpy.app.is_job_running("RENDER"):
            return {"PASS_THROUGH"}
        try:
            outcome = JobOperator.modal(self, context, event)
        except RenderStoppedError:
            self.report({"INFO"}, "Cancelled, nothing was saved")
            return {"CANCELLED"}
        if outcome == {"FINISHED"}:
            show_file(context, self._written[-1])
        return outcome

    def steps(self, context: bpy.types.Context) -> Steps:
        """Take the pictures and write all or none.

        Raises:
            PrintError: to be reported to the user; nothing has been written.
            RenderStoppedError: by the user.
        """
        path = Path(bpy.path.abspath(self.filepath))
        source = source_of(context.object)
        views = [view for view in (*VIEWS, TURNTABLE) if view.upper().replace("-", "_") in self.views]
        paths = view_files(path, [] if views == ["three-quarter"] else views)
        sheet = path.with_name(f"{path.stem}_sheet.png") if self.contact_sheet else None
        model, background = None, 0.5
        if sheet and source.type in WITH_SURFACE:
            settings = to_settings(source.dualcolor)
            background = settings.background_tone
            model = surface_model(source, context.evaluated_depsgraph_get(), settings, source.dualcolor.image)
        options = PictureOptions(
            azimuth_deg=self.azimuth,
            distance="" if self.distance == "ALL" else self.distance.lower(),
            resolution=(self.width, self.height),
            samples=self.samples,
            whole_plate=self.whole_plate,
        )
        with OutputFiles(paths | ({"sheet": sheet} if sheet else {})) as files:
            staged = {view: files.staged(view) for view in paths}
            yield from picture_steps(
                preview_of(source), staged, options, sheet and files.staged("sheet"), model, background, self._in_window
            )
        self._written = tuple(files.paths.values())
        return f"Saved {', '.join(written.name for written in self._written)}"


class DUALCOLOR_OT_export_strands(_ForStrands, FileChoice, bpy.types.Operator):
    """Save the strands as a mesh of closed tubes, in mm"""

    bl_idname = "dualcolor.export_strands"
    bl_label = "Export Predicted Print"
    filename_ext = ".stl"
    filter_glob: bpy.props.StringProperty(default="*.stl;*.obj", options={"HIDDEN"})

    def check(self, _context: bpy.types.Context) -> bool:
        """Give a name without a suffix the usual one while it is chosen, so that Blender sees what it would replace."""
        path = Path(self.filepath)
        if not path.name or path.suffix or path.is_dir():
            return False
        self.filepath += self.filename_ext
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Sweep the strands and write the file."""
        path = Path(bpy.path.abspath(self.filepath))
        try:
            with OutputFiles({"mesh": path}) as files:
                write_mesh(files.staged("mesh"), rods_of(preview_of(source_of(context.object))))
        except PrintError as problem:
            return refused(self, problem)
        self.report({"INFO"}, f"Saved {path.name}")
        return {"FINISHED"}


OPERATORS = (DUALCOLOR_OT_render_prediction, DUALCOLOR_OT_export_strands)
