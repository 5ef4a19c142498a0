"""Add → Dual-Color: a picture on a plate, around a cylinder, around a lamp shade."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
from bpy_extras.io_utils import ImportHelper, poll_file_object_drop

from ..bridge.input.image_input import picture_tone
from ..bridge.objects.picture_objects import add_picture_object
from ..bridge.units import LENGTH_DIGITS
from ..core.errors import PrintError
from ..core.files import title
from ..core.pictures.shapes import PLATE_BRIM_MM, PictureShape, fitted, picture_plate, picture_tube
from ..core.settings import PrintSettings
from .add_figures import DUALCOLOR_OT_add_figure_cylinder, draw_figure_entries
from .calibrate import DUALCOLOR_OT_add_calibration_tile
from .polls import in_object_mode
from .refusal import refused
from .viewing import show_added

SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".exr", ".tga", ".webp")


def _millimeters(name: str, default: float, description: str, low: float = 0.5, high: float = 200.0) -> Any:
    """A length; shown in mm in every scene that has units, for which camera lenses have the only such unit."""
    return bpy.props.FloatProperty(
        name=name, default=default, description=description, min=low, max=high, unit="CAMERA", precision=LENGTH_DIGITS
    )


_CROP_TO_HEIGHT = bpy.props.BoolProperty(
    name="Crop", description="Cut the picture to the given height about its middle; otherwise all of it is shown"
)


class _AddPicture(ImportHelper):
    """What the three have in common: choose a picture file, or have one dropped in."""

    label = ""
    brim_width = 0.0
    frame_tone = 1.0
    auto_contrast: bpy.props.BoolProperty(
        name="Auto Contrast",
        description="Stretch the picture's tones from black to white, since a print shows less contrast than a screen",
        default=True,
    )
    filename_ext = ""
    filter_glob: bpy.props.StringProperty(default=";".join(f"*{suffix}" for suffix in SUFFIXES), options={"HIDDEN"})
    filepath: bpy.props.StringProperty(
        name="Picture", description="The picture's file", subtype="FILE_PATH", options={"SKIP_SAVE", "HIDDEN"}
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Objects can be added only in object mode."""
        return in_object_mode(cls, context)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the picture unless it was dropped in."""
        if self.filepath:
            return self.execute(context)
        return ImportHelper.invoke(self, context, event)

    def shape(self, settings: PrintSettings, proportions: float) -> PictureShape:
        """What bears the picture, whose width is `proportions` times its height.

        Raises:
            PrintError: the lengths do not fit together.
        """
        raise NotImplementedError

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Add the object, and show it; a scene without anything else to print becomes one in millimeters."""
        path = Path(bpy.path.abspath(self.filepath))
        settings = PrintSettings(texture_filter="lanczos", brim_width=self.brim_width)
        try:
            image = picture_tone(path)
            high, wide = image.tone.shape
            shape = self.shape(settings, wide / high)
            picture = fitted(image, shape, auto_contrast=self.auto_contrast, frame_tone=self.frame_tone)
            obj = add_picture_object(picture, shape, f"{title(path)} {self.label}", settings)
        except PrintError as problem:
            return refused(self, problem)
        show_added(context, obj)
        width, height = shape.size
        self.report({"INFO"}, f"{obj.name}: {width:.1f} × {height:.1f} mm, {shape.columns} × {shape.rows} texels")
        return {"FINISHED"}


class DUALCOLOR_OT_add_plate(_AddPicture, bpy.types.Operator):
    """Add an upright plate with a picture in front, one texel for every two layers"""

    bl_idname = "dualcolor.add_plate"
    bl_label = "Image Plate"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)
    label = "Plate"
    brim_width = PLATE_BRIM_MM
    height: _millimeters("Height", 35.5, "Height of the picture; made a whole number of layer pairs", high=150.0)
    crop: bpy.props.BoolProperty(
        name="Crop", description="Cut the picture to the given width about its middle; otherwise all of it is shown"
    )
    width: _millimeters("Width", 30.0, "Width of the picture if it is cut; made a whole number of texels")
    thickness: _millimeters("Thickness", 2.0, "Thickness of the plate", low=0.8, high=50.0)
    frame: _millimeters("Frame", 0.0, "Width of a frame of one tone around the picture", low=0.0, high=50.0)
    frame_tone: bpy.props.FloatProperty(
        name="Frame Tone", description="Tone of the frame: 0 is black, 1 is white", default=1.0, min=0.0, max=1.0
    )

    def draw(self, _context: bpy.types.Context) -> None:
        """The lengths; the width only if it says something."""
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "height")
        layout.prop(self, "crop")
        row = layout.row()
        row.enabled = self.crop
        row.prop(self, "width")
        layout.prop(self, "thickness")
        layout.prop(self, "auto_contrast")
        layout.prop(self, "frame")
        row = layout.row()
        row.enabled = self.frame > 0
        row.prop(self, "frame_tone")

    def shape(self, settings: PrintSettings, proportions: float) -> PictureShape:
        """The plate."""
        width = self.width if self.crop else self.height * proportions
        return picture_plate(width, self.height, self.thickness, settings, self.frame)


