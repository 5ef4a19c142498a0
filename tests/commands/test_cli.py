"""The command line: exit statuses, one-line errors, and nothing written unless all is well."""

import json
import os
import subprocess
import sys

import bpy
import numpy as np
import pytest
from dualcolor import cli
from dualcolor.core.errors import OutputError
from dualcolor.core.files import OutputFiles
from dualcolor.tests.gpx import convert
from dualcolor.tests.scene import add_box, fresh
from PIL import Image

from launcher import ROOT

OPEN_BOX = "v 0 0 0\nv 20 0 0\nv 20 0 20\nv 0 0 20\nv 0 20 0\nv 20 20 0\nv 20 20 20\nv 0 20 20\n"
OPEN_BOX += "f 5 6 7 8\nf 1 4 3 2\nf 2 3 7 6\nf 3 4 8 7\nf 1 5 8 4\n"
SIDE = "f 1 2 6 5\n"
FAST = ["--set", "layer_height=0.5", "--set", "first_layer_height=0.5"]


@pytest.fixture
def box(tmp_path):
    """A cube of 20 mm without UVs, y up."""
    path = tmp_path / "box.obj"
    path.write_text(OPEN_BOX + SIDE)
    return path


@pytest.fixture
def refused(tmp_path, capfd):
    """Run a command that has to fail by the user's fault; returns the one line it says."""

    def run(*arguments):
        before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
        capfd.readouterr()
        status = cli.main([str(argument) for argument in arguments])
        out, err = capfd.readouterr()
        after = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
        assert status == 1 and out == ""
        lines = err.splitlines()
        assert len(lines) == 1 and lines[0].startswith("error: ") and "Traceback" not in err
        assert after == before
        return lines[0]

    return run


def test_a_print_writes_all_that_was_asked_for(box, tmp_path, capfd):
    suffixes = {"gcode": ".gcode", "blend": ".blend", "report": ".json", "dump": ".npz"}
    outputs = {kind: tmp_path / f"box{suffix}" for kind, suffix in suffixes.items()}
    arguments = [text for kind, path in outputs.items() for text in (f"--{kind}", str(path))]
    assert cli.main(["print", str(box), *FAST, *arguments]) == 0
    out, err = capfd.readouterr()
    assert err == ""
    first, *others = out[out.index("box: ") :].splitlines()  # inside Blender, its own greeting may come before
    assert first == "box: 20.0 × 20.0 × 20.0 mm, 40 layers, 39 tool changes"
    assert all(line.startswith(("print time", "filament: ", "wrote", "warning:")) for line in others)
    assert all(f"wrote {path}" in out for path in outputs.values())
    assert {path.name for path in tmp_path.iterdir()} == {"box.obj", *(path.name for path in outputs.values())}
    report = json.loads(outputs["report"].read_text())
    assert report["layers"] == 40 and report["tool_changes"] == 39
    assert report["settings"]["layer_height"] == 0.5
    assert report["gcode"]["bytes"] == outputs["gcode"].stat().st_size
    np.testing.assert_allclose(report["bounds_mm"], [[-10, -10, 0], [10, 10, 20]], atol=1e-4)
    with np.load(outputs["dump"]) as dump:
        assert set(dump.files) >= {"layer_z", "loop_layer", "loop_start", "base_xy", "wave_xy", "phase", "depth"}
        assert set(dump.files) >= {"tone", "uv"}
    bpy.ops.wm.open_mainfile(filepath=str(outputs["blend"]))
    assert "box Dual-Color" in bpy.data.collections and "box" in bpy.data.objects
    assert convert(outputs["gcode"]) == []


def test_same_command_same_bytes(box, tmp_path, capfd):
    for name in ("a.gcode", "b.gcode"):
        assert cli.main(["print", str(box), *FAST, "--gcode", str(tmp_path / name)]) == 0
    assert _without_time((tmp_path / "a.gcode").read_text()) == _without_time((tmp_path / "b.gcode").read_text())


def _without_time(text):
    return [line for line in text.splitlines() if not line.startswith(";")]


def test_texture_and_unwrap_give_tones(box, tmp_path, capfd):
    image = bpy.data.images.new("white", 8, 8)
    image.pixels.foreach_set(np.ones(8 * 8 * 4, dtype=np.float32))
    image.filepath_raw, image.file_format = str(tmp_path / "white.png"), "PNG"
    image.save()
    dump = tmp_path / "box.npz"
    command = ["print", str(box), *FAST, "--texture", str(tmp_path / "white.png"), "--dump", str(dump)]
    assert cli.main([*command, "--unwrap", "smart"]) == 0
    with np.load(dump) as arrays:
        np.testing.assert_allclose(arrays["tone"], 1.0, atol=1e-3)


