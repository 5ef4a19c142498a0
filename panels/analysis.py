"""The panels Analysis and Orientation: findings, and the legend of their colors."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import bpy

from ..bridge.analysis.orientations import orientations_of
from ..bridge.analysis.overlays import COLOR_KEY, analysis_of, overlays_in, overlays_of
from ..bridge.strands.preview import source_of
from ..operators.analyze import DUALCOLOR_OT_analyze, DUALCOLOR_OT_remove_analysis
from ..operators.orientation import DUALCOLOR_OT_apply_orientation, DUALCOLOR_OT_suggest_orientation
from .rows import draw_figures, draw_outdated, draw_progress, draw_sentence
from .scrubber import swatch
from .tab import ObjectPanel


class DUALCOLOR_PT_analysis(ObjectPanel, bpy.types.Panel):
    """Seams, tracelines and slopes of the pattern."""

    bl_label = "Analysis"
    bl_parent_id = "DUALCOLOR_PT_pattern"
    bl_order = 0
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012  (Blender reads the class)

    def draw(self, context: bpy.types.Context) -> None:
        """The button, figures, the legend."""
        obj, layout = source_of(context.object), self.layout
        layout.operator(DUALCOLOR_OT_analyze.bl_idname, icon="VIEWZOOM")
        draw_progress(layout, DUALCOLOR_OT_analyze)
        report = analysis_of(obj)
        if not report:
            return
        draw_outdated(layout, report, obj.dualcolor)
        draw_figures(layout, analysis_figures(report), factor=0.5)
        if report["pattern"]:
            _draw_histogram(layout, report["pattern"])
        for warning in report["warnings"]:
            draw_sentence(layout, context, warning)
        _draw_legend(layout, obj)


class DUALCOLOR_PT_orientation(ObjectPanel, bpy.types.Panel):
    """Which way up."""

    bl_label = "Orientation"
    bl_parent_id = "DUALCOLOR_PT_prepare"
    bl_order = 1
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012  (Blender reads the class)

    def draw(self, context: bpy.types.Context) -> None:
        """The button and the ranked candidates."""
        obj, layout = source_of(context.object), self.layout
        layout.operator(DUALCOLOR_OT_suggest_orientation.bl_idname, icon="ORIENTATION_GIMBAL")
        draw_progress(layout, DUALCOLOR_OT_suggest_orientation)
        found = orientations_of(obj)
        if not found:
            return
        table = layout.column(align=True)
        _draw_row(table, ("Contrast", "Support", "Height", ""))
        for number, one in enumerate(found):
            row = _draw_row(
                table, (f"{one['contrast']:.0%}", f"{one['support_mm2'] / 100:.1f} cm²", f"{one['height_mm']:.0f} mm")
            )
            row.operator(DUALCOLOR_OT_apply_orientation.bl_idname).number = number


def analysis_figures(report: dict[str, Any]) -> list[tuple[str, str]]:
    """(label, value) of an analysis' figures."""
    rows = []
    if pattern := report["pattern"]:
        traced = report["tracelines"]
        rows = [
            ("Free of Error", f"{pattern['error_free']:.1%}"),
            ("Imperceptible", f"{pattern['imperceptible']:.1%}"),
            ("Salient", f"{pattern['salient']:.2%}"),
            *([("Salient, Seen", f"{pattern['salient_seen']:.2%}")] if "salient_seen" in pattern else []),
            ("Not Compared", f"{pattern['discarded_probes']:,} of {pattern['probes']:,}"),
            ("Tracelines", f"{traced['tracelines']:,}"),
            ("Births, Deaths", f"{traced['births']:,}, {traced['deaths']:,}"),
            ("Too Short", f"{report['too_short']['outlines']} of {report['too_short']['of']}"),
        ]
    slopes = report["slopes"]
    return [
        *rows,
        ("Faded", f"{report['faded']['share']:.1%} of the outline"),
        ("Contrast 20° to 30°", f"{slopes['contrast_degraded']:.1%}"),
        ("Contrast below 20°", f"{slopes['contrast_gone']:.1%}"),
    ]


def _draw_histogram(layout: bpy.types.UILayout, pattern: dict[str, Any]) -> None:
    """A bar for each class of errors, as long as the square root of its share, since the rare ones matter."""
    counts, edges = pattern["histogram"]["counts"], pattern["histogram"]["edges"]
    total = max(sum(counts), 1)
    column = layout.column(align=True)
    column.label(text="Seam errors")
    for count, (low, high) in zip(counts, pairwise(edges), strict=True):
        share = count / total
        column.progress(factor=share**0.5, text=f"{low:g} to {high:g}: {share:.2%}")


def _draw_legend(layout: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    """A row for each overlay: its color, its name, whether it is shown."""
    collection = overlays_of(obj)
    if collection is None:
        return
    head = layout.row()
    head.prop(collection, "hide_viewport", text="Hide All", toggle=True)
    head.operator(DUALCOLOR_OT_remove_analysis.bl_idname, text="Remove", icon="X")
    column = layout.column(align=True)
    for held in overlays_in(collection):
        row = column.row()
        row.label(text=held.name.rsplit(".", 1)[0], icon_value=swatch(tuple(held[COLOR_KEY])))
        row.prop(held, "hide_viewport", text="", emboss=False)


def _draw_row(table: bpy.types.UILayout, texts: tuple[str, ...]) -> bpy.types.UILayout:
    row = table.row()
    for text in texts:
        row.label(text=text)
    return row


PANELS = (DUALCOLOR_PT_analysis, DUALCOLOR_PT_orientation)
