"""G-code for Marlin and Klipper, followed by a firmware of a few lines that knows nothing of the writer."""

import re
from dataclasses import dataclass, field

import numpy as np
import pytest
from dualcolor.core.errors import SettingsError
from dualcolor.core.exports import export_x3g
from dualcolor.core.paths import Feature
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.settings.presets import preset_values
from dualcolor.tests.printing import gcode_text, rosette
from dualcolor.tests.solids import box

SETTINGS = PrintSettings().changed(preset_values(["marlin_dual"]))


@dataclass
class Firmware:
    """What a printer does with a file."""

    place: np.ndarray = field(default_factory=lambda: np.zeros(3))
    tool: int = -1
    relative: bool = False
    target: dict = field(default_factory=lambda: {0: 0.0, 1: 0.0, "bed": 0.0})
    fed: dict = field(default_factory=lambda: {0: 0.0, 1: 0.0})
    laid: list = field(default_factory=list)
    changes: int = 0
    fan: dict = field(default_factory=lambda: {0: 0.0, 1: 0.0})
    blown: list = field(default_factory=list)
    switched_on: int = 0
    printing: bool = False
    primed: list = field(default_factory=list)
    acceleration: dict = field(default_factory=dict)
    waiting_for_bed: list = field(default_factory=list)
    left: list = field(default_factory=list)
    changed_at: list = field(default_factory=list)
    went_on_at: list = field(default_factory=list)

    def run(self, text):
        for line in text.splitlines():
            words = line.split(";")[0].split()
            self.printing |= line.startswith("; layer ")
            if words:
                self.obey(words[0], {word[0]: float(word[1:] or 0) for word in words[1:]})
        return self

    def obey(self, command, values):
        if command == "M83":
            self.relative = True
        elif command in ("M104", "M109"):
            self.target[int(values["T"])] = values["S"]
        elif command in ("M140", "M190"):
            self.target["bed"] = values["S"]
            if command == "M190":
                self.waiting_for_bed = [self.target[0], self.target[1], self.place[2]]
        elif command in ("T0", "T1"):
            if self.laid and self.tool != int(command[1]):
                self.changes += 1
                self.changed_at.append(self.place.copy())
            self.tool = int(command[1])
        elif command in ("M106", "M107"):
            self.switched_on += command == "M106"
            self.fan[int(values.get("P", max(self.tool, 0)))] = values.get("S", 255.0) if command == "M106" else 0.0
        elif command == "G1":
            self.move(values)
        elif command == "M204":
            self.acceleration = values
        elif command == "M73":
            self.left.append((values["P"], values["R"]))
        else:
            assert command in ("G21", "G90", "G91", "G28", "M84"), command

    def move(self, values):
        begin = self.place.copy()
        for axis, letter in enumerate("XYZ"):
            self.place[axis] = values.get(letter, self.place[axis])
        if "E" in values:
            assert self.relative and self.target[self.tool] >= 170
            self.fed[self.tool] += values["E"]
            if not self.printing:
                self.primed.append((self.tool, *begin[:2], *self.place, values["E"]))
            elif values["E"] > 0 and (begin[:2] != self.place[:2]).any():
                if len(self.changed_at) > len(self.went_on_at):
                    self.went_on_at.append(begin)
                self.laid.append((self.tool, *self.place, values["E"]))
                self.blown.append(self.fan[self.tool])


def test_plastic_goes_where_the_moves_say():
    moves = rosette(12, 200)
    told = Firmware().run(gcode_text(moves, SETTINGS, []).decode())
    laid = np.array(told.laid)
    rows = moves.extrudes
    assert len(laid) == rows.sum()
    np.testing.assert_array_equal(laid[:, 0], moves.tool[rows])
    np.testing.assert_allclose(laid[:, 1:4], moves.position[rows] + [117.5, 117.5, 0], atol=0.0006)
    for tool in (0, 1):
        mine = laid[:, 0] == tool
        wanted = moves.filament[rows & (moves.tool == tool)].sum()
        assert laid[mine, 4].sum() == pytest.approx(wanted, abs=2e-5)  # roundings of single moves do not add up


