"""Operators that ask for the file to write, and jobs that begin once it is chosen."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy_extras.io_utils import ExportHelper

from ..bridge.strands.preview import source_of
from .job import JobOperator


class FileChoice(ExportHelper):
    """Asks for the file, named like the active object."""

    # Kept by Blender together with the path: by neither is a file browser remembered that was left without a file.
    named_for: bpy.props.StringProperty(
        name="Object", description="The object after which the file was named last", options={"HIDDEN"}
    )

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the file: the last one again for the same object, else one of the object's name in its folder."""
        name = source_of(context.object).name
        self.filepath = proposed_path(self.filepath, name, self.filename_ext, self.named_for in ("", name))
        self.named_for = name
        return ExportHelper.invoke(self, context, event)


class FileJob(FileChoice, JobOperator):
    """A job that writes a file. In the window it runs beside the user's work, with its progress, and ends by Esc."""

    @property
    def _in_window(self) -> bool:
        """Whether it was started by the user rather than by a script."""
        return self.options.is_invoke and not bpy.app.background

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Run the job, now that there is a file; a script waits for it."""
        if self._in_window:
            return JobOperator.invoke(self, context, None)
        return JobOperator.execute(self, context)

    def cancel(self, context: bpy.types.Context) -> None:
        """Stop; Blender calls this too when its file browser is left, before there is a job."""
        if hasattr(self, "_job"):
            JobOperator.cancel(self, context)


def proposed_path(former: str, name: str, suffix: str, same: bool) -> str:
    """What the file browser begins with: the former path, or for another object its name in the same folder.

    Blender remembers the path of the last export: kept for another object, it would overwrite that one's file.
    """
    if former and same:
        return former
    return str(Path(former).parent / (bpy.path.clean_name(name) + suffix))