@pytest.mark.parametrize("height", [[], ["--height-mm", "36"]])
def test_suggested_orientations_can_be_printed(tmp_path, capfd, height):
    """A wedge: the options that `analyse` gives turn it into what was promised."""
    wedge = tmp_path / "wedge.obj"
    wedge.write_text("v 0 0 0\nv 30 0 0\nv 0 0 18\nv 0 24 0\nv 30 24 0\nv 0 24 18\n"
                     "f 1 3 2\nf 4 5 6\nf 1 2 5 4\nf 2 3 6 5\nf 3 1 4 6\n")  # fmt: skip
    assert cli.main(["analyse", str(wedge), "--up", "z", *FAST, "--rotate-z", "20", *height]) == 0
    found = [line for line in capfd.readouterr().out.splitlines() if line.startswith("orientation ")]
    assert sum(line.endswith(": as it stands") for line in found) <= 1 and len(found) == 3
    turned = [line for line in found if "--rotate" in line]
    assert turned and all(("--height-mm" in line) == bool(height) for line in turned)
    for line in turned:
        promised = float(line.split(" to support, ")[1].split(" mm high")[0])
        command = ["print", str(wedge), "--up", "z", *FAST, *line.split(": ")[-1].split()]
        assert cli.main(command) == 0
        size = next(text for text in capfd.readouterr().out.splitlines() if text.startswith("wedge: "))
        assert abs(float(size.split(" × ")[2].split(" mm")[0]) - promised) <= 0.5  # it is told in whole millimeters


def test_models_are_turned_and_scaled(box, tmp_path, capfd):
    text = box.read_text().replace(" 20", " 10").replace("v 10 ", "v 30 ")  # 30 × 10 × 10 mm
    box.write_text(text)
    sizes = {
        (): "30.0 × 10.0 × 10.0 mm",
        ("--rotate-y", "90"): "10.0 × 10.0 × 30.0 mm",
        ("--rotate-z", "-90"): "10.0 × 30.0 × 10.0 mm",
        ("--rotate-y", "90", "--rotate-z", "45"): "14.1 × 14.1 × 30.0 mm",
        ("--rotate-x", "90", "--rotate-y", "90", "--height-mm", "60"): "20.0 × 20.0 × 60.0 mm",
        ("--scale", "1.5"): "45.0 × 15.0 × 15.0 mm",
    }
    for options, size in sizes.items():
        assert cli.main(["print", str(box), *FAST, *options]) == 0
        assert f"box: {size}" in capfd.readouterr().out


def test_settings_file_is_read_and_single_settings_win(box, tmp_path, capfd):
    (tmp_path / "settings.json").write_text('{"layer_height": 0.4, "first_layer_height": 0.5, "perimeters": 2}')
    report = tmp_path / "report.json"
    command = ["print", str(box), "--settings", str(tmp_path / "settings.json"), "--set", "layer_height = 0.5"]
    assert cli.main([*command, "--report", str(report)]) == 0
    settings = json.loads(report.read_text())["settings"]
    assert (settings["layer_height"], settings["first_layer_height"], settings["perimeters"]) == (0.5, 0.5, 2)


def test_bad_models_are_refused(tmp_path, refused):
    model, gcode = tmp_path / "model.obj", tmp_path / "out.gcode"
    assert "there is no file" in refused("print", model, "--gcode", gcode)
    model.write_text("# nothing")
    assert "there is no mesh" in refused("print", model, "--gcode", gcode)
    model.write_text(OPEN_BOX)
    assert "open" in refused("print", model, "--gcode", gcode)
    model.write_text((OPEN_BOX + SIDE).replace("20", "300"))
    assert "larger than" in refused("print", model, "--gcode", gcode)


def test_coordinates_that_are_no_numbers_are_refused(tmp_path, refused):
    fresh()
    add_box((20, 20, 20)).data.vertices[3].co.y = float("nan")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "box.blend"))
    assert "not finite" in refused("print", tmp_path / "box.blend", "--gcode", tmp_path / "out.gcode")
    assert "finite" in refused("print", tmp_path / "box.blend", "--height-mm", 10)


def test_bad_pictures_are_refused(box, tmp_path, refused):
    picture = tmp_path / "picture.png"
    assert "cannot be read" in refused("print", box, "--texture", picture)
    picture.write_text("no picture")
    assert "not an image" in refused("print", box, "--texture", picture)
    image = bpy.data.images.new("white", 8, 8)
    image.filepath_raw, image.file_format = str(picture), "PNG"
    image.save()
    assert "box has no UV map" in refused("print", box, "--texture", picture, "--report", tmp_path / "report.json")


