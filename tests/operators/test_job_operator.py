"""Jobs that run beside the user's work: timer, progress, Esc, errors."""

from types import SimpleNamespace

import pytest

bpy = pytest.importorskip("bpy")

from dualcolor.core.errors import PrintError  # noqa: E402
from dualcolor.operators.export import DUALCOLOR_OT_export_gcode  # noqa: E402
from dualcolor.operators.file_choice import ExportHelper, FileJob, proposed_path  # noqa: E402
from dualcolor.operators.generate import DUALCOLOR_OT_generate  # noqa: E402
from dualcolor.operators.job import JobOperator, stop_job  # noqa: E402
from dualcolor.operators.presets import DUALCOLOR_OT_export_settings  # noqa: E402


class Window:
    """Stands in for a window manager and its window, which a background Blender has not."""

    def __init__(self):
        self.windows, self.window, self.workspace, self.window_manager = [], None, self, self
        self.timers, self.status, self.scene = 0, None, SimpleNamespace(session_uid=1)

    def event_timer_add(self, *_args, **_more):
        self.timers += 1
        return object()

    def event_timer_remove(self, _timer):
        self.timers -= 1

    def status_text_set(self, text):
        self.status = text

    def progress_begin(self, *_):
        pass

    progress_update = progress_end = modal_handler_add = progress_begin


class Pretended(JobOperator):
    """A job of three steps that writes at its end."""

    def __init__(self, problem=None):
        self.written, self.reports, self.problem, self.object_is_there = [], [], problem, True

    def poll(self, context):
        return self.object_is_there

    def report(self, kind, text):
        self.reports.append((*kind, text))

    def steps(self, context):
        yield 0.0, "first"
        yield 0.5, "second"
        if self.problem:
            raise self.problem
        self.written.append(1)
        return "done"


def events(job, kinds):
    window = Window()
    job.invoke(window, None)
    outcome = [job.modal(window, SimpleNamespace(type=kind)) for kind in kinds]
    return window, outcome


def test_the_timer_advances_the_job_to_its_end():
    job = Pretended()
    window, outcome = events(job, ["TIMER", "MOUSEMOVE", "TIMER", "TIMER"])
    assert outcome == [{"RUNNING_MODAL"}] * 3 + [{"FINISHED"}]
    assert job.written == [1] and job.reports == [("INFO", "done")]
    assert window.timers == 0 and window.status is None and JobOperator.running is None


def test_a_job_whose_object_is_deleted_says_so():
    job = Pretended(ReferenceError("StructRNA of type Object has been removed"))
    window, outcome = events(job, ["TIMER"] * 3)
    assert outcome[-1] == {"CANCELLED"} and JobOperator.running is None and window.timers == 0
    assert job.reports[0][0] == "ERROR" and "deleted" in job.reports[0][1]


def test_a_job_whose_object_is_gone_before_its_first_step_says_so():
    job, window = Pretended(), Window()
    job.invoke(window, None)
    job.object_is_there = False
    assert job.modal(window, SimpleNamespace(type="TIMER")) == {"CANCELLED"}
    assert "deleted" in job.reports[0][1] and JobOperator.running is None


def test_a_job_stops_when_another_scene_is_chosen_unless_it_has_one_of_its_own():
    """The active object, units and the dependency graph would be others."""
    for bound in (True, False):
        job, window = Pretended(), Window()
        job.bound_to_scene = bound
        job.invoke(window, None)
        job.modal(window, SimpleNamespace(type="TIMER"))
        window.scene = SimpleNamespace(session_uid=2)
        outcome = [job.modal(window, SimpleNamespace(type="TIMER")) for _ in range(1 if bound else 2)]
        assert outcome[-1] == ({"CANCELLED"} if bound else {"FINISHED"})
        assert job.written == ([] if bound else [1]) and JobOperator.running is None
        assert ("Another scene" in job.reports[0][1]) == bound


def test_a_second_job_waits_for_the_first():
    window, _ = events(Pretended(), ["TIMER"])
    second = Pretended()
    assert second.invoke(window, None) == {"CANCELLED"} and second.reports[0][0] == "WARNING"
    assert window.timers == 1
    stop_job(window)


def test_a_job_is_stopped_with_the_extension():
    window, _ = events(Pretended(), ["TIMER"])
    stop_job(window)
    assert window.timers == 0 and window.status is None and JobOperator.running is None
    stop_job(window)
    assert events(Pretended(), ["TIMER", "TIMER", "TIMER"])[1][-1] == {"FINISHED"}


