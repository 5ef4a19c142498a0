"""The command line: what is written, what is said, exit statuses."""

import json
import os
import subprocess
import sys

import bpy
import numpy as np
import pytest
from dualcolor import cli
from dualcolor.commands import analyze
from dualcolor.tests.commands.models import FAST
from dualcolor.tests.gpx import convert
from dualcolor.tests.scene import add_box, add_material, fresh
from PIL import Image

from launcher import ROOT


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
    for name in "ab":
        outputs = [f"--{kind}={tmp_path / name}.{kind}" for kind in ("gcode", "x3g")]
        assert cli.main(["print", str(box), *FAST, *outputs]) == 0
    assert (tmp_path / "a.gcode").read_bytes() == (tmp_path / "b.gcode").read_bytes()
    assert (tmp_path / "a.x3g").read_bytes() == (tmp_path / "b.x3g").read_bytes()


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


def test_a_material_made_by_nodes_is_printed_once_it_is_baked(tmp_path, capfd):
    fresh()
    _, tree = add_material(add_box((20, 20, 20)), None)
    white = tree.nodes.new("ShaderNodeInvert")
    white.inputs["Color"].default_value = (0.0, 0.0, 0.0, 1.0)
    principled = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    tree.links.new(white.outputs["Color"], principled.inputs["Base Color"])
    model, dump = tmp_path / "box.blend", tmp_path / "box.npz"
    bpy.ops.wm.save_as_mainfile(filepath=str(model))
    command = ["print", str(model), *FAST, "--dump", str(dump)]
    for options, tone, told in ([], 0.5, True), (["--bake-material"], 1.0, False):
        assert cli.main([*command, *options]) == 0
        assert ("--bake-material" in capfd.readouterr().out) == told
        with np.load(dump) as arrays:
            np.testing.assert_allclose(arrays["tone"], tone, atol=1e-3)
    report = tmp_path / "found.json"
    assert cli.main(["analyze", str(model), *FAST, "--bake-material", "--report", str(report)]) == 0
    assert "--bake-material" not in capfd.readouterr().out


def test_an_object_may_be_named_twice(tmp_path, capfd):
    fresh()
    name = add_box((20, 20, 20)).name
    model = tmp_path / "box.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(model))
    for options in ([], ["--bake-material"]):
        assert cli.main(["print", str(model), *FAST, "--object", name, "--object", name, *options]) == 0
        assert "plate of 2 objects" in capfd.readouterr().out


@pytest.mark.parametrize("height", [[], ["--height-mm", "36"]])
def test_suggested_orientations_can_be_printed(tmp_path, capfd, height):
    """A wedge: the options that `analyze` gives turn it into what was promised."""
    wedge = tmp_path / "wedge.obj"
    wedge.write_text("v 0 0 0\nv 30 0 0\nv 0 0 18\nv 0 24 0\nv 30 24 0\nv 0 24 18\n"
                     "f 1 3 2\nf 4 5 6\nf 1 2 5 4\nf 2 3 6 5\nf 3 1 4 6\n")  # fmt: skip
    assert cli.main(["analyze", str(wedge), "--up", "z", *FAST, "--rotate-z", "20", *height]) == 0
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


@pytest.mark.parametrize(
    ("given", "up", "options"),
    [
        ([], (0.0, 0.0, 1.0), []),
        ([], (0.0, 1.0, 0.0), ["--rotate-x 90"]),
        (["--rotate-x", "90"], (0.0, 0.0, 1.0), []),
        (["--rotate-x", "90"], (0.0, -1.0, 0.0), ["--rotate-x 0"]),
    ],
)
def test_to_turn_a_model_back_takes_an_option_too(given, up, options):
    """What was turned by 90° about X has its former top at -Y."""
    assert analyze.turning_options(up, cli.make_parser().parse_args(["analyze", "wedge.obj", *given])) == options


def test_a_command_has_both_spellings() -> None:
    parser = cli.make_parser()
    british, american = (parser.parse_args([name, "wedge.obj"]) for name in ("analyse", "analyze"))
    assert british.command is american.command is analyze


