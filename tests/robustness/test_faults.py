"""Full disks, kills, Esc, lost pictures and objects: nothing that was there is lost, nothing half made stays."""

import gc
import os
import signal
import subprocess
import sys
import weakref
from dataclasses import fields
from types import SimpleNamespace

import numpy as np
import pytest
from dualcolor.core.errors import OutputError, PrintError
from dualcolor.core.exports import export_gcode
from dualcolor.core.files import OutputFiles, ended_by_signals
from dualcolor.core.pipeline import generate, steps
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.solids import box, cylinder, picture

from launcher import ROOT

BOX = "".join(f"v {x} {z} {-y}\n" for z in (0, 2) for x, y in ((0, 0), (9, 0), (9, 9), (0, 9)))
BOX += "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"
LIMITED = """
import resource, signal, sys
sys.path.insert(0, {root!r})
from launcher import load_package
load_package()
from dualcolor.cli import main
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
outputs = {outputs!r}
for flag, name in outputs:
    resource.setrlimit(resource.RLIMIT_FSIZE, (2000, resource.RLIM_INFINITY))
    status = main(["print", "box.obj", flag, name])
    resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    assert status == 1, (flag, status)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="limits of file sizes are of Unix")
def test_a_full_disk_leaves_what_was_there(tmp_path):
    if pytest.importorskip("bpy").app.binary_path:
        pytest.skip("inside Blender there is no Python of our own to launch")
    outputs = [("--gcode", "a.gcode"), ("--x3g", "a.x3g"), ("--report", "a.json"), ("--save-settings", "s.json"),
               ("--dump", "d.npz"), ("--blend", "b.blend"), ("--mesh", "m.stl"), ("--mesh", "m.obj")]  # fmt: skip
    (tmp_path / "box.obj").write_text(BOX)
    for _, name in outputs:
        (tmp_path / name).write_text("kept")
    script = LIMITED.format(root=str(ROOT), outputs=outputs)
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True)
    errors = [line for line in done.stderr.splitlines() if line.startswith("error: ")]
    assert done.returncode == 0, done.stderr
    assert len(errors) == len(outputs) and "Traceback" not in done.stderr
    for line, (_, name) in zip(errors, outputs, strict=True):
        assert f"{name} cannot be written" in line and ".part" not in line
    names = {name for _, name in outputs}
    assert set(os.listdir(tmp_path)) == names | {"box.obj"}
    assert {(tmp_path / name).read_text() for name in names} == {"kept"}


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signals")
@pytest.mark.parametrize("number", ["SIGTERM", "SIGHUP", "SIGINT"])
def test_a_killed_job_tidies_up(tmp_path, number):
    script = (
        f"import sys; sys.path.insert(0, {str(ROOT)!r})\n"
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)  # a job of a shell may ignore it,\n"
        "signal.signal(signal.SIGHUP, signal.SIG_DFL)  # and one of nohup this one\n"
        "from launcher import load_package; load_package()\n"
        "from pathlib import Path; from time import sleep\n"
        "from dualcolor.core.files import OutputFiles, ended_by_signals\n"
        "with ended_by_signals(), OutputFiles({'gcode': Path('a.gcode')}) as files:\n"
        "    files.staged('gcode').write_text('half'); print('now', flush=True)\n"
        "    for _ in range(600): sleep(0.1)  # a signal just ahead of one long sleep would wait for its end\n"
    )
    (tmp_path / "a.gcode").write_text("kept")
    with subprocess.Popen(
        [sys.executable, "-c", script], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as job:
        assert job.stdout.readline() == "now\n"
        assert any(".part" in name for name in os.listdir(tmp_path))
        job.send_signal(getattr(signal, number))
        assert job.wait(30) != 0
    assert os.listdir(tmp_path) == ["a.gcode"] and (tmp_path / "a.gcode").read_text() == "kept"


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signal")
def test_a_job_that_was_told_to_outlive_its_terminal_does():
    former = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup does
    try:
        with ended_by_signals():
            signal.raise_signal(signal.SIGHUP)
            assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, former)


@pytest.mark.parametrize(
    "problem", [OSError(28, "No space left on device"), OutputError("PART cannot be written", "x")]
)
def test_an_output_that_fails_is_named_as_the_user_did(tmp_path, problem):
    path = tmp_path / "a.json"
    path.write_text("kept")
    with pytest.raises(OutputError) as failed, OutputFiles({"report": path}) as files:
        part = files.staged("report")
        part.write_text("half")
        if isinstance(problem, OSError):
            problem.filename = str(part)
        else:
            problem.message = problem.message.replace("PART", str(part))
        raise problem
    assert failed.value.message == f"{path} cannot be written"
    assert os.listdir(tmp_path) == ["a.json"] and path.read_text() == "kept"


def test_a_job_that_is_stopped_after_any_step_returns_its_memory():
    number = 0
    while True:
        mesh = cylinder(6, 3, textures=(picture(np.random.default_rng(1).random((64, 64))),))
        held = weakref.ref(mesh)
        job = steps(mesh, PrintSettings())
        done = False
        for _ in range(number):
            done = next(job, None) is None
        job.close()
        del job, mesh
        gc.collect()
        assert held() is None
        if done:
            break
        number += 1
    assert number > 10


def limits():
    """Each setting at its lowest, its highest, and each of its choices."""
    found = []
    for declared in fields(PrintSettings):
        about = declared.metadata
        values = about["choices"] or [value for value in (about["low"], about["high"]) if value is not None]
        if isinstance(declared.default, bool):
            values = [not declared.default]
        kind = type(declared.default)
        for value in values:
            if value != declared.default:
                found.append(pytest.param(declared.name, kind(value), id=f"{declared.name}={value}"))
    return found


@pytest.mark.parametrize(("name", "value"), limits())
def test_settings_at_their_limits_print_or_are_refused(name, value, tmp_path):
    model = box((0, 0, 0), (6, 6, 1.2))
    try:
        result = export_gcode(generate(model, PrintSettings().changed({name: value})), tmp_path / "a.gcode")
    except PrintError as problem:
        assert problem.message and "\n" not in str(problem)
        assert not (tmp_path / "a.gcode").exists()
    else:
        assert np.isfinite(result.moves.position).all() and result.report["gcode"]["bytes"] > 1000


def test_a_picture_that_is_deleted_or_replaced_between_clicks(block):
    import bpy

    assert bpy.ops.dualcolor.generate() == {"FINISHED"}
    bpy.data.images.remove(block.dualcolor.image)
    assert bpy.ops.dualcolor.generate() == {"FINISHED"}
    block.dualcolor.image = bpy.data.images.new("other", 4, 4, float_buffer=True)
    assert bpy.ops.dualcolor.generate() == {"FINISHED"}
    block.dualcolor.image.source = "FILE"
    block.dualcolor.image.filepath = "/nowhere/picture.png"
    before = block.dualcolor.report
    with pytest.raises(RuntimeError, match="has no pixels"):
        bpy.ops.dualcolor.generate()
    assert block.dualcolor.report == before


def test_the_object_is_deleted_at_any_step(block):
    """The window is alive between the steps: what is worked on may vanish."""
    import bpy
    from dualcolor.operators.generate import printed

    obj, number = block, 1
    while True:
        job, done = printed(bpy.context, reuse=False), False
        for _ in range(number):
            done = next(job, None) is None
        if done:
            break
        bpy.data.objects.remove(obj)
        with pytest.raises(PrintError, match="deleted"):
            list(job)
        assert not [held for held in bpy.data.collections if "print" in held.name.lower()]
        bpy.ops.mesh.primitive_cube_add(size=8)
        obj = bpy.context.object
        obj.scale.z = 0.2
        bpy.context.view_layer.update()
        number += 4
    assert number > 4


def test_two_generations_in_a_row_leave_one_print(block):
    import bpy

    counts = []
    for _ in range(2):
        assert bpy.ops.dualcolor.generate() == {"FINISHED"}
        kinds = ("collections", "objects", "hair_curves", "materials")
        counts.append([len(getattr(bpy.data, kind)) for kind in kinds])
    assert counts[0] == counts[1]


def test_a_second_job_waits_for_the_first(block):
    from dualcolor.operators.job import JobOperator, RunningJob

    JobOperator.running = RunningJob(0.5, "fill", None)
    try:
        said = []
        asked = SimpleNamespace(report=lambda _kind, text: said.append(text))
        assert JobOperator.invoke(asked, SimpleNamespace(window_manager=None), None) == {"CANCELLED"}
        assert "running (fill)" in said[0]
    finally:
        JobOperator.running = None