def test_viewers_find_layers_and_features():
    """PrusaSlicer's words, before the lines that they are about; in MakerBot's dialect, which it cannot read, none."""
    settings = SETTINGS.changed({"raft_layers": 2, "ooze_shield": True, "z_hop": 1.0, "brim_width": 1.0})
    moves = generate(box((0, 0, 0), (14, 14, 2)), settings).moves
    kind, height, found = "", 0.0, []
    place, laid = [0.0, 0.0, 0.0], moves.extrudes
    for line in gcode_text(moves, settings, []).decode().split(";LAYER_CHANGE\n", 1)[1].splitlines():
        kind = line[6:] if line.startswith(";TYPE:") else kind
        height = float(line[3:]) if line.startswith(";Z:") else height
        values = {word[0]: float(word[1:]) for word in line.split()[1:]} if line.startswith("G1 ") else {}
        before = list(place)
        place = [values.get(axis, old) for axis, old in zip("XYZ", place, strict=True)]
        if values.get("E", 0) > 0 and place != before:
            assert place[2] == height
            found.append(kind)
    assert len(found) == laid.sum()
    pairs = set(zip(found, moves.feature[laid].tolist(), strict=True))
    assert len(pairs) == len(np.unique(moves.feature[laid])) >= 8
    assert {("External perimeter", Feature.OUTER_WALL), ("Perimeter", Feature.INNER_WALL)} <= pairs
    assert {("Wipe tower", Feature.TOWER), ("Skirt/Brim", Feature.BRIM), ("Support material", Feature.RAFT)} <= pairs
    assert b";TYPE" not in gcode_text(moves, PrintSettings(), [])


def test_a_whole_print_heats_changes_tools_and_cools():
    result = generate(box((0, 0, 0), (12, 12, 3)), SETTINGS)
    text = gcode_text(result.moves, SETTINGS, []).decode()
    told = Firmware().run(text)
    assert told.changes == result.report["layers"] - 1
    assert told.target == {0: 0, 1: 0, "bed": 0}
    assert told.acceleration == dict.fromkeys("PT", SETTINGS.printer_profile.acceleration_mm_s2[0])
    assert not re.search(r"^(M13[2-7]|G16|.* [AB]-?\d)", text, re.MULTILINE)
    places = np.array(told.laid)[:, 1:3]
    assert places.min() > 0 and places.max() < 235


def test_nozzles_do_not_drip_on_the_bed_while_it_heats():
    told = Firmware().run(gcode_text(rosette(12, 200), SETTINGS, []).decode())
    assert told.waiting_for_bed == [140, 140, 10]
    cool = SETTINGS.changed({"nozzle_temperature_0": 120})
    text = gcode_text(rosette(12, 200), cool, []).decode()
    assert "\nM104 T0 S120\nM104 T1 S140\n" in text


def test_a_nozzle_that_is_not_used_stays_cold():
    moves = rosette(6, 50)
    moves.tool[:] = 1
    text = gcode_text(moves, SETTINGS, []).decode()
    assert set(re.findall(r"^M10[49] T0 S(\d+)$", text, re.MULTILINE)) == {"0"}
    assert "M109 T1 S235" in text


def test_the_minutes_that_are_left_count_down_to_none():
    begins = np.array([0.0, 250.0, 600.0, 1000.0])
    told = Firmware().run(gcode_text(rosette(3, 40), SETTINGS, [], begins).decode())
    assert told.left == [(0, 17), (25, 13), (60, 7), (100, 0)]


@pytest.mark.parametrize("tower", ["w", "none"])
def test_tools_change_above_where_the_print_goes_on(tower):
    """The firmware brings the other nozzle there at once, and it may drip: not over what was printed last."""
    settings = SETTINGS.changed({"tower_type": tower, "standby_temperature_delta": 30})
    result = generate(box((0, 0, 0), (12, 12, 3)), settings)
    told = Firmware().run(gcode_text(result.moves, settings, []).decode())
    lift = np.array(told.changed_at) - told.went_on_at
    assert len(lift) == result.report["tool_changes"]
    assert lift == pytest.approx(np.tile([0, 0, settings.z_hop_toolchange], (len(lift), 1)), abs=1e-6)


@pytest.mark.parametrize("side", [12, 210])
def test_both_nozzles_are_primed_beside_the_print_and_left_pulled_back(side):
    settings = SETTINGS.changed({"skirts": 0, "tower_type": "none", "tower_distance": 1.0})
    result = generate(box((0, 0, 0), (side, side, 1)), settings)
    told = Firmware().run(gcode_text(result.moves, settings, []).decode())
    (lines, pulls) = [[row for row in told.primed if (row[1:3] != row[3:5]) == moves] for moves in (True, False)]
    assert [row[0] for row in lines] == [1, 0] and [row[0] for row in pulls] == [1, 0]
    assert [row[-1] for row in pulls] == [-settings.retract_length_toolchange, -settings.retract_length]
    front = np.array(told.laid)[:, 2].min()
    for _, from_x, from_y, x, y, z, fed in lines:
        assert from_y == y and 0 < y < front - 1  # in front of all that is printed
        assert min(from_x, x) > 0 and max(from_x, x) < 235 and abs(x - from_x) > 50
        assert z == settings.first_layer_height
        assert fed * np.pi / 4 * 1.75**2 == pytest.approx(abs(x - from_x) * z * 1.0, rel=1e-3)  # 1 mm wide


