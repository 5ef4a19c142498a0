"""Set Up Painting, Gray from Color Image, Bake Material, and Bake Ambient Occlusion."""

from __future__ import annotations

import bpy

from ..bridge.input.image_input import image_size
from ..bridge.input.printed_materials import printed_materials
from ..bridge.paint.ambient_occlusion import DISTANCE_MM, SAMPLES, darkened, occlusion_steps
from ..bridge.paint.material_bake import material_bake_steps
from ..bridge.paint.painting import (
    exchange_picture,
    give_picture,
    gray_picture,
    picture_of,
    picture_size,
    picture_uv,
    printed_attributes,
    set_up_painting,
)
from ..bridge.paint.unwrap import has_room_for_every_face
from ..bridge.properties import repaint_proof
from ..bridge.units import LENGTH_DIGITS
from ..core.errors import PrintError
from ..core.progress import translated
from ..core.texture.decode import LUMINANCE
from ..core.texture.grade import Grade
from .job import JobOperator, Steps
from .polls import has_own_mesh
from .refusal import refused
from .viewing import show_pictures


class DUALCOLOR_OT_set_up_painting(bpy.types.Operator):
    """Make a picture of the right size for the print, show it on the object and start painting on it in grays"""

    bl_idname = "dualcolor.set_up_painting"
    bl_label = "Set Up Painting"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)

    texel_size: bpy.props.FloatProperty(
        name="Texel Size", default=0.0, min=0.0, max=10.0, precision=LENGTH_DIGITS, unit="CAMERA",
        description="Greatest side of a texel on the object; 0 is half a layer",
    )  # fmt: skip

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A mesh in Object or Texture Paint Mode is needed."""
        return has_own_mesh(cls, context, leaves_mode=True)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Set it up."""
        obj = context.object
        texel = self.texel_size or obj.dualcolor.layer_height / 2
        first, notes = picture_of(obj) is None, _instead(obj)
        try:
            image = set_up_painting(obj, texel, obj.dualcolor.background_tone)
            repaint_proof(obj)
        except PrintError as problem:
            return refused(self, problem)
        message = f"Painting on {image.name}, {image.size[0]} × {image.size[1]}"
        if first and not has_room_for_every_face(obj.data):
            notes += "; strokes may show in several places, for not every face has one of its own in the UV map: unwrap"
        self.report({"WARNING" if notes else "INFO"}, message + notes)
        return {"FINISHED"}


