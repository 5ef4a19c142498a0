"""The first layer's own temperatures: at the start, and the change to those of the others, in every dialect."""

import pytest
from dualcolor.core.gcode.standby import preheat_seconds
from dualcolor.core.settings import PrintSettings
from dualcolor.core.statistics.breakdown import heating_seconds
from dualcolor.core.x3g.audit import audit
from dualcolor.core.x3g.reader import read_x3g
from dualcolor.core.x3g.writer import x3g_bytes
from dualcolor.tests.printing import gcode_text, rosette

HOTTER = {"first_layer_temperature_0": 245, "first_layer_temperature_1": 250, "first_layer_bed_temperature": 115}
MARLIN = {"printer": "marlin_dual", "bed_temperature": 90, "first_layer_bed_temperature": 100}
HEATING = ("M104", "M109", "M140", "M190", "M135", "T0", "T1", "; layer ")


def heating(moves, **values):
    """Commands of heaters and tools, before the first layer and from there to the end's sequence."""
    lines = gcode_text(moves, PrintSettings().changed(values), []).decode("ascii").splitlines()
    kept = [line for line in lines if line.startswith(HEATING) and "=" not in line]
    first = kept.index("; layer 0")
    return kept[:first], [line for line in kept[first:] if not line.endswith(" S0") and " S0 " not in line]


def test_without_them_the_temperatures_stay():
    for values in ({}, {"printer": "marlin_dual", "bed_temperature": 90}):
        assert not [line for line in heating(rosette(4, 9), **values)[1] if line.startswith(("M104", "M109", "M140"))]


@pytest.mark.parametrize("degrees", [0.0, 0.5])
def test_a_bed_that_would_be_told_0_degrees_is_as_warm_as_for_the_others(degrees):
    moves, changed = rosette(4, 9), {"first_layer_bed_temperature": degrees}
    assert heating(moves, **changed)[0][0] == "M109 S110 T0"
    settings = PrintSettings().changed(changed)
    assert audit(read_x3g(x3g_bytes(moves, settings, "part")), settings.printer_profile) == []


def test_the_second_layer_begins_with_the_others_temperatures():
    start, body = heating(rosette(4, 9), **HOTTER)
    # The white nozzle prints nothing on the first layer.
    assert start[0] == "M109 S115 T0" and start[3:5] == ["M104 S245 T0", "M104 S235 T1"]
    assert body[1:5] == ["; layer 1", "M135 T1", "M109 S110 T0", "M104 S230 T0"]
    assert not [line for line in body[5:] if line.startswith(("M104", "M109"))]
    swapped = rosette(4, 9)
    swapped.tool[:] = 1 - swapped.tool
    start, body = heating(swapped, **HOTTER)
    assert start[3:5] == ["M104 S230 T0", "M104 S250 T1"] and body[3:5] == ["M109 S110 T0", "M104 S235 T1"]


def test_marlin_gets_its_own_commands():
    start, body = heating(rosette(4, 9), **HOTTER | MARLIN)
    assert {"M140 S100", "M190 S100", "M109 T0 S245", "M109 T1 S235"} <= set(start)
    assert body[1:5] == ["; layer 1", "T1", "M140 S90", "M104 S230 T0"]


def test_a_layer_of_both_tools_changes_both():
    moves = rosette(4, 9)
    moves.layer[:] //= 2
    start, body = heating(moves, **HOTTER)
    assert start[3:5] == ["M104 S245 T0", "M104 S250 T1"]
    assert body[body.index("; layer 1") :][1:5] == ["M135 T0", "M109 S110 T0", "M104 S230 T0", "M104 S235 T1"]


def test_a_single_layer_keeps_them():
    assert heating(rosette(1, 9), **HOTTER)[1] == ["; layer 0"]


def test_the_idle_nozzle_waits_below_the_temperature_of_its_next_layer():
    slow = rosette(6, 300)
    slow.speed[:] /= 10
    body = heating(slow, **HOTTER, standby_temperature_delta=30)[1]
    after = body[body.index("; layer 1") :]
    # Heated again only for its own next layer.
    assert after[1:5] == ["M135 T1", "M104 S200 T0", "M109 S110 T0", "M104 S230 T0"]
    assert after[5:7] == ["; layer 2", "M135 T0"]
    assert not [line for line in after if "S245" in line or "S250" in line]
    assert preheat_seconds(PrintSettings(standby_temperature_delta=30)) == 20


def test_the_printers_own_file_is_sound_and_the_start_takes_longer():
    moves, plain, hotter = rosette(6, 60), PrintSettings(), PrintSettings().changed(HOTTER)
    assert audit(read_x3g(x3g_bytes(moves, hotter)), hotter.printer_profile) == []
    assert heating_seconds(moves, hotter) - heating_seconds(moves, plain) == pytest.approx(5 / 0.15 + (245 - 235) / 1.5)