@pytest.mark.parametrize(("layers", "percent"), [(1, 50.0), (0, 100.0), (3, 20.0), (1000, 100.0)])
def test_the_fan_of_the_printing_nozzle_blows_from_a_layer_on(layers, percent):
    settings = SETTINGS.changed({"fan_speed": percent, "disable_fan_first_layers": layers})
    moves = rosette(12, 200)
    told = Firmware().run(gcode_text(moves, settings, []).decode())
    layer = moves.layer[moves.extrudes]
    np.testing.assert_array_equal(told.blown, np.where(layer >= layers, round(percent * 2.55), 0))
    assert told.fan == {0: 0, 1: 0}
    assert told.switched_on == max(12 - layers, 0)  # once a layer, each of which has the other tool


def test_the_fan_starts_within_the_print_of_a_single_tool():
    moves = rosette(6, 50)
    moves.tool[:] = 0
    told = Firmware().run(
        gcode_text(moves, SETTINGS.changed({"fan_speed": 100, "disable_fan_first_layers": 2}), []).decode()
    )
    np.testing.assert_array_equal(told.blown, np.where(moves.layer[moves.extrudes] >= 2, 255, 0))
    assert told.switched_on == 1


@pytest.mark.parametrize(("usual", "bridging"), [(0, 60), (40, 100), (80, 20)])
def test_bridges_get_more_air(usual, bridging):
    settings = SETTINGS.changed({"fan_speed": usual, "bridge_fan_speed": bridging, "disable_fan_first_layers": 2})
    moves = rosette(30, 40)
    strands = np.flatnonzero(moves.extrudes)
    spanning = np.repeat(np.random.default_rng(5).random(len(strands) // 17 + 1) < 0.3, 17)[: len(strands)]
    moves.feature[strands[spanning]] = Feature.BRIDGE
    told = Firmware().run(gcode_text(moves, settings, []).decode())
    speed = np.where(spanning, max(usual, bridging), usual) * (moves.layer[strands] >= 2)
    np.testing.assert_array_equal(told.blown, np.round(speed * 2.55))
    assert told.fan == {0: 0, 1: 0}


def test_the_fan_is_left_alone_where_it_is_off():
    moves = rosette(4, 50)
    start, text = gcode_text(moves, SETTINGS, []).split(b"; layer 0")
    assert b"\nM107\n" in start and b"M106" not in start  # an aborted print may have left it on
    assert b"M10" not in text.replace(b"M104", b"").replace(b"M109", b"")
    assert b"\nM12" not in gcode_text(moves, PrintSettings(), [])
    assert preset_values(["pla"])["fan_speed"] == 100 and preset_values(["abs_black"])["fan_speed"] == 0


@pytest.mark.parametrize(("usual", "bridging"), [(100, 0), (0, 60), (30, 60)])
def test_a_replicator_switches_its_fan_on_and_off(usual, bridging):
    settings = PrintSettings(fan_speed=usual, bridge_fan_speed=bridging, disable_fan_first_layers=2)
    moves = rosette(6, 40)
    strands = np.flatnonzero(moves.extrudes)
    spanning = np.arange(len(strands)) % 50 < 10
    moves.feature[strands[spanning]] = Feature.BRIDGE
    blows, printing, found = False, False, []
    for line in gcode_text(moves, settings, []).decode().splitlines():
        printing |= line == "; layer 0"
        blows = {"M126 T0": True, "M127 T0": False}.get(line, blows)
        if printing and line.startswith("G1 ") and ("A" in line or "B" in line) and ("X" in line or "Y" in line):
            found.append(blows)
    late = moves.layer[strands] >= 2
    np.testing.assert_array_equal(found, late & (spanning | bool(usual)))
    assert not blows


def test_the_fan_and_a_colder_nozzle_get_along():
    settings = SETTINGS.changed({"fan_speed": 100, "standby_temperature_delta": 40})
    moves = rosette(12, 4000)
    told = Firmware().run(gcode_text(moves, settings, []).decode())
    np.testing.assert_array_equal(told.blown, np.where(moves.layer[moves.extrudes] >= 1, 255, 0))


def test_x3g_is_refused(tmp_path):
    result = generate(box((0, 0, 0), (12, 12, 1)), SETTINGS)
    with pytest.raises(SettingsError, match="does not read X3G"):
        export_x3g(result, tmp_path / "part.x3g")
    assert not list(tmp_path.iterdir())
