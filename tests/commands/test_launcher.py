"""The launcher: standard streams that are closed or full, and signals while Blender starts."""

import os
import signal
import subprocess
import sys
import time

import bpy
import pytest

from launcher import ROOT

pytestmark = pytest.mark.skipif(
    os.name != "posix" or bool(bpy.app.binary_path), reason="a shell and a Python of our own are needed"
)
BOX = "v 0 0 0\nv 20 0 0\nv 20 0 20\nv 0 0 20\nv 0 20 0\nv 20 20 0\nv 20 20 20\nv 0 20 20\n"
BOX += "f 5 6 7 8\nf 1 4 3 2\nf 2 3 7 6\nf 3 4 8 7\nf 1 5 8 4\nf 1 2 6 5\n"


def shell(folder, redirection):
    """A print whose streams a shell sets up; its status, and what came out at stderr where that is open."""
    (folder / "box.obj").write_text(BOX)
    command = f"exec {ROOT / 'dualcolor'} print box.obj --set layer_height=0.5 --gcode box.gcode {redirection}"
    environment = {**os.environ, "DUALCOLOR_PYTHON": sys.executable}
    run = subprocess.run(command, shell=True, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    return run.returncode, run.stderr


@pytest.mark.parametrize("closed", [">&-", "2>&-", "<&- >&- 2>&-"])
def test_a_print_needs_no_terminal(tmp_path, closed):
    assert shell(tmp_path, closed) == (0, "")
    gcode = (tmp_path / "box.gcode").read_text()
    assert "; object = box" in gcode and gcode.endswith("\n")  # nothing has been written among it


def test_a_terminal_without_unicode_shows_question_marks(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONIOENCODING", "ascii")
    assert shell(tmp_path, "> out.txt") == (0, "")
    assert "box: 20.0 ? 20.0 ? 20.0 mm" in (tmp_path / "out.txt").read_text()


def test_what_nobody_reads_is_no_failure_but_a_full_disk_is():
    read, write = os.pipe()
    os.close(read)
    show = f"import sys; sys.path.insert(0, {str(ROOT)!r}); import launcher; launcher.load_package()\n"
    show += "from dualcolor.cli import _say; sys.exit(_say(['done']))"
    command = [sys.executable, "-c", show]
    run = subprocess.run(command, stdout=write, stderr=subprocess.PIPE, text=True, check=False)
    os.close(write)
    assert (run.returncode, run.stderr) == (0, "")
    with open("/dev/full", "w") as full:
        run = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert run.returncode == 1
    assert run.stderr == "error: the result cannot be shown: No space left on device\n"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_while_blender_starts_ends_the_program_without_a_word(number):
    show = f"import sys; sys.path.insert(0, {str(ROOT)!r}); import launcher; launcher.load_package()\n"
    show += "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    show += "from dualcolor.core.files import ended_by_signals; from dualcolor.commands.terminal import load_blender\n"
    show += "with ended_by_signals():\n    print('now', flush=True); load_blender()\n    print('loaded')\n"
    command = [sys.executable, "-c", show]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as job:
        assert job.stdout.readline() == "now\n"
        time.sleep(0.15)  # it takes a second
        job.send_signal(number)
        out, err = job.communicate(timeout=60)
    assert (job.returncode, out, err) == (-number, "", "")
