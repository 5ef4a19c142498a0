"""Settings: limits, types, changes by text, and the reference page that is made from them."""

import importlib.util
import json
from dataclasses import fields

import pytest
from dualcolor.core.errors import SettingsError
from dualcolor.core.settings import PrintSettings
from dualcolor.core.settings.suggestions import _ELSEWHERE
from hypothesis import given
from hypothesis import strategies as st

from launcher import ROOT


def test_defaults_are_valid_and_described():
    for declared in fields(PrintSettings):
        about = declared.metadata
        assert about["description"], declared.name
        assert about["description"][0].isupper(), declared.name
        assert not about["description"].endswith("."), declared.name
        if isinstance(declared.default, int | float) and not isinstance(declared.default, bool):
            assert about["low"] <= declared.default <= about["high"], declared.name
        if isinstance(declared.default, str) and declared.default:
            assert declared.default in about["choices"], declared.name


def test_all_settings_survive_json():
    chosen = PrintSettings(layer_height=0.2, pattern="offset", center_on_bed=False)
    assert PrintSettings().changed(json.loads(json.dumps(chosen.as_dict()))) == chosen


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [("layer_height", "0.2", 0.2), ("perimeters", "2", 2), ("center_on_bed", "no", False), ("pattern", "wave", "wave")],
)
def test_text_is_understood(name, text, value):
    assert getattr(PrintSettings().changed({name: text}), name) == value


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("layer_height", 5.0, "outside 0.05 to 0.5 mm"),
        ("layer_height", "thick", "not a number"),
        ("layer_height", float("nan"), "not a number"),
        ("layer_height", True, "not a number"),
        ("perimeters", 1.5, "not a whole number"),
        ("center_on_bed", 3, "not true or false"),
        ("pattern", "stripes", "not one of wave, wave_offset, offset"),
        ("pattern", 1, "not a text"),
        ("wave_depth_min", 1.0, "greater than wave_depth_max"),
        ("layer_hight", 0.2, "no setting named layer_hight"),
    ],
)
def test_bad_values_get_one_clear_sentence(name, value, words):
    with pytest.raises(SettingsError, match=words) as caught:
        PrintSettings().changed({name: value})
    assert "\n" not in str(caught.value)


@given(st.sampled_from([f.name for f in fields(PrintSettings)]), st.one_of(st.floats(), st.text(), st.none()))
def test_no_value_slips_through(name, value):
    try:
        changed = PrintSettings().changed({name: value})
    except SettingsError:
        return
    declared = next(f for f in fields(PrintSettings) if f.name == name)
    assert type(getattr(changed, name)) is type(declared.default)


def test_what_is_next_to_nothing_is_nothing():
    assert PrintSettings(infill_density=1e-308).infill_density == 0
    with pytest.raises(SettingsError, match="outside"):
        PrintSettings(layer_height=1e-308)


def test_reference_page_is_up_to_date():
    spec = importlib.util.spec_from_file_location("reference", ROOT / "tools" / "write_settings_reference.py")
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    assert (ROOT / "docs" / "settings.md").read_text(encoding="utf-8") == tool.reference()


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("layerheight", "layer_height"),
        ("fill_density", "infill_density"),
        ("z-hop", "z_hop"),
        ("nozzle_diameter", "extrusion_width"),
        ("wall_line_count", "perimeters"),
        ("Support Material", "support_enable"),
    ],
)
def test_a_name_that_is_nearly_right_or_of_another_slicer_is_understood(name, meant):
    with pytest.raises(SettingsError, match="there is no setting named") as caught:
        PrintSettings().changed({name: 1})
    assert caught.value.hint.startswith(f"did you mean {meant}")


def test_names_of_other_slicers_stand_for_settings_that_there_are():
    ours = set(PrintSettings().as_dict())
    assert set(_ELSEWHERE.values()) <= ours and not ours & set(_ELSEWHERE)
    with pytest.raises(SettingsError) as caught:
        PrintSettings().changed({"qqqq": 1})
    assert caught.value.hint == "docs/settings.md lists them all"
