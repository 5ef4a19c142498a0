"""Damaged files: the fuzzer itself, and files that once did harm; `test_any_file.py` tries others."""

import json

import numpy as np
import pytest
from dualcolor.core.errors import PrintError
from dualcolor.core.gcode.reader import read_gcode
from dualcolor.core.settings import PrintSettings
from dualcolor.core.settings.printer import read_profile
from dualcolor.core.x3g.moves import moves_of_x3g
from dualcolor.tests.fuzz.mutate import mutated
from dualcolor.tests.fuzz.run import fuzzed
from dualcolor.tests.fuzz.targets import targets


@pytest.mark.parametrize("target", targets().values(), ids=targets())
def test_the_sound_files_are_sound(target):
    assert sum(_passes(target.read, data) for data in target.seeds) >= 1


def _passes(read, data):
    try:
        read(data)
    except PrintError:
        return False
    return True


def test_what_is_tried_is_counted(monkeypatch):
    outcome = fuzzed("preset", 1e9, seed=7, most=50)
    assert outcome.tried == 50 and outcome.refused and not outcome.findings
    monkeypatch.setattr(json, "loads", lambda text: np.float32("inf") - np.float32("inf"))
    assert fuzzed("preset", 1e9, seed=7, most=5).findings  # a warning of numpy's


def test_a_bug_would_be_found():
    random = np.random.default_rng(1)
    data = b'{"a": 1}'
    damaged = {mutated(data, [data], [b"[]"], random) for _ in range(200)}
    broken = 0
    for each in damaged:
        try:
            json.loads(each)["a"]
        except (ValueError, KeyError, TypeError):
            broken += 1
    assert broken > 100


@pytest.mark.parametrize("text", ["", "[", "[" * 100_000, '{"printer": 1}', '{"printer": {"name": NaN}}', "\xff"])
def test_damaged_printers_are_refused(tmp_path, text):
    (tmp_path / "p.json").write_bytes(text.encode("latin-1"))
    with pytest.raises(PrintError):
        read_profile(tmp_path / "p.json")


def test_numbers_beyond_all_bounds_are_refused():
    with pytest.raises(PrintError, match="beyond all bounds"):
        read_gcode(b"G1 X1 Y1 Z0.2 F600\nG1 X99999999999999999999 E1\nG1 X0 E2\n", "part")
    with pytest.raises(PrintError, match="no plastic"):
        moves_of_x3g(bytes([137, 31]), "part")


def test_refusals_stay_short():
    for values in ({"layer_height": "9" * 1000 + "x"}, {"pattern": "x" * 1000}, {"a\n" * 1000: 1}):
        with pytest.raises(PrintError) as refused:
            PrintSettings().changed(values)
        assert len(str(refused.value)) < 300 and "\n" not in str(refused.value)
