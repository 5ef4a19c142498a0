"""What stops a print before it becomes a file: each with one sentence that says how to mend it."""

import dataclasses

import numpy as np
import pytest
from dualcolor.core.checks import check
from dualcolor.core.errors import MeshError, PrintError, SettingsError
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.toolpaths.moves import Feature
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
        (broken("filament", np.inf), PrintError, "an? amount of filament that is not a number: check"),
        (broken("speed", np.nan), PrintError, "a speed that is not a number: check"),
        (broken("speed", 0.0), PrintError, "a move has no speed: check"),
        (broken("position", [105.1, 0, 0.25]), MeshError, "takes 1.. × .* more than both nozzles reach|lies beside"),
        (broken("position", [0, -73.1, 0.25]), MeshError, "both nozzles reach"),
        (broken("position", [0, 0, 150.1]), MeshError, "more than both nozzles reach .*: scale"),
        (broken("position", [130, 0, 1], row=0), MeshError, "travel beyond the bed: "),
    ],
)
def test_findings_stop_the_print(moves, error, words):
    with pytest.raises(error, match=words) as caught:
        check(moves, SETTINGS)
    assert caught.value.hint
    assert "\n" not in str(caught.value)


def test_what_surrounds_the_object_is_named():
    moves = rosette(2, 100)
    tower = moves.feature == Feature.TOWER
    moves.position[np.flatnonzero(tower), 0] += 100
    with pytest.raises(MeshError, match=r"the tower leaves what both nozzles reach .*: set tower_type to none"):
        check(moves, SETTINGS)


def test_a_print_beside_the_bed_is_moved_not_scaled():
    moves = rosette(2, 100)
    moves.position[:, 1] += 60
    with pytest.raises(MeshError, match=r"lies beside .*: move it"):
        check(moves, SETTINGS)


@pytest.mark.parametrize("name", ["nozzle_temperature_0", "nozzle_temperature_1"])
def test_nothing_is_pressed_through_a_cold_nozzle(name):
    with pytest.raises(SettingsError, match=f"{name} = 100 °C cannot print: set it between 170 and 280 °C"):
        check(rosette(2, 100), SETTINGS.changed({name: 100}))
    alone = rosette(1, 100)  # tool 1 stays unused and may stay cold
    check(alone, SETTINGS.changed({"nozzle_temperature_1": 0}))
    with pytest.raises(SettingsError, match="cannot print"):
        generate(box((0, 0, 0), (8, 8, 1)), SETTINGS.changed({name: 0}))
