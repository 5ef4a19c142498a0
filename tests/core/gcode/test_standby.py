"""The idle nozzle: cooled after its tool change, hot before the next one, in time and for the converter's eyes."""

import numpy as np
import pytest
from dualcolor.core.gcode.reader import read_gcode
from dualcolor.core.gcode.standby import preheat_seconds, standby, standby_warnings
from dualcolor.core.settings import PrintSettings
from dualcolor.core.toolpaths.move_times import move_seconds
from dualcolor.core.x3g.audit import audit
from dualcolor.core.x3g.commands import Action, Command
from dualcolor.core.x3g.reader import read_x3g
from dualcolor.core.x3g.writer import x3g_bytes
from dualcolor.tests.gpx import convert
from dualcolor.tests.printing import gcode_text, rosette

SETTINGS = PrintSettings(standby_temperature_delta=30, nozzle_temperature_1=240)


@pytest.fixture(scope="module")
def slow():
    """Six layers of about a minute each."""
    moves = rosette(6, 300)
    moves.speed[:] /= 10
    return moves


@pytest.fixture(scope="module")
def seconds(slow):
    return move_seconds(slow, SETTINGS.printer_profile)


def test_cooled_when_idle_heated_in_time(slow, seconds):
    found = standby(slow, seconds, SETTINGS)
    change = np.flatnonzero(np.diff(slow.tool)) + 1
    passed = np.concatenate([[0.0], np.cumsum(seconds)])
    assert found.cool.tolist() == change.tolist() and found.short == 0
    assert found.tool.tolist() == [0, 1, 0, 1, 0]
    assert found.use.tolist() == [*change[1:], len(slow.tool)]
    early = passed[found.use[:-1]] - passed[found.heat[:-1]]
    assert preheat_seconds(SETTINGS) == pytest.approx(30 / 1.5)
    assert (early >= 20).all() and (early < 21).all()  # the longest move takes less than a second
    longer = SETTINGS.changed({"preheat_time": 25})
    found = standby(slow, seconds, longer)
    early = passed[found.use[:-1]] - passed[found.heat[:-1]]
    assert (early >= 25).all() and (early < 26).all()


def test_short_layers_keep_both_nozzles_hot(seconds, slow):
    quick = rosette(6, 300)
    quick_seconds = move_seconds(quick, SETTINGS.printer_profile)
    found = standby(quick, quick_seconds, SETTINGS)
    assert found.short == 4 and found.tool.tolist() == [0]  # after its last layer a nozzle is not needed again
    (said,) = standby_warnings(quick, quick_seconds, SETTINGS)
    assert "4 of 5 times" in said and "less than 40 s" in said
    assert standby_warnings(slow, seconds, SETTINGS) == []
    assert standby_warnings(quick, quick_seconds, PrintSettings()) == []


@pytest.mark.parametrize(("times", "short"), [(1.7, 4), (2.1, 0)])
def test_a_nozzle_is_cooled_only_if_it_rests_as_long_again_as_it_heats(slow, seconds, times, short):
    change = np.flatnonzero(np.diff(slow.tool)) + 1
    idle = np.add.reduceat(seconds, change)[:-1]
    assert np.ptp(idle) < 0.05 * idle.min()
    settings = SETTINGS.changed({"standby_temperature_delta": 1, "preheat_time": float(idle.min()) / times})
    assert standby(slow, seconds, settings).short == short


def commands(text):
    lines = text.decode("ascii").splitlines()
    body = lines[lines.index("; layer 0") : lines.index("M18 A B")]
    return [line for line in body if line[:4] in ("M104", "M133", "M135")]


def test_commands_of_the_file(slow):
    told = commands(gcode_text(slow, SETTINGS, []))
    assert told[:6] == ["M135 T1", "M104 S200 T0", "M104 S230 T0", "M133 T0", "M135 T0", "M104 S210 T1"]
    assert told[6:9] == ["M104 S240 T1", "M133 T1", "M135 T1"]
    assert told[-1] == "M104 S200 T0"
    # hot again before each use
    state = {"T0": True, "T1": True}
    for line in told:
        code, *words = line.split()
        if code == "M135":
            assert state[words[0]]
        if code == "M104":
            state[words[1]] = False
        if code == "M133":
            state[words[0]] = True
    plain = gcode_text(slow, SETTINGS.changed({"standby_temperature_delta": 0}), [])
    assert commands(plain) == [f"M135 T{layer % 2}" for layer in range(1, 6)]


def test_marlin_waits_in_its_own_words(slow):
    told = gcode_text(slow, SETTINGS.changed({"printer": "marlin_dual"}), []).decode("ascii").splitlines()
    assert "M133 T0" not in told
    use = told.index("M109 S230 T0", told.index("M104 S200 T0"))
    assert "T0" in told[use + 1 : use + 7]


def test_the_moves_stay_the_same(slow):
    read = [read_gcode(gcode_text(slow, settings, []), "part").moves for settings in (SETTINGS, PrintSettings())]
    assert read[0].position.tolist() == read[1].position.tolist()
    assert read[0].tool.tolist() == read[1].tool.tolist()


@pytest.mark.parametrize("delta", [30, 39])
def test_gpx_takes_it_and_the_x3g_is_the_same(slow, tmp_path, delta):
    settings = SETTINGS.changed({"standby_temperature_delta": delta})
    path = tmp_path / "part.gcode"
    path.write_bytes(gcode_text(slow, settings, []))
    assert convert(path) == []
    mine = x3g_bytes(slow, settings, "part")
    assert mine == path.with_suffix(".x3g").read_bytes()
    assert audit(read_x3g(mine), settings.printer_profile) == []


def test_audit_finds_a_nozzle_that_was_not_heated_again(slow):
    slower = type(slow)(**{**vars(slow), "speed": slow.speed / 5})
    settings = SETTINGS.changed({"standby_temperature_delta": 100})
    data = x3g_bytes(slower, settings, "part")
    found = read_x3g(data)
    assert audit(found, settings.printer_profile) == []
    parts = np.split(found.data, found.offset[1:])
    waits = [k for k, code in enumerate(found.code) if code == Command.WAIT_FOR_TOOL]
    heats = [
        k
        for k, part in enumerate(parts)
        if part[0] == Command.TOOL_ACTION and part[2] == Action.NOZZLE_TEMPERATURE and part[4] == 230
    ]
    for missing in (waits[-1], heats[1]):
        broken = b"".join(part.tobytes() for k, part in enumerate(parts) if k != missing)
        assert any(
            "moves its filament while it is cold" in said for said in audit(read_x3g(broken), settings.printer_profile)
        )
