"""Presets, saved settings, settings from the header of a G-code file; files that are none of these."""

import json
import re

import numpy as np
import pytest
from dualcolor.cli import main
from dualcolor.core.errors import OutputError, SettingsError
from dualcolor.core.exports import export_gcode
from dualcolor.core.files import MOST_JSON_BYTES
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.settings.header_text import read_back, written
from dualcolor.core.settings.presets import (
    KINDS,
    PRESETS,
    agrees,
    kind_settings,
    preset_files,
    preset_values,
    read_preset,
    read_settings,
    remove_preset,
    save_preset,
    settings_json,
)
from dualcolor.tests.solids import box

CHOSEN = PrintSettings(layer_height=0.2, pattern="wave", center_on_bed=False, skirts=0, wave_depth_min=0.3)


@pytest.mark.parametrize("name", preset_files())
def test_every_preset_is_valid_and_described(name):
    values = preset_values([name])
    assert PrintSettings().changed(values).as_dict().items() >= values.items()
    assert set(values) <= set(kind_settings(preset_files()[name].parent.name))
    preset = read_preset(preset_files()[name])
    assert preset.label != name
    assert preset.description and not preset.description.endswith(".")


def test_a_copied_printer_file_chooses_its_own_printer(tmp_path):
    copy = tmp_path / "mine.json"
    copy.write_bytes((PRESETS / "printer" / "marlin_dual.json").read_bytes())
    assert read_preset(copy).settings["printer"] == "mine"
    assert read_settings(copy)["printer"] == "mine"


def test_qualities_and_later_presets_count():
    assert preset_values(["fine"])["layer_height"] == 0.2
    assert preset_values(["fine", "standard"])["layer_height"] == 0.25
    both = preset_values(["abs_black", "abs_white"])
    assert {"nozzle_temperature_0", "nozzle_temperature_1"} <= set(both)
    assert preset_values(["pla"])["bed_temperature"] < 80
    with pytest.raises(
        SettingsError, match="no preset named 'finest': choose among marlin_dual, replicator_2x, replicator_dual"
    ):
        preset_values(["finest"])
    with pytest.raises(SettingsError):
        preset_values(["../filament/pla"])


def test_the_defaults_are_black_and_white_abs_on_the_replicator_2x():
    usual = PrintSettings()
    chosen = {name for name, path in preset_files().items() if agrees(read_preset(path), usual.as_dict())}
    assert chosen == {"replicator_2x", "abs_black", "abs_white", "standard", "set_back"}


def test_the_paper_is_a_preset():
    paper = PrintSettings().changed(preset_values(["paper"]))
    assert (paper.pattern, paper.wave_depth_max, paper.wave_depth_min, paper.offset_max) == ("wave", 0.75, 0.375, 0)


def test_settings_agree_with_a_preset_up_to_single_precision():
    fine = read_preset(preset_files()["fine"])
    values = PrintSettings().changed(fine.settings).as_dict()
    height = values["layer_height"]
    assert agrees(fine, values | {"layer_height": float(np.float32(height))})
    assert not agrees(fine, values | {"layer_height": 1.0001 * height})


def test_kinds_share_no_setting_and_leave_none_of_the_print_out():
    held = [name for kind in KINDS for name in kind_settings(kind)]
    assert len(held) == len(set(held))
    left_out = set(PrintSettings().as_dict()) - set(held)
    assert left_out == {"sag"}  # how the preview looks


def test_own_presets_are_saved_found_and_removed(tmp_path):
    wanted = PrintSettings(layer_height=0.15, perimeters=2, wavelength=1.4)
    path = save_preset(tmp_path, "quality", " Very fine ", wanted)
    assert path == tmp_path / "quality" / "Very fine.json"
    assert list(preset_files(tmp_path, ("quality",))) == ["fine", "standard", "Very fine"]
    values = preset_values(["Very fine"], tmp_path)
    assert set(values) == set(kind_settings("quality"))
    assert (values["layer_height"], values["perimeters"], "wavelength" in values) == (0.15, 2, False)
    assert "Very fine" not in preset_files()
    assert agrees(read_preset(path), wanted.as_dict())
    assert not agrees(read_preset(path), PrintSettings().as_dict())
    assert PrintSettings().changed(read_settings(path)).layer_height == 0.15  # --settings takes presets too
    save_preset(tmp_path, "quality", "Very fine", PrintSettings(layer_height=0.1))
    assert preset_values(["Very fine"], tmp_path)["layer_height"] == 0.1
    remove_preset(tmp_path, "quality", "Very fine")
    assert not path.exists()
    with pytest.raises(SettingsError, match="not one of your own presets"):
        remove_preset(tmp_path, "quality", "Very fine")
    with pytest.raises(SettingsError, match="not one of your own presets"):
        remove_preset(tmp_path, "quality", "fine")
    assert (PRESETS / "quality" / "fine.json").exists()


