"""What the command line refuses: one line says why, and every file is as it was."""

import bpy
import pytest
from dualcolor.core.errors import OutputError
from dualcolor.tests.commands.models import CLOSED_BOX, FAST, OPEN_BOX
from dualcolor.tests.scene import add_box, fresh

from launcher import ROOT


def test_bad_models_are_refused(tmp_path, refused):
    model, gcode = tmp_path / "model.obj", tmp_path / "out.gcode"
    assert "there is no file" in refused("print", model, "--gcode", gcode)
    model.write_text("# nothing")
    assert "there is no mesh" in refused("print", model, "--gcode", gcode)
    model.write_text(OPEN_BOX)
    assert "open" in refused("print", model, "--gcode", gcode)
    model.write_text(CLOSED_BOX.replace("20", "300"))
    assert "larger than" in refused("print", model, "--gcode", gcode)


def test_coordinates_that_are_no_numbers_are_refused(tmp_path, refused):
    fresh()
    add_box((20, 20, 20)).data.vertices[3].co.y = float("nan")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "box.blend"))
    assert "not finite" in refused("print", tmp_path / "box.blend", "--gcode", tmp_path / "out.gcode")
    assert "finite" in refused("print", tmp_path / "box.blend", "--height-mm", 10)


def test_names_that_are_too_long_are_refused(box, refused):
    name = "n" * 300
    assert "there is no file" in refused("print", f"{name}.obj")
    assert "its name is too long" in refused("print", box, "--gcode", name)
    assert "there is no file" in refused("print", box, "--support-enforcer", name)
    assert "cannot be read" in refused("print", box, "--settings", name)
    assert "cannot be read" in refused("print", box, "--texture", name)
    painted = ["--unwrap", "smart", "--set", f"seam_visibility={name}"]
    assert "there is no such image" in refused("print", box, *painted)


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
    assert "take, but not of what" in refused("analyze", box, "--views", "front")
    assert "no turntable" in refused("analyze", box, "--slopes", tmp_path / "x.png", "--views", "turntable")


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
        for line in CLOSED_BOX.splitlines():
            if line.startswith("f"):
                corners = " ".join(f"{corner}/{at}" for at, corner in enumerate(line.split()[1:], start=1))
                file.write(f"f {corners}\n")
    assert "spots.png is read by this job" in refused("print", box, *FAST, "--render", tmp_path / "spots.png")
    assert "spots.png is read by this job" in refused("analyze", box, *FAST, "--slopes", tmp_path / "spots.png")
    assert "box.mtl is read by this job" in refused("print", box, *FAST, "--gcode", tmp_path / "box.mtl")
    table = tmp_path / "table.json"
    table.write_bytes((ROOT / "presets/calibration/offset/set_back_fine.json").read_bytes())
    own = ["--set", "calibration=file", "--set", f"calibration_file={table}"]
    assert "table.json is read by this job" in refused("print", box, *FAST, *own, "--report", table)


def test_a_scene_keeps_the_files_that_are_linked_to_it(box, tmp_path, refused):
    library, scene = tmp_path / "library.blend", tmp_path / "scene.blend"
    fresh()
    bpy.data.libraries.write(str(library), {add_box((20, 20, 20), "boxed")})
    fresh()
    with bpy.data.libraries.load(str(library), link=True) as (_, wanted):
        wanted.objects = ["boxed"]
    bpy.context.scene.collection.objects.link(bpy.data.objects["boxed"])
    bpy.ops.wm.save_as_mainfile(filepath=str(scene))
    assert "library.blend is read by this job" in refused("print", scene, *FAST, "--blend", library)


def test_a_failure_while_writing_leaves_nothing(box, tmp_path, refused, monkeypatch):
    kept = tmp_path / "box.gcode"
    kept.write_text("former")

    def full(*_):
        raise OutputError("the disk is full")

    monkeypatch.setattr("dualcolor.core.exports.dump", full)
    command = ["print", box, *FAST, "--gcode", kept, "--dump", tmp_path / "box.npz"]
    assert refused(*command) == "error: the disk is full"
