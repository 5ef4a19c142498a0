"""Settings that the sidebar draws gray do nothing: whatever they are, the same moves are printed."""

from dataclasses import fields, replace

import numpy as np
import pytest

pytest.importorskip("bpy")

from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.panels.in_use import _NEEDS, in_use
from dualcolor.tests.printing import gcode_text
from dualcolor.tests.solids import lathe, picture

SHAPE = [[4, 0], [5, 1.5], [3, 2.5], [5, 3.25], [5, 4]]
TONES = np.repeat(np.array([0.0, 1.0, 0.3, 0.6])[:, None], 16, axis=1).repeat(8, axis=0)
VARIANTS = {
    "as it comes": {},
    "waves": {"pattern": "wave"},
    "waves as in the paper": {"pattern": "wave_offset", "sampling": "paper", "front": True},
    "solid": {"solid_regions": "tool_change", "infill_density": 100.0, "calibration": "none"},
    "hollow": {"infill_density": 0.0, "tower_placement": "manual", "tower_x": 40.0, "skirts": 0, "fan_speed": 50.0},
    "no tower": {"tower_type": "none", "raft_layers": 1, "slowdown_below_layer_time": 0.0, "brim_width": 3.0},
    "all of it": {
        "solid_regions": "set_back", "arrange": True, "ooze_shield": True, "brim_width": 3.0,
        "standby_temperature_delta": 60.0, "support_enable": True,
    },
    "some supports": {"support_enable": True, "support_auto": False, "support_interface_layers": 0},
}  # fmt: skip
BASES = {name: PrintSettings(**changes) for name, changes in VARIANTS.items()}


def other(declared, value):
    """Another value that the setting may have."""
    limits = declared.metadata
    if limits["choices"]:
        return next(choice for choice in limits["choices"] if choice != value)
    if isinstance(value, bool):
        return not value
    if isinstance(value, str):
        return "anything"
    low, high = limits["low"], limits["high"]
    more = min(value * 1.5 + (1 if isinstance(value, int) else 0.1), high)
    more = type(value)(more)
    return more if more != value else type(value)(low)


def printed(settings):
    """The G-code without what its header tells of the settings."""
    moves = generate(lathe(SHAPE, 16, textures=(picture(TONES),)), settings).moves
    return [line for line in gcode_text(moves, settings, []).splitlines() if not line.startswith(b";")]


@pytest.mark.parametrize("variant", VARIANTS)
def test_what_is_gray_changes_nothing(variant):
    base = BASES[variant]
    usual, wrong = printed(base), []
    for declared in fields(PrintSettings):
        if not in_use(base, declared.name):
            changed = replace(base, **{declared.name: other(declared, getattr(base, declared.name))})
            wrong += [declared.name] if printed(changed) != usual else []
    assert not wrong


def test_every_condition_is_met_and_not_met_by_some_settings():
    bases = [*BASES.values(), PrintSettings(calibration="file", calibration_file="table.json")]
    for holds, names in _NEEDS:
        assert {bool(holds(base)) for base in bases} == {True, False}, names
