"""Whatever settings are given: they come back from every kind of file, or are refused in one sentence."""

import tempfile
from dataclasses import fields
from pathlib import Path

import pytest
from dualcolor.core.errors import SettingsError
from dualcolor.core.gcode.reader import read_gcode
from dualcolor.core.settings import PrintSettings
from dualcolor.core.settings.presets import KINDS, kind_settings, read_preset, read_settings, save_preset, settings_json
from dualcolor.tests.printing import OUTER_WALL, TRAVEL, gcode_text, table
from dualcolor.tests.robustness.strategies import ANY_SETTINGS, examples
from hypothesis import assume, given
from hypothesis import strategies as st

ONE_LINE = table((0, 0, 0.25, 0, TRAVEL, 0, 100, 0), (10, 0, 0.25, 0, OUTER_WALL, 0, 40, 0.5))


def made(values):
    """The settings; an example in which the depths of the wave contradict each other does not count."""
    try:
        return PrintSettings().changed(values)
    except SettingsError as problem:
        assert "wave_depth_min is greater" in str(problem)
        assume(False)


@given(ANY_SETTINGS)
@examples(60)
def test_settings_come_back_from_json_and_presets(values):
    settings = made(values)
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "settings.json"
        path.write_text(settings_json(settings), encoding="utf-8")
        assert PrintSettings().changed(read_settings(path)) == settings
        for kind in KINDS:
            kept = read_preset(save_preset(Path(name), kind, f"My {kind}", settings)).settings
            assert kept == {key: getattr(settings, key) for key in kind_settings(kind)}


@given(ANY_SETTINGS)
@examples(60)
def test_settings_come_back_from_the_head_of_a_print(values):
    settings = made(values)
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "print.gcode"
        path.write_bytes(gcode_text(ONE_LINE, settings, ["object = part"]))
        assert PrintSettings().changed(read_settings(path)) == settings
        assert read_gcode(path.read_bytes(), "part").settings == settings


@given(st.sampled_from(fields(PrintSettings)), st.floats(allow_nan=False))
@examples(150)
def test_a_number_beyond_its_limits_is_one_sentence(declared, value):
    low, high = declared.metadata["low"], declared.metadata["high"]
    assume(low is not None and not low <= value <= high and abs(value) > 1e-9)
    with pytest.raises(SettingsError) as refused:
        PrintSettings().changed({declared.name: value})
    assert "\n" not in str(refused.value) and declared.name in str(refused.value)
