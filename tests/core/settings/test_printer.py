"""Printers are data: a file with wrong facts is refused, and another file is another printer from end to end."""

import json
from dataclasses import replace

import numpy as np
import pytest
from dualcolor.core.errors import MeshError, SettingsError
from dualcolor.core.gcode.reader import read_gcode
from dualcolor.core.job.checks import check
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.settings.presets import preset_values
from dualcolor.core.settings.printer import PRINTERS, printer_names, printer_profile, read_profile
from dualcolor.core.x3g.audit import audit
from dualcolor.core.x3g.motion import step_interval
from dualcolor.core.x3g.moves import moves_of_x3g
from dualcolor.core.x3g.reader import read_x3g
from dualcolor.core.x3g.writer import x3g_bytes
from dualcolor.tests.gpx import convert
from dualcolor.tests.printing import gcode_text, print_time, rosette
from dualcolor.tests.solids import box

MAKERBOT = [name for name in printer_names() if not printer_profile(name).marlin]
FACTS = json.loads((PRINTERS / "replicator_2x.json").read_text(encoding="utf-8"))["printer"]


def settings_for(printer):
    return PrintSettings().changed(preset_values([printer]))


def written(path, facts):
    path.write_text(json.dumps({"description": "", "settings": {}, "printer": facts}), encoding="utf-8")
    return path


def test_facts_come_from_the_file(tmp_path):
    profile = read_profile(written(tmp_path / "other.json", FACTS | {"name": "Other", "queue_moves": 8}))
    assert (profile.name, profile.queue_moves) == ("Other", 8)
    assert replace(profile, name=FACTS["name"], queue_moves=16) == printer_profile("replicator_2x")


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"home": ["left", "rear"]}, "home of the printer wrong is not of the right kind"),
        ({"home": [152]}, "home of the printer wrong"),
        ({"queue_moves": 15.5}, "queue_moves of the printer wrong"),
        ({"max_temperature_c": 280}, "max_temperature_c of the printer wrong"),
        ({"warm_up_c": True}, "warm_up_c of the printer wrong"),
        ({"nozzles": 3}, "lacks a fact or has one too many: nozzles"),
    ],
)
def test_wrong_facts_are_named(tmp_path, wrong, words):
    with pytest.raises(SettingsError, match=words) as caught:
        read_profile(written(tmp_path / "wrong.json", FACTS | wrong))
    assert caught.value.hint
    with pytest.raises(SettingsError, match="name, reach_min"):
        read_profile(
            written(tmp_path / "wrong.json", {k: v for k, v in FACTS.items() if k not in ("name", "reach_min")})
        )


def test_only_printers_with_a_file_can_be_chosen():
    assert {"replicator_2x", "replicator_dual"} <= set(printer_names())
    with pytest.raises(SettingsError, match=r"printer = 'ender' is not one of .*replicator_2x"):
        PrintSettings(printer="ender")


@pytest.mark.parametrize("name", printer_names())
def test_facts_fit_together(name):
    printer = printer_profile(name)
    for low, most_left, most_right, high in zip(
        printer.bed_min, printer.reach_min, printer.reach_max, printer.bed_max, strict=True
    ):
        assert low <= most_left < most_right <= high
    assert printer.reach_max[0] <= min(printer.reach_x_max)
    if name in MAKERBOT:
        assert printer.reach_x_max[0] - printer.reach_x_max[1] == printer.nozzle_distance_mm
    assert printer.bed_min[1] <= printer.prime_y[1] < printer.prime_y[0] - 1
    assert max(printer.prime_x) <= printer.reach_max[0]
    assert settings_for(name).printer == name


@pytest.mark.parametrize("name", MAKERBOT)
def test_every_printer_equals_gpx(name, tmp_path):
    settings = settings_for(name)
    moves = rosette(12, 200)
    path = tmp_path / "part.gcode"
    path.write_bytes(gcode_text(moves, settings, []))
    assert convert(path, settings.printer_profile.gpx_machine) == []
    data = x3g_bytes(moves, settings, "part")
    assert data == path.with_suffix(".x3g").read_bytes()
    assert audit(read_x3g(data), settings.printer_profile) == []
    read = read_gcode(path.read_bytes(), "part")
    assert read.settings.printer == name
    laid = [m.position[m.extrudes].max(axis=0) for m in (moves, read.moves, moves_of_x3g(data, "part", settings).moves)]
    np.testing.assert_allclose(laid[1:], [laid[0]] * 2, atol=0.01)
    unnamed = moves_of_x3g(data, "part")
    assert unnamed.settings.printer == name  # an X3G file does not say whose steps it counts
    np.testing.assert_allclose(unnamed.moves.position[unnamed.moves.extrudes].max(axis=0), laid[0], atol=0.01)


@pytest.mark.parametrize(("name", "at_zero", "away"), [("replicator_2x", 37, 112), ("replicator_dual", 35, 106)])
def test_nozzles_shift_at_the_rate_that_gpx_gives(name, at_zero, away):
    """Microseconds a step as GPX 2.6.8 writes them for a change of tools with all axes at zero, and with X away."""
    printer = printer_profile(name)
    assert step_interval([0, 0, 0, 0, 0], 6000, printer) == at_zero
    assert step_interval([444, 0, 0, 0, 0], 6000, printer) == away


def test_files_of_another_printer_differ():
    moves = rosette(2, 60)
    one, other = (settings_for(name) for name in ("replicator_2x", "replicator_dual"))
    assert gcode_text(moves, other, []).startswith(b";@machine r1d\n")
    assert b"G92 X152 Y75 Z0 A0 B0\n" in gcode_text(moves, other, [])
    assert x3g_bytes(moves, one) != x3g_bytes(moves, other)
    assert audit(read_x3g(x3g_bytes(moves, one)), other.printer_profile)
    shift = (35 - 33) / 100
    assert print_time(moves, one)["total"] - print_time(moves, other)["total"] == pytest.approx(shift)


def test_its_own_reach_counts():
    wide = box((-101, -20, 0), (101, 20, 1))
    assert generate(wide, PrintSettings(tower_type="none", skirts=0)).report["layers"] == 4
    with pytest.raises(MeshError, match="larger than the 200 × 140 × 150 mm"):
        generate(wide, PrintSettings(printer="replicator_dual", tower_type="none", skirts=0))
    moves = rosette(2, 60)
    moves.position[:, 0] += 72
    check(moves, PrintSettings())
    with pytest.raises(MeshError, match=r"200 × 140 × 150 mm"):
        check(moves, PrintSettings(printer="replicator_dual"))
    tower = settings_for("replicator_dual").changed({"tower_placement": "manual", "tower_x": 98})
    with pytest.raises(SettingsError, match="leaves the reach of both nozzles"):
        generate(box((-5, -5, 0), (5, 5, 1)), tower)
