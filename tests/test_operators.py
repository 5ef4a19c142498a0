"""The user's actions, run as scripts run them, and the traces that the extension leaves."""

import struct
from types import SimpleNamespace

import numpy as np
import pytest
from sample_print import square_print

bpy = pytest.importorskip("bpy")

import dualcolor  # noqa: E402
from dualcolor.bridge import results  # noqa: E402
from dualcolor.bridge.curves import build_preview, preview_of, read_strands  # noqa: E402
from dualcolor.bridge.properties import report_of  # noqa: E402
from dualcolor.bridge.render import render_prediction  # noqa: E402
from dualcolor.bridge.studio import camera_axes, camera_place  # noqa: E402
from dualcolor.bridge.units import use_millimetres  # noqa: E402
from dualcolor.core.errors import OutputError, PrintError  # noqa: E402
from dualcolor.operators.generate import DUALCOLOR_OT_generate  # noqa: E402
from dualcolor.operators.job import JobOperator, stop_job  # noqa: E402
from dualcolor.panels.paint import hints  # noqa: E402
from dualcolor.panels.results import duration, figures  # noqa: E402
from dualcolor.panels.rows import wrapped  # noqa: E402

DATA_KINDS = ("scenes", "collections", "objects", "hair_curves", "meshes", "cameras", "lights", "worlds", "materials")


def traces() -> set[str]:
    """Everything of the extension's that Blender knows of."""
    names = {name for name in dir(bpy.types) if "DUALCOLOR" in name.upper()}
    names |= {f"ops.dualcolor.{name}" for name in dir(bpy.ops.dualcolor)}
    names |= {"Object.dualcolor"} if hasattr(bpy.types.Object, "dualcolor") else set()
    names_of_menus = ("TOPBAR_MT_file_export", "TOPBAR_MT_file_import", "VIEW3D_MT_add", "VIEW3D_MT_object")
    menus = [getattr(bpy.types, name) for name in (*names_of_menus, "IMAGE_MT_image")]
    entries = [entry for menu in menus for entry in menu._dyn_ui_initialize()]
    entries += [*bpy.app.handlers.load_pre, *bpy.app.handlers.depsgraph_update_post]
    return names | {str(entry) for entry in entries if entry.__module__.startswith("dualcolor")}


def datablocks() -> dict[str, list[str]]:
    return {kind: sorted(held.name for held in getattr(bpy.data, kind)) for kind in DATA_KINDS}


@pytest.fixture
def registered(scene):
    dualcolor.register()
    yield scene
    dualcolor.unregister()


@pytest.fixture
def block(registered):
    """The active object: a 12 mm block, 3 mm high."""
    use_millimetres(registered)
    bpy.ops.mesh.primitive_cube_add(size=12, location=(40, 30, 20))
    made = bpy.context.object
    made.scale.z = 0.25
    bpy.context.view_layer.update()
    return made


def test_registering_twice_leaves_no_trace_after_unregistering():
    before = traces()
    for _ in range(2):
        dualcolor.register()
        assert traces() - before
        dualcolor.unregister()
        assert traces() == before


def test_without_a_mesh_nothing_can_be_pressed(registered):
    assert not bpy.ops.dualcolor.generate.poll()
    assert not bpy.ops.dualcolor.export_gcode.poll()
    assert not bpy.ops.dualcolor.render_prediction.poll()
    with pytest.raises(RuntimeError, match="Select a mesh object first"):
        bpy.ops.dualcolor.generate()


def test_generate_makes_strands_and_a_report(block):
    assert not bpy.ops.dualcolor.render_prediction.poll()
    assert bpy.ops.dualcolor.generate() == {"FINISHED"}
    report = report_of(block.dualcolor)
    assert report["layers"] == 12 and report["tool_changes"] == 11
    shown = preview_of(block).objects
    layers = {(held.data.materials[0].name, *set(read_strands(held)[3]["layer"] % 2)) for held in shown}
    assert layers == {("Black ABS", 0), ("White ABS", 1)}
    assert bpy.ops.dualcolor.render_prediction.poll()
    assert block.dualcolor.show_print
    block.dualcolor.show_print = False
    assert block.display_type == "TEXTURED"


def test_an_active_strand_stands_for_its_source(block):
    bpy.ops.dualcolor.generate()
    first = report_of(block.dualcolor)
    bpy.context.view_layer.objects.active = preview_of(block).objects[0]
    block.dualcolor.layer_height = 0.5
    assert bpy.ops.dualcolor.generate() == {"FINISHED"}
    assert report_of(block.dualcolor)["layers"] < first["layers"]
    assert len(bpy.data.collections) == 1


