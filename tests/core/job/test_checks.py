"""What stops a print before it becomes a file: each with one sentence that says how to mend it."""

import dataclasses

import numpy as np
import pytest
from dualcolor.core.errors import MeshError, PrintError, SettingsError
from dualcolor.core.job.checks import check
from dualcolor.core.paths import Feature
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.printing import rosette
from dualcolor.tests.solids import box

SETTINGS = PrintSettings()


def broken(column, value, row=40):
    moves = rosette(2, 100)
    changed = getattr(moves, column).copy()
    changed[row] = value
    return dataclasses.replace(moves, **{column: changed})


def test_a_sound_print_passes():
    check(rosette(2, 100), SETTINGS)


@pytest.mark.parametrize(
    ("moves", "error", "words"),
    [
        (broken("position", [0, np.nan, 1]), PrintError, "a place that is not a number: check"),
        (broken("filament", np.inf), PrintError, "a move has an amount of filament that is not a number: check"),
        (broken("speed", np.nan), PrintError, "a speed that is not a number: check"),
        (broken("speed", 0.0), PrintError, "a move has no speed: check"),
        (broken("position", [105.1, 0, 0.25]), MeshError, "takes 1.. × .* more than both nozzles reach|lies beside"),
        (broken("position", [0, -73.1, 0.25]), MeshError, "both nozzles reach"),
        (broken("position", [0, 0, 150.1]), MeshError, "more than both nozzles reach .*: scale"),
        (broken("position", [124, 0, 1], row=0), MeshError, "tool 0 would travel farther than it reaches: move"),
        (broken("position", [0, 77, 1], row=0), MeshError, "tool 0 would travel farther than it reaches: move"),
        (broken("position", [118, 0, 1], row=-1), MeshError, "tool 1 would travel farther than it reaches: move"),
        (broken("position", [0, 0, 156], row=0), MeshError, "lifted too high: lower z_hop"),
        (broken("position", [0, 0, -0.1], row=0), MeshError, "tool 0 would run into the bed: set"),
    ],
)
def test_findings_stop_the_print(moves, error, words):
    with pytest.raises(error, match=words) as caught:
        check(moves, SETTINGS)
    assert caught.value.hint
    assert "\n" not in str(caught.value)


def test_tool_0_reaches_farther_to_the_right_than_tool_1():
    check(broken("position", [118, 0, 1], row=0), SETTINGS)


SURROUNDINGS = {
    Feature.TOWER: r"the tower leaves what both nozzles reach .*: set tower_type to none",
    Feature.OOZE_SHIELD: r"the ooze shield leaves .*: lower the distance of the ooze shield",
    Feature.BRIM: r"the brim leaves .*: make the brim narrower",
    Feature.RAFT: r"the raft leaves .*: make the raft smaller",
    Feature.SKIRT: r"the skirt leaves .*: lower skirt_distance or set skirts to 0",
    Feature.SUPPORT: r"the support leaves .*: turn the object, move it",
    Feature.SUPPORT_INTERFACE: r"the support interface leaves .*: turn the object, move it",
}


@pytest.mark.parametrize("feature", SURROUNDINGS)
def test_what_surrounds_the_object_is_named(feature):
    moves = rosette(2, 100)
    tower = np.flatnonzero(moves.feature == Feature.TOWER)
    moves.feature[tower] = feature
    moves.position[tower, 0] += 80
    with pytest.raises(MeshError, match=SURROUNDINGS[feature]) as caught:
        check(moves, SETTINGS)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"brim_width": 8}, "the brim leaves"),
        ({"raft_layers": 3, "raft_margin": 8}, "the raft leaves"),
        ({"ooze_shield": True, "ooze_shield_distance": 9}, "the ooze shield leaves"),
        ({"tower_type": "w"}, "no room for the cleaning tower|the tower leaves"),
        ({}, ""),
    ],
)
def test_what_does_not_fit_around_a_large_object(changes, words):
    settings = SETTINGS.changed({"tower_type": "none", "skirts": 0, **changes})
    large = box((-98, -67, 0), (98, 67, 0.75))
    if not words:
        generate(large, settings)
        return
    with pytest.raises(MeshError, match=words) as caught:
        generate(large, settings)
    assert caught.value.hint


def test_what_is_off_the_bed_or_too_large():
    beside = box((60, -10, 0), (110, 10, 1))
    generate(beside, SETTINGS)
    with pytest.raises(MeshError, match=r"lies beyond .*: move it or turn on center_on_bed"):
        generate(beside, SETTINGS.changed({"center_on_bed": False}))
    with pytest.raises(MeshError, match=r"larger than .*: turn it by 90°"):
        generate(box((0, 0, 0), (100, 180, 1)), SETTINGS)
    with pytest.raises(
        MeshError, match=r"larger than .*: check its unit or choose its height .*Scale to Height.*--height-mm"
    ):
        generate(box((0, 0, 0), (10, 10, 151)), SETTINGS)


def test_a_print_beside_the_bed_is_moved_not_scaled():
    moves = rosette(2, 100)
    moves.position[:, 1] += 60
    with pytest.raises(MeshError, match=r"lies beside .*: move it"):
        check(moves, SETTINGS)


@pytest.mark.parametrize("name", ["retract_speed", "deretract_speed"])
def test_filament_is_pulled_no_faster_than_the_printer_can(name):
    moves = rosette(2, 100)
    with pytest.raises(SettingsError, match=f"{name} = 45 mm/s is more than the printer does: set it to 26 mm/s"):
        check(moves, SETTINGS.changed({name: 45}))
    check(moves, SETTINGS.changed({name: 45, "printer": "marlin_dual", "bed_temperature": 60}))


@pytest.mark.parametrize("name", ["nozzle_temperature_0", "nozzle_temperature_1"])
def test_nothing_is_pressed_through_a_cold_nozzle(name):
    for cold in (name, name.replace("nozzle", "first_layer")):
        with pytest.raises(SettingsError, match=f"{cold} = 100 °C cannot print: set it between 170 and 280 °C"):
            check(rosette(2, 100), SETTINGS.changed({cold: 100}))
    bed = SETTINGS.changed({"printer": "marlin_dual", "bed_temperature": 100, "first_layer_bed_temperature": 125})
    with pytest.raises(SettingsError, match="first_layer_bed_temperature = 125 °C is too hot"):
        check(rosette(2, 100), bed)
    alone = rosette(1, 100)  # tool 1 stays unused and may stay cold
    check(alone, SETTINGS.changed({"nozzle_temperature_1": 0}))
    with pytest.raises(SettingsError, match="cannot print"):
        generate(box((0, 0, 0), (8, 8, 1)), SETTINGS.changed({name: 0}))
