"""Rows that several panels draw: settings, sentences, the progress of a job."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from typing import Any

import bpy

from ..bridge.properties import as_shown, values_of
from ..operators.job import JobOperator
from .in_use import in_use
from .sections import Section

_LETTER_PX = 6.5  # of the interface's font, a little more than on average
_AROUND_PX = 83  # of the sidebar's width: its tabs, the margins of panels and the icon


def draw_settings(layout: bpy.types.UILayout, obj: bpy.types.Object, section: Section) -> None:
    """The settings of a section, one a row; gray where they do nothing beside the others."""
    column = layout.column()
    for name in section.settings:
        declared = obj.dualcolor.bl_rna.properties[name]
        row = column.row()
        row.active = in_use(obj.dualcolor, name)
        if declared.type != "ENUM":
            row.prop(obj.dualcolor, name, text=label_with_unit(declared, bpy.context.scene))
            continue
        row = row.split(factor=0.4)  # numbers have their names inside the field, choices beside it
        row.label(text=declared.name)
        row.prop(obj.dualcolor, name, text="")


def label_with_unit(declared: bpy.types.Property, scene: bpy.types.Scene) -> str:
    """A property's name, with the unit of a length where Blender shows none: in scenes without a unit system."""
    bare = getattr(declared, "unit", "") == "CAMERA" and scene.unit_settings.system == "NONE"
    return f"{declared.name} (mm)" if bare else declared.name


def draw_sentence(layout: bpy.types.UILayout, context: bpy.types.Context, text: str, icon: str = "ERROR") -> None:
    """A sentence on as many lines as the sidebar's width asks for."""
    column = layout.column(align=True)
    column.scale_y = 0.8
    width, scale = context.region.width, context.preferences.system.ui_scale
    for number, line in enumerate(wrapped(as_shown(text), width, scale)):
        column.label(text=line, icon="BLANK1" if number else icon, translate=False)


def draw_figures(layout: bpy.types.UILayout, figures: Iterable[tuple[str, str]], factor: float) -> None:
    """A table of labels and values; the labels take the share `factor` of its width."""
    table = layout.column(align=True)
    for label, value in figures:
        row = table.split(factor=factor)
        row.label(text=label)
        row.label(text=value, translate=False)


def draw_outdated(layout: bpy.types.UILayout, report: dict[str, Any], group: bpy.types.PropertyGroup) -> None:
    """A hint if the settings are others than those of the report."""
    if report["settings"] != values_of(group):
        layout.label(text="Settings have changed since", icon="FILE_REFRESH")


def wrapped(text: str, width_px: float, scale: float) -> list[str]:
    """A text as the lines that fit into a region of the sidebar."""
    return textwrap.wrap(text, _letters(width_px, scale))


def fitting(context: bpy.types.Context, text: str, short: str, share: float = 1.0) -> str:
    """What to write on a button: the text, or the short one where the sidebar is so narrow that it would be cut off.

    Args:
        context: of the panel.
        text: if there is room.
        short: if there is not.
        share: of the sidebar's width that the button takes.
    """
    room = share * _letters(context.region.width, context.preferences.system.ui_scale)
    return text if len(text) <= room else short


def _letters(width_px: float, scale: float) -> int:
    """How many letters of the usual width a row beside an icon has room for."""
    return max(10, int((width_px / scale - _AROUND_PX) / _LETTER_PX))


def draw_progress(layout: bpy.types.UILayout, *operators: type[bpy.types.Operator]) -> None:
    """How far the job has come, if it is one of these operators'."""
    running = JobOperator.running
    if running and isinstance(running.job, operators):
        layout.progress(factor=running.share, text=running.stage)
        layout.label(text="Esc cancels", icon="CANCEL")
