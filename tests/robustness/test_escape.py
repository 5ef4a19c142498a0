"""Esc at any moment of any job, and a kill that asks nobody: nothing that was there is touched."""

import os
import signal
import subprocess
import sys
from types import SimpleNamespace

import pytest

from launcher import ROOT

JOBS = ("generate", "export_gcode", "export_x3g", "analyze", "suggest_orientation", "check_model", "select_finding",
        "bake_occlusion", "unwrap_xatlas")  # fmt: skip


def operators():
    """The classes of all operators whose job can be stopped, by their names."""
    from dualcolor.operators.job import JobOperator

    classes, found = [JobOperator], {}
    for one in classes:
        classes += one.__subclasses__()
        if one.__module__.startswith("dualcolor.operators") and one.bl_idname:
            found[one.bl_idname.removeprefix("dualcolor.")] = one
    return found


def everything(obj, folder):
    """What there is in the scene and in the folder, as far as a job might change it."""
    import bpy

    kinds = [name for name in dir(bpy.data) if isinstance(getattr(bpy.data, name), bpy.types.bpy_prop_collection)]
    names = {name: sorted(held.name for held in getattr(bpy.data, name)) for name in kinds}
    mesh = [tuple(vertex.co) for vertex in obj.data.vertices], [layer.name for layer in obj.data.attributes]
    kept = {key: str(value) for key, value in obj.items()}, obj.dualcolor.report, obj.dualcolor.findings
    selected = [each.name for each in bpy.context.selected_objects], bpy.context.object.mode
    return names, mesh, kept, obj.matrix_world.copy().freeze(), selected, sorted(os.listdir(folder))


def test_jobs_are_those_of_operators(block):
    assert set(JOBS) <= set(operators())


@pytest.mark.parametrize("name", JOBS)
def test_escape_after_any_step_changes_nothing(block, tmp_path, name):
    import bpy

    if name == "unwrap_xatlas":
        pytest.importorskip("xatlas")
    made = getattr(bpy.ops.dualcolor, name).get_rna_type().properties
    given = {each.identifier: getattr(each, "default", None) for each in made if each.identifier != "rna_type"}
    given["filepath"] = str(tmp_path / f"out.{name[-5:]}")
    operator = operators()[name]
    before, steps, done = everything(block, tmp_path), 0, False
    while not done:
        asked = SimpleNamespace(report=lambda *_: None, **({"kind": getattr(operator, "kind", "")} | given))
        job = operator.steps(asked, bpy.context)
        done = any(next(job, None) is None for _ in range(steps))
        if not done:
            job.close()
            assert everything(block, tmp_path) == before, steps
        steps += 1 + steps // 5
    assert steps > 1


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signals")
def test_a_kill_leaves_the_former_file(tmp_path):
    """Whatever is left over has another name."""
    script = (
        f"import sys; sys.path.insert(0, {str(ROOT)!r})\n"
        "from launcher import load_package; load_package()\n"
        "from pathlib import Path; from time import sleep\n"
        "from dualcolor.core.files import OutputFiles\n"
        "with OutputFiles({'gcode': Path('a.gcode'), 'x3g': Path('b.x3g')}) as files:\n"
        "    for kind in files.paths: files.staged(kind).write_text('half')\n"
        "    print('now', flush=True); sleep(60)\n"
    )
    (tmp_path / "a.gcode").write_text("kept")
    command = [sys.executable, "-c", script]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, text=True) as job:
        assert job.stdout.readline() == "now\n"
        job.send_signal(signal.SIGKILL)
        job.wait(30)
    assert (tmp_path / "a.gcode").read_text() == "kept" and not (tmp_path / "b.x3g").exists()