@pytest.mark.parametrize(
    "name", ["", "  ", "../fine", "a/b", "a\\b", ".hidden", "x" * 80, "a\nb", "C:x", "NUL", "com1.x"]
)
def test_names_that_are_no_file_names(tmp_path, name):
    with pytest.raises(SettingsError, match="cannot be a preset's name"):
        save_preset(tmp_path, "quality", name, PrintSettings())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("kind", "name"), [("quality", "fine"), ("filament", "Fine"), ("pattern", "pla")])
def test_names_that_are_taken(tmp_path, kind, name):
    with pytest.raises(SettingsError, match="already: choose another name"):
        save_preset(tmp_path, kind, name, PrintSettings())


def test_a_folder_that_cannot_be_written_to(tmp_path):
    (tmp_path / "quality").write_text("a file where the folder should be")
    with pytest.raises(OutputError, match="cannot be made"):
        save_preset(tmp_path, "quality", "mine", PrintSettings())


@pytest.mark.parametrize("text", ["{}", '{"settings": [1]}', '{"layer_height": 0.2}', "no JSON"])
def test_a_broken_preset_is_named(tmp_path, text):
    (tmp_path / "filament").mkdir()
    (tmp_path / "filament" / "broken.json").write_text(text)
    with pytest.raises(SettingsError, match="broken"):
        preset_values(["broken"], tmp_path)


def test_settings_survive_a_file(tmp_path):
    path = tmp_path / "settings.json"
    path.write_text(settings_json(CHOSEN), encoding="utf-8")
    assert PrintSettings().changed(read_settings(path)) == CHOSEN


def test_settings_survive_the_header_of_a_print(tmp_path):
    path = tmp_path / "box.gcode"
    export_gcode(generate(box((0, 0, 0), (8, 8, 2)), CHOSEN), path)
    values = read_settings(path)
    assert set(values) == set(CHOSEN.as_dict())
    assert PrintSettings().changed(values) == CHOSEN


@pytest.mark.parametrize("text", ["50%25.json", "a;b#c@d(e)", " blank ", "Würfel", "line\nbreak", "%"])
def test_any_text_survives_a_comment(text):
    comment = written(text)
    assert read_back(comment) == text
    assert re.fullmatch("[ -~]*", comment) and comment == comment.strip() and not set("#@;()") & set(comment)


@pytest.mark.parametrize("text", ["%FF", "50 %", "%ED%A0", "100%C3%"])
def test_texts_that_nobody_encoded_are_read_as_they_are(text):
    assert read_back(text) == text


def test_header_ends_at_the_first_command(tmp_path):
    path = tmp_path / "made_up.gcode"
    path.write_text("; object = x\n; wavelength = 1.5\nG1 X1\n; wavelength = 9\n", encoding="ascii")
    assert read_settings(path) == {"wavelength": "1.5"}


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.json", b"[1, 2]", "holds no settings"),
        ("a.json", b"{", "is not JSON"),
        ("a.json", b"\xff\xfe{}", "is not JSON"),
        ("a.json", b"[" * 200_000, "is not JSON"),
        ("a.json", b'"' + b" " * MOST_JSON_BYTES + b'"', "too large"),
        ("a.gcode", b"G1 X1\n; wavelength = 2\n", "has no settings in its header"),
        ("a.gcode", bytes(range(256)) * 40, "has no settings in its header"),
    ],
)
def test_other_files_get_one_sentence(tmp_path, name, content, words):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(SettingsError, match=words) as caught:
        read_settings(path)
    assert "\n" not in str(caught.value)
    with pytest.raises(SettingsError, match="cannot be read"):
        read_settings(tmp_path / "missing.json")
    with pytest.raises(SettingsError, match="cannot be read"):
        read_settings(tmp_path)


def test_command_line_takes_presets_and_saves_settings(tmp_path, capfd):
    pytest.importorskip("bpy")
    model, saved = tmp_path / "box.obj", tmp_path / "saved.json"
    corners = [(x, y, z) for x in (0, 8) for y in (0, 8) for z in (0, 2)]
    faces = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    text = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {' '.join(map(str, face))}" for face in faces]
    model.write_text("\n".join(text) + "\n")
    command = ["print", str(model), "--up", "z", "--preset", "pla", "--preset", "fine", "--set", "layer_height=0.3"]
    gcode = tmp_path / "box.gcode"
    assert main([*command, "--save-settings", str(saved), "--gcode", str(gcode)]) == 0
    values = json.loads(saved.read_text(encoding="utf-8"))
    assert (values["layer_height"], values["first_layer_height"], values["bed_temperature"]) == (0.3, 0.2, 60.0)
    assert PrintSettings().changed(values) == PrintSettings().changed(read_settings(gcode))
    again = tmp_path / "again.gcode"
    assert main(["print", str(model), "--up", "z", "--settings", str(gcode), "--gcode", str(again)]) == 0
    assert again.read_bytes() == gcode.read_bytes()
    capfd.readouterr()
    assert main(["print", str(model), "--preset", "none such"]) == 1
    assert "there is no preset named" in capfd.readouterr().err