def test_strands_are_seen_in_a_view_of_the_object_alone(registered):
    bpy.ops.wm.read_homefile(use_factory_startup=True)  # with its 3D view
    use_millimetres(bpy.context.scene)
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    region = next(region for region in area.regions if region.type == "WINDOW")
    block, space = bpy.context.object, area.spaces.active
    block.scale, block.dualcolor.perimeters, block.dualcolor.infill_density = (6, 6, 2), 1, 0
    with bpy.context.temp_override(window=window, area=area, region=region):
        bpy.ops.view3d.localview(frame_selected=False)
        if not block.local_view_get(space):
            pytest.skip("this Blender has no such views in background")
        bpy.ops.dualcolor.generate()
        assert all(shown.local_view_get(space) for shown in preview_of(block).objects)
        assert not bpy.data.objects["Light"].local_view_get(space)
        bpy.ops.view3d.localview(frame_selected=False)


def test_a_print_made_again_from_its_strands_makes_the_object_active(block):
    block.dualcolor.perimeters, block.dualcolor.infill_density = 1, 0
    bpy.ops.dualcolor.generate()
    bpy.context.view_layer.objects.active = preview_of(block).objects[0]
    assert not bpy.ops.dualcolor.check_model.poll()
    with pytest.raises(RuntimeError, match="Select Cube, whose strands these are, first"):
        bpy.ops.dualcolor.check_model()
    assert hints(block, bpy.context.object) == ["Strands are selected: select Cube for the buttons that are grey"]
    bpy.ops.dualcolor.generate()
    assert bpy.context.view_layer.objects.active == block and block.select_get()
    assert bpy.ops.dualcolor.check_model.poll()


def test_the_last_message_tells_that_there_are_warnings(block, tmp_path, capfd):
    block.dualcolor.perimeters, block.dualcolor.infill_density = 1, 0
    bpy.ops.dualcolor.generate()
    bpy.ops.dualcolor.export_gcode(filepath=str(tmp_path / "block.gcode"))
    assert len(report_of(block.dualcolor)["warnings"]) == 1  # it has no picture
    said = [line for line in capfd.readouterr().out.splitlines() if "see the results" in line]
    assert [line.split(":")[:2] for line in said] == [["Warning", " Cube"], ["Info", " block.gcode"]]


def test_a_copy_of_a_printed_object_and_one_whose_strands_were_deleted_look_as_before(block):
    block.dualcolor.perimeters, block.dualcolor.infill_density = 1, 0
    bpy.ops.dualcolor.generate()
    copy = block.copy()
    bpy.context.scene.collection.objects.link(copy)
    assert copy.display_type == "BOUNDS"
    bpy.context.view_layer.update()
    assert copy.display_type == "TEXTURED" and not copy.hide_render
    assert block.display_type == "BOUNDS" and block.hide_render

    for shown in list(preview_of(block).objects):
        bpy.data.objects.remove(shown)
    bpy.context.view_layer.update()
    assert block.display_type == "TEXTURED" and not block.hide_render and not block.dualcolor.show_print
    block.dualcolor.show_print = True
    assert block.display_type == "TEXTURED", "there is nothing to be shown instead"


def test_an_error_is_reported_and_nothing_is_made(block):
    block.dualcolor.wave_depth_min, block.dualcolor.wave_depth_max = 0.5, 0.4
    before = datablocks()
    with pytest.raises(RuntimeError, match="wave_depth_min"):
        bpy.ops.dualcolor.generate()
    assert datablocks() == before and block.dualcolor.report == ""


def test_an_error_keeps_the_former_print(block):
    bpy.ops.dualcolor.generate()
    before, report = datablocks(), block.dualcolor.report
    block.scale *= 100
    with pytest.raises(RuntimeError):
        bpy.ops.dualcolor.generate()
    assert datablocks() == before and block.dualcolor.report == report


def test_export_writes_what_was_generated_and_makes_it_anew_if_the_object_changed(block, tmp_path, monkeypatch):
    runs = []
    import dualcolor.operators.generate as generate

    original = generate.steps
    monkeypatch.setattr(generate, "steps", lambda *args: (runs.append(1), original(*args))[1])
    bpy.ops.dualcolor.generate()
    bpy.ops.dualcolor.export_gcode(filepath=str(tmp_path / "a.gcode"))
    assert len(runs) == 1
    assert report_of(block.dualcolor)["gcode"]["bytes"] == (tmp_path / "a.gcode").stat().st_size
    block.data.vertices[0].co.z -= 0.5
    bpy.context.view_layer.update()
    bpy.ops.dualcolor.export_gcode(filepath=str(tmp_path / "b.gcode"))
    assert len(runs) == 2
    results.forget_all()
    bpy.ops.dualcolor.export_gcode(filepath=str(tmp_path / "c.gcode"))
    assert len(runs) == 3
    assert (tmp_path / "c.gcode").read_bytes() == (tmp_path / "b.gcode").read_bytes()
    assert (tmp_path / "a.gcode").read_bytes() != (tmp_path / "b.gcode").read_bytes()


