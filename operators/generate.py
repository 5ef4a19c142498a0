"""Generate Dual-Color Toolpath."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from functools import partial

import bpy

from ..bridge.input.plate import check_present, objects_to_print, plate_model
from ..bridge.properties import set_report, to_settings
from ..bridge.results import digest_of, keep, kept, stages_of
from ..bridge.strands.preview import build_preview, source_of, strands_of
from ..core.errors import counted
from ..core.model import SurfaceModel
from ..core.pipeline import DualColorPrint, steps
from ..core.progress import Progress, awaited, in_own_thread, translated
from ..core.settings import PrintSettings
from .job import JobOperator, Steps
from .polls import has_printable
from .viewing import make_active, show_in_local_views

_SHARE_OF_PIPELINE = 0.95


def active_model(context: bpy.types.Context) -> tuple[bpy.types.Object, SurfaceModel, PrintSettings]:
    """The active object alone, as it is now: the object, its surface and its settings.

    Raises:
        PrintError: it cannot be read.
    """
    obj = source_of(context.object)
    settings = to_settings(obj.dualcolor)
    return obj, plate_model([obj], context.evaluated_depsgraph_get(), settings, [obj.dualcolor.image]), settings


def printed(
    context: bpy.types.Context, reuse: bool, begin_gcode: bool = False
) -> Generator[Progress, None, DualColorPrint]:
    """Print the chosen objects as they are now, show their strands and store the report with the active one.

    Nothing is touched before the end.

    Args:
        context: says which objects; the active one has the settings.
        reuse: whether the last print will do if nothing has changed since.
        begin_gcode: whether its G-code is asked for at once.

    Raises:
        PrintError: it cannot be printed.
    """
    yield 0.0, "reading the object"
    objects = objects_to_print(context)
    check_present(objects)
    obj, *others = objects
    settings = to_settings(obj.dualcolor)
    images = [each.dualcolor.image for each in objects]
    model = plate_model(objects, context.evaluated_depsgraph_get(), settings, images)
    digest = in_own_thread(digest_of, model, settings)  # reading all texels takes as long as a stage
    result = kept(obj, digest.result()) if reuse else None
    if result is None:
        job = steps(model, settings, stages_of(obj), begin_gcode)
        result = yield from translated(job, lambda step: (step[0] * _SHARE_OF_PIPELINE, step[1]))
        laid = yield from awaited(partial(strands_of, result), (_SHARE_OF_PIPELINE, "strands"))
        check_present(objects)
        show_in_local_views(context, obj, build_preview(result, obj, others, laid))
        if context.object is None:  # one of the former strands was active
            make_active(context, obj)
        set_report(obj.dualcolor, result.report)
        keep(obj, digest.result(), replace(result, begun=None))  # as large as the file
    return result


def with_warnings(message: str, result: DualColorPrint) -> str:
    """A message about a print that mentions its warnings too, since only the last message stays visible."""
    found = counted(len(result.warnings), "warning")
    return f"{message}; {found}, see the results in the sidebar" if result.warnings else message


def names_of(result: DualColorPrint) -> str:
    """The name of the print and how many objects it has beside that one."""
    more = len(result.report["objects"]) - 1
    return f"{result.name} and {more} more" if more else result.name


class DUALCOLOR_OT_generate(JobOperator, bpy.types.Operator):
    """Turn the object and its picture into a toolpath of black and white plastic, and show its strands"""

    bl_idname = "dualcolor.generate"
    bl_label = "Generate Dual-Color Toolpath"
    bl_options = {"UNDO"}  # noqa: RUF012  (Blender reads the class)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """An object with a surface is needed."""
        return has_printable(cls, context)

    def steps(self, context: bpy.types.Context) -> Steps:
        """Print the active object and the other selected ones."""
        result = yield from printed(context, reuse=False)
        self.outcome = "WARNING" if result.warnings else "INFO"
        return with_warnings(f"{names_of(result)}: {result.report['layers']} layers", result)
