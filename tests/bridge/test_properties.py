"""The properties of an object are the settings of the core: same names, defaults, limits, choices."""

from dataclasses import fields

import pytest

bpy = pytest.importorskip("bpy")

import dualcolor  # noqa: E402
from dualcolor.bridge import properties  # noqa: E402
from dualcolor.core.errors import SettingsError  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.panels.sections import SECTIONS  # noqa: E402


@pytest.fixture
def group(scene):
    dualcolor.register()
    made = bpy.data.objects.new("Thing", None)
    yield made.dualcolor
    bpy.data.objects.remove(made)
    dualcolor.unregister()


def test_sentences_name_settings_as_the_sidebar_does():
    said = "thicken it, lower extrusion_width, or set support_xy_distance to 1 mm; speed and a wipe stay"
    wanted = "thicken it, lower Extrusion Width, or set Support XY Distance to 1 mm; speed and a wipe stay"
    assert properties.with_labels(said) == wanted
    assert properties.with_labels('write {"layer_height": 0.2}') == 'write {"layer_height": 0.2}'
    assert properties.label_of(PrintSettings.__dataclass_fields__["brim_width"]) == properties.with_labels("brim_width")


def test_sentences_begin_with_a_capital_unless_with_a_name(scene):
    bpy.data.objects.new("cat", None)
    assert properties.as_shown("the cat is open") == "The cat is open"
    assert properties.as_shown("brim_width is 0") == "Brim Width is 0"
    for said in ("cat has no faces", "odd.json is not JSON", "xatlas is not there", "3 walls hang", ""):
        assert properties.as_shown(said) == said


def test_defaults_are_those_of_the_core(group):
    assert properties.to_settings(group) == PrintSettings()


@pytest.mark.parametrize("declared", fields(PrintSettings), ids=lambda declared: declared.name)
def test_a_property_has_the_limits_and_words_of_its_setting(group, declared):
    made, limits = group.bl_rna.properties[declared.name], declared.metadata
    assert made.description == limits["description"]
    if limits["choices"]:
        assert tuple(item.identifier for item in made.enum_items) == limits["choices"]
    elif limits["low"] is not None:
        assert (made.hard_min, made.hard_max) == pytest.approx((limits["low"], limits["high"]))
    kinds = {bool: "BOOLEAN", int: "INT", float: "FLOAT", str: "ENUM"}
    is_path = isinstance(declared.default, str) and not limits["choices"]
    assert made.type == ("STRING" if is_path else kinds[type(declared.default)])
    assert limits["unit"] in ("", "mm", "%") or f"({limits['unit']})" in made.name


def test_settings_go_in_and_come_out_unchanged(group):
    wanted = PrintSettings().changed(
        {"layer_height": 0.2, "wave_depth_max": 0.7, "pattern": "wave", "perimeters": 3, "center_on_bed": False}
    )
    properties.from_settings(group, wanted)
    assert properties.to_settings(group) == wanted


@pytest.mark.parametrize("low_end", [True, False])
def test_the_limits_themselves_are_allowed(group, low_end):
    for declared in fields(PrintSettings):
        if declared.metadata["low"] is not None and not declared.name.startswith("wave_depth"):
            setattr(group, declared.name, declared.metadata["low" if low_end else "high"])
    settings = properties.to_settings(group)
    assert settings.layer_height == (0.05 if low_end else 0.5)


def test_a_path_beside_the_file_is_found_and_stays_relative(group, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "print.blend"))
    group = bpy.data.objects["Thing"].dualcolor
    group.calibration_file = "//tones.json"
    settings = properties.to_settings(group)
    assert settings.calibration_file == str(tmp_path / "tones.json")
    properties.from_settings(group, settings.changed({"brim_width": 2.0}))
    assert group.calibration_file == "//tones.json" and group.brim_width == 2.0


def test_settings_at_odds_are_an_error(group):
    group.wave_depth_min, group.wave_depth_max = 0.5, 0.4
    with pytest.raises(SettingsError):
        properties.to_settings(group)


def test_a_report_is_stored_with_the_object(group):
    assert properties.report_of(group) == {}
    told = {"bounds_mm": [[0, 0, 0], [1, 1, 1]], "layers": 7, "time_s": {}, "filament": {}, "settings": {}}
    told |= {"warnings": ["thin walls"]}
    properties.set_report(group, told)
    assert properties.report_of(group) == told


def test_every_setting_is_in_the_sidebar_once():
    shown = [name for section in SECTIONS for name in (*section.settings, section.switch) if name]
    assert sorted(shown) == sorted(declared.name for declared in fields(PrintSettings))