def test_a_gcode_file_that_cannot_be_written_is_an_error(block, tmp_path):
    with pytest.raises(RuntimeError, match="cannot be written"):
        bpy.ops.dualcolor.export_gcode(filepath=str(tmp_path / "missing" / "a.gcode"))


class Window:
    """Stands in for a window manager and its window, which a background Blender has not."""

    def __init__(self):
        self.windows, self.window, self.workspace, self.window_manager = [], None, self, self
        self.timers, self.status = 0, None

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
        self.written, self.reports, self.problem = [], [], problem

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
        assert job.reports == [("ERROR", "no UVs")]
    else:
        with pytest.raises(ZeroDivisionError):
            job.modal(window, SimpleNamespace(type="TIMER"))
    assert window.timers == 0 and JobOperator.running is None


def test_generating_is_one_step_of_undo():
    assert DUALCOLOR_OT_generate.bl_options == {"UNDO"}


def png_size(path):
    return struct.unpack(">II", path.read_bytes()[16:24])


def test_a_render_leaves_the_scene_as_it_was(scene, tmp_path):
    collection = build_preview(square_print())
    scene.render.engine, scene.render.filepath = "BLENDER_WORKBENCH", "//kept"
    before, images = datablocks(), set(bpy.data.images)
    render_prediction(collection, tmp_path / "a.png", (48, 40), samples=4)
    assert png_size(tmp_path / "a.png") == (48, 40)
    assert datablocks() == before and set(bpy.data.images) == images
    assert bpy.context.scene == scene and scene.camera is None and scene.world is None
    assert (scene.render.engine, scene.render.filepath) == ("BLENDER_WORKBENCH", "//kept")
    assert [found.name for found in tmp_path.iterdir()] == ["a.png"]


def test_the_picture_shows_the_object_and_not_the_tower(scene, tmp_path):
    collection = build_preview(square_print())
    tones = {}
    for whole in (False, True):
        path = tmp_path / f"{whole}.png"
        render_prediction(collection, path, (48, 48), samples=4, whole_plate=whole)
        picture = bpy.data.images.load(str(path))
        tones[whole] = np.array(picture.pixels[:]).reshape(48, 48, 4)[..., 0]
    # Between the black and white lines of the block the picture varies; a plate with a tower shows the block smaller.
    assert tones[False][14:34, 10:38].std() > 0.05
    assert abs(tones[True] - tones[False]).mean() > 0.02


def test_no_strands_and_no_folder_are_errors(scene, tmp_path):
    empty = bpy.data.collections.new("Empty")
    before = datablocks()
    with pytest.raises(PrintError, match="no strands"):
        render_prediction(empty, tmp_path / "a.png")
    with pytest.raises(OutputError):
        render_prediction(empty, tmp_path / "missing" / "a.png")
    assert datablocks() == before


@pytest.mark.parametrize("azimuth", [-0.5, 2.0])
def test_the_camera_sees_all_points_and_no_closer_place_does(azimuth):
    points = np.random.default_rng(3).normal(size=(200, 3)) * (5, 2, 9)
    axes = camera_axes(azimuth, 0.3)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    place = camera_place(points, axes, 0.2, 0.15)
    seen = (points - place) @ axes.T
    share = np.abs(seen[:, :2] / -seen[:, 2:]) / (0.2, 0.15)
    assert share.max() == pytest.approx(1.0)
    assert (seen[:, 2] < 0).all()


def test_the_results_in_the_sidebar():
    report = {
        "bounds_mm": [[-5, -5, 0], [5, 5, 2]],
        "layers": 1408,
        "settings": {"black_tool": 1},
        "time_s": {"total": 3900.0},
        "filament": {"tool0_mm": 1500.0, "tool0_g": 3.75, "tool1_mm": 2500.0, "tool1_g": 6.25},
    }
    assert figures(report) == [
        ("Size", "10.0 × 10.0 × 2.0 mm"),
        ("Layers", "1,408"),
        ("Time", "1 h 05 min"),
        ("White (right)", "1.50 m, 3.8 g"),
        ("Black (left)", "2.50 m, 6.2 g"),
    ]
    report["solid_regions"] = {"regions": 3, "tool_changes": 1, "outline_time_s": -12.0, "tool_change_time_s": 120.0}
    assert figures(report)[-1] == ("Solid Regions", "3: +1 tool changes, +1.8 min")
    assert duration(59 * 60) == "59 min"
    assert all(len(line) <= 34 for line in wrapped("thin walls " * 20, 280, 1.0))
