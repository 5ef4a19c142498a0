"""The tab Dual Color in the sidebar of the 3D view."""

from __future__ import annotations

from collections.abc import Callable

import bpy

from ..bridge.input.mesh_input import MAKE_REAL, WITH_SURFACE
from ..bridge.input.metaballs import metaball_of
from ..bridge.input.plate import objects_to_print
from ..bridge.properties import values_of
from ..bridge.strands.preview import preview_of, source_of
from .analysis import PANELS as ANALYSIS_PANELS
from .calibrate import DUALCOLOR_PT_calibrate
from .paint import DUALCOLOR_PT_paint
from .predict import DUALCOLOR_PT_predict
from .prepare import DUALCOLOR_PT_prepare
from .presets import DUALCOLOR_PT_presets
from .printing import PANELS as PRINT_PANELS
from .rows import draw_sentence, draw_settings
from .scrubber import DUALCOLOR_PT_scrubber
from .sections import FOLDED, PATTERN, Section
from .supports import draw_supports
from .tab import ObjectPanel, Tab, order_of

_MORE: dict[str, Callable[[bpy.types.UILayout, bpy.types.Object], None]] = {"supports": draw_supports}


class DUALCOLOR_PT_main(Tab, bpy.types.Panel):
    """What is printed."""

    bl_label = "Dual Color"
    bl_order = order_of("main")

    def draw(self, context: bpy.types.Context) -> None:
        """The object, or what is missing."""
        obj = source_of(context.object)
        print_of_file = preview_of(obj) if obj is not None and obj.type not in WITH_SURFACE else None
        if print_of_file:
            self.layout.label(text=print_of_file.name, icon="OUTLINER_COLLECTION", translate=False)
            return
        if obj is None or obj.type not in WITH_SURFACE:
            self.layout.label(text="Select a mesh object", icon="INFO")
            self.layout.label(text="or Add > Dual-Color", icon="BLANK1")
            if obj is not None and obj.instance_type == "COLLECTION":
                self.layout.label(text=f"or {MAKE_REAL}", icon="BLANK1")
            return
        printed, *notes = what_is_printed(context)
        self.layout.label(text=printed, icon="OBJECT_DATA", translate=False)
        for note in notes:
            draw_sentence(self.layout, context, note, "INFO")
        whole = metaball_of(obj, context.scene)
        if whole != obj:
            draw_sentence(self.layout, context, f"A part of {whole.name}: select that", "INFO")


def what_is_printed(context: bpy.types.Context) -> list[str]:
    """The object to print and how many with it; a sentence if these have settings of their own, which do not count."""
    obj, *others = objects_to_print(context)
    if not others:
        return [obj.name]
    settings = values_of(obj.dualcolor)
    differ = any(values_of(other.dualcolor) != settings for other in others)
    notes = [f"All are printed with the settings of {obj.name}"] if differ else []
    return [f"{obj.name} and {len(others)} more", *notes]


class DUALCOLOR_PT_pattern(ObjectPanel, bpy.types.Panel):
    """How tone is made."""

    bl_label = PATTERN.title
    bl_order = order_of("pattern")
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012  (Blender reads the class)

    def draw(self, context: bpy.types.Context) -> None:
        """The settings."""
        draw_settings(self.layout, source_of(context.object), PATTERN)


def _folded_panel(section: Section, order: int) -> type[bpy.types.Panel]:
    """A closed panel inside a stage's."""

    def draw_header(self: bpy.types.Panel, context: bpy.types.Context) -> None:
        self.layout.prop(source_of(context.object).dualcolor, section.switch, text="")

    def draw(self: bpy.types.Panel, context: bpy.types.Context) -> None:
        obj = source_of(context.object)
        draw_settings(self.layout, obj, section)
        if section.key in _MORE:
            _MORE[section.key](self.layout, obj)

    members = {
        "__doc__": f"The settings of {section.title}.",
        "__module__": __name__,
        "bl_label": section.title,
        "bl_parent_id": f"DUALCOLOR_PT_{section.stage}",
        "bl_order": order,
        "bl_options": {"DEFAULT_CLOSED"},
        "draw": draw,
    }
    if section.switch:
        members["draw_header"] = draw_header
    return type(f"DUALCOLOR_PT_{section.key}", (ObjectPanel, bpy.types.Panel), members)


PANELS = (
    DUALCOLOR_PT_main,
    DUALCOLOR_PT_presets,
    DUALCOLOR_PT_prepare,
    DUALCOLOR_PT_paint,
    DUALCOLOR_PT_pattern,
    *ANALYSIS_PANELS,
    *PRINT_PANELS,
    DUALCOLOR_PT_predict,
    DUALCOLOR_PT_scrubber,
    DUALCOLOR_PT_calibrate,
    *(_folded_panel(section, order) for order, section in enumerate(FOLDED, start=1)),
)
"""Those inside others after them."""