def test_the_progress_is_told():
    window, _ = events(job := Pretended(), ["TIMER", "TIMER"])
    assert JobOperator.running.stage == "second" and "50%" in window.status
    job.cancel(window)


def test_progress_draws_sidebars_and_no_views():
    """A view may show a million points, which take longer to draw than most steps."""

    class Region(SimpleNamespace):
        def tag_redraw(self):
            drawn.append((self.of, self.type))

    drawn, window, job = [], Window(), Pretended()
    areas = [
        SimpleNamespace(type=of, regions=[Region(of=of, type=kind) for kind in ("HEADER", "UI", "WINDOW")])
        for of in ("VIEW_3D", "IMAGE_EDITOR")
    ]
    window.windows = [SimpleNamespace(screen=SimpleNamespace(areas=areas))] * 2
    job.invoke(window, None)
    job.modal(window, SimpleNamespace(type="TIMER"))
    job.cancel(window)
    assert drawn == [("VIEW_3D", "UI")] * 6


def test_escape_leaves_everything_as_it_was():
    job = Pretended()
    window, outcome = events(job, ["TIMER", "TIMER", "ESC"])
    assert outcome[-1] == {"CANCELLED"}
    assert job.written == [] and window.timers == 0 and JobOperator.running is None


@pytest.mark.parametrize("problem", [PrintError("no UVs"), ZeroDivisionError("a bug")])
def test_a_failed_job_frees_the_window_and_a_bug_keeps_its_traceback(problem):
    job, window = Pretended(problem), Window()
    job.invoke(window, None)
    job.modal(window, SimpleNamespace(type="TIMER"))
    job.modal(window, SimpleNamespace(type="TIMER"))
    if isinstance(problem, PrintError):
        assert job.modal(window, SimpleNamespace(type="TIMER")) == {"CANCELLED"}
        assert job.reports == [("ERROR", "No UVs")]
    else:
        with pytest.raises(ZeroDivisionError):
            job.modal(window, SimpleNamespace(type="TIMER"))
    assert window.timers == 0 and JobOperator.running is None


def test_generating_is_one_step_of_undo():
    assert DUALCOLOR_OT_generate.bl_options == {"UNDO"}


def test_a_job_that_writes_a_file_runs_beside_the_work_and_ends_by_esc():
    class Exporting(Pretended, FileJob):
        _in_window = True

    assert Exporting.execute is FileJob.execute
    job, window = Exporting(), Window()
    job.cancel(window)  # the file browser is left
    assert job.execute(window) == {"RUNNING_MODAL"} and JobOperator.running.job is job
    assert job.modal(window, SimpleNamespace(type="TIMER")) == {"RUNNING_MODAL"}
    assert job.modal(window, SimpleNamespace(type="ESC")) == {"CANCELLED"}
    assert job.written == [] and JobOperator.running is None and window.timers == 0


@pytest.mark.parametrize(
    ("former", "same", "proposed"),
    [
        ("", True, "Cow_1.gcode"),
        ("/home/me/prints/first try.gcode", True, "/home/me/prints/first try.gcode"),
        ("/home/me/prints/pig.gcode", False, "/home/me/prints/Cow_1.gcode"),
    ],
)
def test_a_file_is_not_proposed_for_another_object(former, same, proposed):
    assert proposed_path(former, "Cow/1", ".gcode", same) == proposed


@pytest.mark.parametrize("exporting", [DUALCOLOR_OT_export_gcode, DUALCOLOR_OT_export_settings])
def test_a_file_browser_that_is_left_changes_nothing(registered, monkeypatch, exporting):
    """Blender keeps the properties of operators that have finished, and begins the next one with them."""
    monkeypatch.setattr(ExportHelper, "invoke", lambda *_: {"RUNNING_MODAL"})
    suffix = exporting.filename_ext
    assert "named_for" in getattr(bpy.ops.dualcolor, exporting.bl_idname[10:]).get_rna_type().properties
    kept = {"filepath": "", "named_for": ""}

    def asked(name, finished):
        context = SimpleNamespace(object=bpy.data.objects.get(name) or bpy.data.objects.new(name, None))
        begun = SimpleNamespace(**kept, filename_ext=suffix)
        exporting.invoke(begun, context, None)
        if finished:
            kept.update(filepath=begun.filepath, named_for=begun.named_for)
        return begun.filepath

    assert asked("Cow", finished=True) == f"Cow{suffix}"
    assert [asked("Pig", finished=False), asked("Pig", finished=True)] == [f"Pig{suffix}"] * 2
    assert asked("Cow", finished=False) == f"Cow{suffix}"