@pytest.mark.skipif(sys.platform != "linux", reason="names of files are Unicode elsewhere")
def test_a_file_may_have_any_name(box, tmp_path, capfd):
    odd = box.rename(os.fsdecode(bytes(tmp_path) + b"/b\xff x.obj"))
    assert cli.main(["print", str(odd), *FAST, "--report", f"{odd}.json"]) == 0
    assert json.loads(odd.with_name(f"{odd.name}.json").read_bytes())["name"] == "b\N{REPLACEMENT CHARACTER} x"


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


def test_without_an_output_it_says_so(box, tmp_path, capfd):
    gcode = str(tmp_path / "box.gcode")
    assert cli.main(["print", str(box), *FAST, "--gcode", gcode]) == 0
    assert "nothing is written" not in capfd.readouterr().out
    assert cli.main(["render", gcode]) == 0
    assert "nothing is written: name the file" in capfd.readouterr().out
    assert cli.main(["print", str(box), *FAST]) == 0
    assert "nothing is written: name the files" in capfd.readouterr().out
    assert cli.main(["tile", *FAST]) == 0
    assert "nothing is written: name the files" in capfd.readouterr().out


def test_the_version_is_that_of_the_extension(capfd):
    assert cli.main(["--version"]) == 0
    assert f'version = "{capfd.readouterr().out.split()[-1]}"' in (ROOT / "blender_manifest.toml").read_text()


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["paint"],
        ["print"],
        ["print", "x.obj", "--up", "x"],
        ["print", "x.obj", "--height-mm", "0"],
        ["print", "x.obj", "--height-mm", "nan"],
        ["print", "x.obj", "--scale", "half"],
        ["print", "x.obj", "--set", "layer_height"],
        ["print", "x.obj", "--set", "=0.2"],
        ["print", "x.obj", "--render", "x.png", "--views", ","],
        ["read-photo", "x.png", "--out", "x.json", "--corners", "nan,1", "2,3", "4,5", "6,7"],
        ["read-photo", "x.png", "--out", "x.json", "--corners", "left", "2,3", "4,5", "6,7"],
        ["print", "x.obj", "--unwrap", "magic"],
        ["print", "x.obj", "--blend", "x.png"],
        ["print", "x.obj", "--dump", "x"],
        ["print", "x.obj", "--gcode", "x.x3g"],
        ["print", "x.obj", "--x3g", "x.gcode"],
        ["plate", "x.png", "--samples", "1000000000"],
        ["analyze", "x.obj", "--pixels", "5"],
        ["print", "x.obj", "--rotate-x", "inf"],
        ["print", "x.obj", "--render", "x.png", "--pixels", "5000"],
        ["print", "x.obj", "--scale", "2", "--height-mm", "20"],
    ],
)
def test_wrong_usage_is_status_2(arguments, capfd):
    assert cli.main(arguments) == 2
    assert "usage:" in capfd.readouterr().err


def test_an_option_that_is_a_setting_is_told_so(capfd):
    assert cli.main(["print", "x.obj", "--layer-height", "0.2"]) == 2
    assert "--layer-height is a setting: give it as --set layer_height=VALUE" in capfd.readouterr().err
    assert cli.main(["print", "x.obj", "--infill_density=20"]) == 2
    assert "give it as --set infill_density=VALUE" in capfd.readouterr().err
    assert cli.main(["print", "x.obj", "--nonsense", "0.2"]) == 2
    assert "unrecognized arguments: --nonsense 0.2" in capfd.readouterr().err


@pytest.mark.parametrize("command", cli.COMMANDS)
def test_every_command_explains_itself(command, capfd):
    assert cli.main([command.NAME, "--help"]) == 0
    shown = " ".join(capfd.readouterr().out.split())
    assert f"{command.HELP[1:20]}" in shown and "usage: dualcolor " + command.NAME in shown


def test_bugs_keep_their_traceback(box, monkeypatch):
    monkeypatch.setattr("dualcolor.core.pipeline.generate", lambda *_, **__: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        cli.main(["print", str(box)])


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