def test_bad_settings_are_refused(box, tmp_path, refused):
    settings = tmp_path / "settings.json"
    assert "no setting named speed" in refused("print", box, "--set", "speed=1")
    assert "layer_height = 'thin' is not a number" in refused("print", box, "--set", "layer_height=thin")
    assert "outside" in refused("print", box, "--set", "layer_height=3")
    assert "cannot be read" in refused("print", box, "--settings", settings)
    settings.write_text("{")
    assert "is not JSON" in refused("print", box, "--settings", settings)
    settings.write_text("[1]")
    assert "holds no settings" in refused("print", box, "--settings", settings)


def test_unwritable_outputs_are_refused_before_the_work(box, tmp_path, refused, monkeypatch):
    monkeypatch.setattr("dualcolor.core.pipeline.generate", None)  # must not get that far
    report = tmp_path / "report.json"
    assert "there is no folder" in refused("print", box, "--report", report, "--gcode", tmp_path / "no" / "x.gcode")
    assert "it is a folder" in refused("print", box, "--report", report, "--gcode", tmp_path)
    assert "two outputs" in refused("print", box, "--report", report, "--gcode", report)
    assert "cannot be made: a file has that name" in refused("demo", "--out", box)
    assert "take, but not of what" in refused("analyse", box, "--views", "front")


@pytest.mark.parametrize("kind", ["--gcode", "--report", "--save-settings", "--mesh"])
def test_no_output_takes_the_place_of_a_file_that_is_read(box, tmp_path, refused, kind):
    assert "box.obj is read by this job and would be lost" in refused("print", box, *FAST, kind, box)
    link = tmp_path / "link.obj"
    link.hardlink_to(box)
    assert "would be lost" in refused("print", box, *FAST, kind, link)
    settings = tmp_path / "settings.json"
    settings.write_text("{}")
    assert "would be lost" in refused("print", box, "--settings", settings, "--report", settings)


def test_a_model_keeps_its_pictures_and_a_print_its_tone_table(box, tmp_path, refused):
    picture = bpy.data.images.new("spots", 4, 4)
    picture.filepath_raw, picture.file_format = str(tmp_path / "spots.png"), "PNG"
    picture.save()
    (tmp_path / "box.mtl").write_text("newmtl spots\nmap_Kd spots.png\n")
    box.write_text("mtllib box.mtl\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n" + OPEN_BOX.split("f ")[0] + "usemtl spots\n")
    with box.open("a") as file:
        for line in (OPEN_BOX + SIDE).splitlines():
            if line.startswith("f"):
                corners = " ".join(f"{corner}/{at}" for at, corner in enumerate(line.split()[1:], start=1))
                file.write(f"f {corners}\n")
    assert "spots.png is read by this job" in refused("print", box, *FAST, "--render", tmp_path / "spots.png")
    table = tmp_path / "table.json"
    table.write_bytes((ROOT / "presets/calibration/offset/set_back_fine.json").read_bytes())
    own = ["--set", "calibration=file", "--set", f"calibration_file={table}"]
    assert "table.json is read by this job" in refused("print", box, *FAST, *own, "--report", table)


@pytest.mark.parametrize(
    ("options", "places"),
    [
        ([], ["g black (tool 0, right nozzle)", "g white (tool 1, left nozzle)"]),
        (["--set", "black_tool=1"], ["g black (tool 1, left nozzle)", "g white (tool 0, right nozzle)"]),
        (["--preset", "marlin_dual"], ["g black (tool 0)", "g white (tool 1)"]),
    ],
)
def test_it_says_which_filament_goes_where(box, tmp_path, capfd, options, places):
    report = tmp_path / "box.json"
    assert cli.main(["print", str(box), *FAST, *options, "--report", str(report)]) == 0
    lines = capfd.readouterr().out.splitlines()
    found = json.loads(report.read_text())
    shown = next(line for line in lines if line.startswith("filament: "))
    for place in places:
        assert f"{found['filament'][f'tool{place[14]}_g']:.1f} {place}" in shown
    time, heating = found["time_s"]["total"] / 60, found["time_s"]["heating"] / 60
    assert f"print time {time:.0f} min after about {heating:.0f} min of heating" in lines


def test_pictures_are_as_large_as_wanted(box, tmp_path):
    files = [tmp_path / name for name in ("print.png", "read.png")]
    gcode = ["--gcode", str(tmp_path / "box.gcode")]
    assert cli.main(["print", str(box), *FAST, *gcode, "--render", str(files[0]), "--pixels", "104"]) == 0
    assert cli.main(["render", gcode[1], "--render", str(files[1]), "--pixels", "112"]) == 0
    assert [Image.open(file).size for file in files] == [(104, 104), (112, 112)]