class DUALCOLOR_OT_add_cylinder(_AddPicture, bpy.types.Operator):
    """Add a cylinder with a picture wrapped around it once, its middle in front"""

    bl_idname = "dualcolor.add_cylinder"
    bl_label = "Image Cylinder"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)
    label = "Cylinder"
    diameter: _millimeters("Diameter", 30.0, "Diameter of the cylinder", low=4.0, high=140.0)
    crop: _CROP_TO_HEIGHT
    height: _millimeters("Height", 40.0, "Height if the picture is cut; made a whole number of layer pairs", high=150.0)

    def shape(self, settings: PrintSettings, proportions: float) -> PictureShape:
        """The solid cylinder."""
        around = np.pi * self.diameter
        return picture_tube(self.diameter, self.diameter, self.height if self.crop else around / proportions, settings)


class DUALCOLOR_OT_add_lamp_shade(_AddPicture, bpy.types.Operator):
    """Add a lamp shade, open below and above, with a picture wrapped around it once, its middle in front"""

    bl_idname = "dualcolor.add_lamp_shade"
    bl_label = "Image Lamp Shade"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)
    label = "Lamp Shade"
    bottom_diameter: _millimeters("Bottom Diameter", 60.0, "Outer diameter at the bottom", low=4.0, high=140.0)
    top_diameter: _millimeters("Top Diameter", 40.0, "Outer diameter at the top", low=4.0, high=140.0)
    wall: _millimeters("Wall Thickness", 2.0, "Thickness of the wall", low=0.8, high=20.0)
    crop: _CROP_TO_HEIGHT
    height: _millimeters("Height", 60.0, "Height if the picture is cut; made a whole number of layer pairs", high=150.0)

    def shape(self, settings: PrintSettings, proportions: float) -> PictureShape:
        """The shell."""
        height = self.height
        if not self.crop:
            height = np.pi * (self.bottom_diameter + self.top_diameter) / 2 / proportions
        return picture_tube(self.bottom_diameter, self.top_diameter, height, settings, self.wall)


class DUALCOLOR_FH_image(bpy.types.FileHandler):
    """A picture dropped into the 3D view becomes a plate."""

    bl_idname = "DUALCOLOR_FH_image"
    bl_label = "Dual-Color image plate"
    bl_import_operator = "dualcolor.add_plate"
    bl_file_extensions = ";".join(SUFFIXES)

    @classmethod
    def poll_drop(cls, context: bpy.types.Context) -> bool:
        """Where objects can be dropped."""
        return poll_file_object_drop(context) and context.mode == "OBJECT"


class DUALCOLOR_MT_add(bpy.types.Menu):
    """Objects to print a picture on."""

    bl_label = "Dual-Color"

    def draw(self, _context: bpy.types.Context) -> None:
        """One entry a shape."""
        for added, icon in _ENTRIES:
            self.layout.operator(added.bl_idname, icon=icon)
        self.layout.separator()
        draw_figure_entries(self.layout)
        self.layout.separator()
        self.layout.operator(DUALCOLOR_OT_add_calibration_tile.bl_idname, icon="MESH_GRID")


_ENTRIES = (
    (DUALCOLOR_OT_add_plate, "IMAGE_PLANE"),
    (DUALCOLOR_OT_add_cylinder, "MESH_CYLINDER"),
    (DUALCOLOR_OT_add_lamp_shade, "LIGHT_POINT"),
)
CLASSES = (*(added for added, _ in _ENTRIES), DUALCOLOR_OT_add_figure_cylinder, DUALCOLOR_FH_image, DUALCOLOR_MT_add)


def draw_add_entry(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """The entry of the menu Add."""
    self.layout.menu(DUALCOLOR_MT_add.__name__, icon="TEXTURE")
