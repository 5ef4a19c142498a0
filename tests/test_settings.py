"""Settings: limits, types, changes by text, and the reference page that is made from them."""

import importlib.util
import json
from dataclasses import fields

import pytest
from dualcolor.core.errors import SettingsError
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.conftest import ROOT
from hypothesis import given
from hypothesis import strategies as st


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