def test_without_an_output_it_says_so(box, capfd):
    assert cli.main(["print", str(box), *FAST]) == 0
    assert "nothing is written: name the files" in capfd.readouterr().out
    assert cli.main(["tile", *FAST]) == 0
    assert "nothing is written: name the files" in capfd.readouterr().out


def test_the_version_is_that_of_the_extension(capfd):
    assert cli.main(["--version"]) == 0
    assert f'version = "{capfd.readouterr().out.split()[-1]}"' in (ROOT / "blender_manifest.toml").read_text()


def test_a_failure_while_writing_leaves_nothing(box, tmp_path, refused, monkeypatch):
    kept = tmp_path / "box.gcode"
    kept.write_text("former")

    def full(*_):
        raise OutputError("the disk is full")

    monkeypatch.setattr("dualcolor.core.exports.dump", full)
    command = ["print", box, *FAST, "--gcode", kept, "--dump", tmp_path / "box.npz"]
    assert refused(*command) == "error: the disk is full"


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["paint"],
        ["print"],
        ["print", "x.obj", "--up", "x"],
        ["print", "x.obj", "--height-mm", "0"],
        ["print", "x.obj", "--height-mm", "nan"],
        ["print", "x.obj", "--set", "layer_height"],
        ["print", "x.obj", "--unwrap", "magic"],
        ["print", "x.obj", "--blend", "x.png"],
        ["print", "x.obj", "--dump", "x"],
        ["print", "x.obj", "--gcode", "x.x3g"],
        ["print", "x.obj", "--x3g", "x.gcode"],
        ["plate", "x.png", "--samples", "1000000000"],
        ["analyse", "x.obj", "--pixels", "5"],
        ["print", "x.obj", "--rotate-x", "inf"],
        ["print", "x.obj", "--render", "x.png", "--pixels", "5000"],
        ["print", "x.obj", "--scale", "2", "--height-mm", "20"],
    ],
)
def test_wrong_usage_is_status_2(arguments, capfd):
    assert cli.main(arguments) == 2
    assert "usage:" in capfd.readouterr().err


@pytest.mark.parametrize("command", cli.COMMANDS)
def test_every_command_explains_itself(command, capfd):
    assert cli.main([command.NAME, "--help"]) == 0
    shown = " ".join(capfd.readouterr().out.split())
    assert f"{command.HELP[1:20]}" in shown and "usage: dualcolor " + command.NAME in shown


def test_bugs_keep_their_traceback(box, monkeypatch):
    monkeypatch.setattr("dualcolor.core.pipeline.generate", lambda *_, **__: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        cli.main(["print", str(box)])


def test_devices_are_written_to_not_replaced(tmp_path):
    if os.name != "posix":
        pytest.skip("no /dev/null here")
    null = type(tmp_path)("/dev/null")
    with OutputFiles([null]) as files:
        files.staged(null).write_text("gone")
    assert null.is_char_device()


def test_files_appear_together_or_not_at_all(tmp_path):
    first, second = tmp_path / "a.txt", tmp_path / "b.txt"
    first.write_text("former")
    with pytest.raises(ZeroDivisionError), OutputFiles([first, second]) as files:
        files.staged(first).write_text("new")
        files.staged(second).write_text("new")
        raise ZeroDivisionError
    assert first.read_text() == "former" and [path.name for path in tmp_path.iterdir()] == ["a.txt"]
    with OutputFiles([first, second]) as files:
        files.staged(first).write_text("new")
        files.staged(second).write_text("new")
        assert first.read_text() == "former"
    assert first.read_text() == second.read_text() == "new" and len(list(tmp_path.iterdir())) == 2


def test_the_launcher_runs_from_anywhere(box, tmp_path):
    if "blender" in os.path.basename(sys.executable).lower() or bpy.app.binary_path:
        pytest.skip("inside Blender there is no Python of our own to launch")
    environment = {**os.environ, "DUALCOLOR_PYTHON": sys.executable}
    run = subprocess.run(
        [ROOT / "dualcolor", "print", "box.obj", *FAST, "--gcode", "box.gcode"],
        cwd=tmp_path, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert run.returncode == 0 and run.stderr == "" and run.stdout.startswith("box: 20.0")
    assert (tmp_path / "box.gcode").stat().st_size > 10_000
    environment["DUALCOLOR_PYTHON"] = str(tmp_path / "no-python")
    run = subprocess.run([ROOT / "dualcolor"], env=environment, capture_output=True, text=True, check=False)
    assert run.returncode == 1 and run.stderr.startswith("error: ") and run.stderr.count("\n") == 1