class DUALCOLOR_OT_gray_from_color(bpy.types.Operator):
    """Make a gray picture from the object's colored one and print that; the colored one is kept"""

    bl_idname = "dualcolor.gray_from_color"
    bl_label = "From Color Image"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)

    mix: bpy.props.FloatVectorProperty(
        name="Channel Mix", size=3, default=LUMINANCE, min=-2.0, max=2.0,
        description="Weights of red, green and blue in linear light; only their ratios count",
    )  # fmt: skip
    auto_contrast: bpy.props.BoolProperty(
        name="Auto Contrast", default=True, description="Stretch the picture's own range to black and white"
    )
    black: bpy.props.FloatProperty(
        name="Black Level", default=0.0, min=0.0, max=1.0, description="Gray, as shown, that becomes black"
    )
    white: bpy.props.FloatProperty(
        name="White Level", default=1.0, min=0.0, max=1.0, description="Gray, as shown, that becomes white"
    )
    gamma: bpy.props.FloatProperty(
        name="Gamma", default=1.0, min=0.1, max=10.0, description="Above 1 lightens the middle, below 1 darkens it"
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A mesh with a picture is needed."""
        if not has_own_mesh(cls, context):
            return False
        if picture_of(context.object) is None:
            cls.poll_message_set("Choose an image, or give the material an Image Texture, first")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Make the gray picture, print it and show it."""
        obj = context.object
        former = picture_of(obj)
        grade = Grade(tuple(self.mix), self.black, self.white, self.gamma, self.auto_contrast)
        try:
            made = gray_picture(former, grade)
        except PrintError as problem:
            return refused(self, problem)
        former.use_fake_user = True  # nothing else may hold it from here on
        exchange_picture(obj, former, made)
        show_pictures(context)
        self.report({"INFO"}, f"Printing {made.name}")
        return {"FINISHED"}


class DUALCOLOR_OT_bake_material(JobOperator, bpy.types.Operator):
    """Make a picture of what the materials show, with all that their nodes do, and print that; the materials stay"""

    bl_idname = "dualcolor.bake_material"
    bl_label = "Bake Material"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A mesh with a material is needed."""
        if not has_own_mesh(cls, context):
            return False
        obj = context.object
        if not any(printed_materials(obj)) and all(modifier.type != "NODES" for modifier in obj.modifiers):
            cls.poll_message_set("Give the object a material first")
            return False
        return True

    def steps(self, context: bpy.types.Context) -> Steps:
        """Bake, then print the picture."""
        obj, own = context.object, context.object.dualcolor
        job = material_bake_steps(obj, own.layer_height / 2, own.background_tone, own.printer)
        made, note = yield from translated(job, lambda share: (share, "baking the material"))
        obj.dualcolor.image = made
        self.outcome = "WARNING" if note else "INFO"
        return f"Printing {made.name}; {note}" if note else f"Printing {made.name}"


class DUALCOLOR_OT_bake_occlusion(JobOperator, bpy.types.Operator):
    """Darken the hollows: multiply the picture by ambient occlusion, or make a picture of it; the old one is kept"""

    bl_idname = "dualcolor.bake_occlusion"
    bl_label = "Bake Ambient Occlusion"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  (Blender reads the class)

    strength: bpy.props.FloatProperty(
        name="Strength", default=1.0, min=0.0, max=1.0, subtype="FACTOR",
        description="How much of the occlusion darkens the picture",
    )  # fmt: skip
    distance: bpy.props.FloatProperty(
        name="Distance", default=DISTANCE_MM, min=0.1, max=1000.0, precision=LENGTH_DIGITS, unit="CAMERA",
        description="Surfaces farther away than this darken nothing",
    )  # fmt: skip
    samples: bpy.props.IntProperty(
        name="Samples",
        default=SAMPLES,
        min=1,
        max=1024,
        description="Rays for each vertex; more is smoother and slower",
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A mesh with a UV map is needed."""
        if not has_own_mesh(cls, context):
            return False
        if not context.object.data.uv_layers:
            cls.poll_message_set("Unwrap the mesh first")
            return False
        return True

    def steps(self, context: bpy.types.Context) -> Steps:
        """Bake, then exchange the picture; an object without one gets a white one first."""
        obj = context.object
        former, instead = picture_of(obj), _instead(obj)
        side = picture_size(obj, obj.dualcolor.layer_height / 2, obj.dualcolor.printer)
        size = image_size(former) if former else (side, side)
        uv_map = picture_uv(obj).name if former else ""
        job = occlusion_steps(obj, size, self.distance, self.samples, uv_map)
        shade = yield from translated(job, lambda share: (share, "baking ambient occlusion"))
        image = former or give_picture(obj, side, 1.0)
        made = darkened(image, shade, self.strength)
        exchange_picture(obj, image, made)
        if not former:
            bpy.data.images.remove(image)
        self.outcome = "WARNING" if instead else "INFO"
        return f"Printing {made.name}{instead}"


def _instead(obj: bpy.types.Object) -> str:
    """The end of a message about an object's first picture: which vertex colors it is printed instead of."""
    names = [] if picture_of(obj) else printed_attributes(obj)
    return f", instead of the color attribute {' and '.join(names)}" if names else ""


OPERATORS = (
    DUALCOLOR_OT_set_up_painting,
    DUALCOLOR_OT_gray_from_color,
    DUALCOLOR_OT_bake_material,
    DUALCOLOR_OT_bake_occlusion,
)
