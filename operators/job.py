"""Long jobs: written once as a generator; a script runs them at once, a timer step by step in the window."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import suppress
from inspect import GEN_CREATED, getgeneratorstate

import bpy

from ..core.errors import MeshError, PrintError
from ..core.progress import Progress, drained
from ..core.records import dataclass
from .refusal import refused

_TICK_S = 0.001  # stages that are kept take no longer

Steps = Generator[Progress, None, str]
"""A job that returns the message to report."""


@dataclass(frozen=True)
class RunningJob:
    """The running job and its progress."""

    share: float
    stage: str
    job: JobOperator | None


class JobOperator:
    """What operators with a long job have in common; the job itself is `steps`. It must write to the scene last."""

    bl_idname = ""
    running: RunningJob | None = None
    outcome = "INFO"
    """How the message at the end is reported; a job that has found something sets it to WARNING."""
    bound_to_scene = True
    """Whether the scene in which the job began must be the current one until its end."""

    def steps(self, context: bpy.types.Context) -> Steps:
        """The job.

        Raises:
            PrintError: to be reported to the user; nothing has been written.
        """
        raise NotImplementedError

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Run the whole job at once, with the cursor as the only sign of progress."""
        manager = context.window_manager
        manager.progress_begin(0, 100)
        try:
            message = drained(self.steps(context), lambda step: manager.progress_update(100 * step[0]))
        except PrintError as problem:
            return refused(self, problem)
        finally:
            manager.progress_end()
        self.report({self.outcome}, message)
        return {"FINISHED"}

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Start the job and keep the window alive meanwhile."""
        if JobOperator.running:
            self.report({"WARNING"}, f"Wait for the end of the job that is running ({JobOperator.running.stage})")
            return {"CANCELLED"}
        manager = context.window_manager
        self._job, self._workspace, self._scene = self.steps(context), context.workspace, context.scene.session_uid
        self._timer = manager.event_timer_add(_TICK_S, window=context.window)
        manager.progress_begin(0, 100)
        manager.modal_handler_add(self)
        self._show(context, 0.0, "starting")
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Advance the job by one step; Esc ends it, other input waits for its end."""
        if event.type == "ESC":
            self.cancel(context)
            self.report({"INFO"}, "Cancelled, nothing was changed")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        outcome = {"CANCELLED"}
        try:
            self._check_place(context)
            self._show(context, *next(self._job))
            outcome = {"RUNNING_MODAL"}
        except StopIteration as finished:
            self.report({self.outcome}, finished.value)
            outcome = {"FINISHED"}
        except PrintError as problem:
            refused(self, problem)
        except ReferenceError:  # how Blender tells that what a name stood for is gone
            self.report({"ERROR"}, "What the job worked on was deleted meanwhile: undo that, or choose another object")
        finally:
            if outcome != {"RUNNING_MODAL"}:
                self.cancel(context)
        return outcome

    def cancel(self, context: bpy.types.Context) -> None:
        """Stop the job wherever it is; Blender calls this too when its window closes."""
        JobOperator.running = None
        self._job.close()
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        with suppress(ReferenceError):  # another file is opened
            self._workspace.status_text_set(None)
        _redraw_sidebars(context)

    def _check_place(self, context: bpy.types.Context) -> None:
        """Check that all is still there after what may have been done in another window since the last step.

        Raises:
            PrintError: the object is gone before the job has begun, or another scene is shown.
        """
        if getgeneratorstate(self._job) == GEN_CREATED and not self.poll(context):
            raise MeshError("the object was deleted before the job began", "undo that, or choose another object")
        if self.bound_to_scene and context.scene.session_uid != self._scene:
            raise PrintError("another scene was chosen while the job ran", "start it again in the object's scene")

    def _show(self, context: bpy.types.Context, share: float, stage: str) -> None:
        JobOperator.running = RunningJob(share, stage, self)
        context.window_manager.progress_update(100 * share)
        self._workspace.status_text_set(f"Dual Color: {stage} ({share:.0%})    Esc: cancel")
        _redraw_sidebars(context)


def stop_job(context: bpy.types.Context) -> None:
    """Stop the running job, if there is one: Blender does not notify it when the extension is disabled."""
    if JobOperator.running and JobOperator.running.job:
        JobOperator.running.job.cancel(context)


def _redraw_sidebars(context: bpy.types.Context) -> None:
    """Draw them anew; the views beside them may show a million points."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            for region in area.regions if area.type == "VIEW_3D" else ():
                if region.type == "UI":
                    region.tag_redraw()
