"""The audit of X3G files: silent on good ones, and on broken ones the sentence that fits and no other."""

import struct

import numpy as np
import pytest
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.x3g.audit import audit
from dualcolor.core.x3g.commands import MOVE, Command
from dualcolor.core.x3g.reader import read_x3g
from dualcolor.core.x3g.writer import x3g_bytes
from dualcolor.tests.printing import OUTER_WALL, RETRACT, TOWER, TRAVEL, rosette, table
from dualcolor.tests.solids import lathe

SETTINGS = PrintSettings()
TOWER_BOX = np.array([[29.0, -1.0], [31.0, 9.0]])


def pieces(moves=None, settings=SETTINGS):
    """The commands of a good file, one bytes object each."""
    commands = read_x3g(x3g_bytes(rosette(4, 30) if moves is None else moves, settings))
    ends = [*commands.offset[1:].tolist(), len(commands.data)]
    return [commands.data[a:b].tobytes() for a, b in zip(commands.offset.tolist(), ends, strict=True)]


def findings(parts, tower=None):
    return audit(read_x3g(b"".join(parts)), SETTINGS.printer_profile, tower)


def record(part):
    return np.frombuffer(part, dtype=MOVE).copy()


def strand(parts, which):
    """Index of one of the moves that lay a strand in the print, counted from its end."""
    fed = [i for i, part in enumerate(parts) if part[0] == Command.MOVE and record(part)["steps"][0, 3:].any()]
    return fed[which]


def heater(tool, celsius, action=3):
    return struct.pack("<BBBBH", Command.TOOL_ACTION, tool, action, 2, celsius)


def only(found, text):
    assert len(found) == 1 and text in found[0], found


def test_good_files_have_no_findings():
    assert findings(pieces(), TOWER_BOX) == []
    assert findings(pieces(settings=SETTINGS.changed({"bed_temperature": 0}))) == []


def test_cold():
    parts = pieces()
    last = strand(parts, -10)
    only(
        findings([*parts[:last], heater(0, 120), heater(1, 120), *parts[last:]]),
        "tool 1 moves its filament while it is cold",
    )
    unwaited = [part for part in parts if part[:2] != bytes([Command.WAIT_FOR_TOOL, 1])]
    only(findings(unwaited), "tool 1 moves its filament while it is cold")
    wait = parts.index(next(part for part in parts if part[:2] == bytes([Command.WAIT_FOR_TOOL, 0])))
    hot = parts.index(heater(0, 230))
    early = [*parts[:hot], parts[wait], *parts[hot:wait], *parts[wait + 1 :]]  # waits for the warm-up only
    only(findings(early), "tool 0 moves its filament while it is cold")
    only(findings([part for part in parts if part[0] != Command.WAIT_FOR_BED]), "before the bed is warm")
    cooler = [*parts[:last], heater(0, 200), heater(1, 200), *parts[last:]]  # a standby temperature is no fault
    assert findings(cooler) == []


def test_heaters():
    parts = pieces()
    only(findings([part for part in parts if part != heater(1, 0)]), "tool 1 is still heated to 235 °C")
    only(findings([part for part in parts if part != heater(0, 0, 31)]), "the bed is still heated to 110 °C")
    only(findings([heater(1, 300), *parts]), "tool 1 is heated to 300 °C")
    only(findings([heater(0, 140, 31), *parts]), "the bed is heated to 140 °C")


@pytest.mark.parametrize(
    ("axis", "steps", "also_off_the_bed"), [(0, 9400, False), (1, -7000, True), (2, -40, True), (2, 60100, False)]
)
def test_out_of_bounds(axis, steps, also_off_the_bed):
    parts = pieces()
    at = strand(parts, -25)
    moved = record(parts[at])
    moved["steps"][0, axis] = steps
    found = findings([*parts[:at], moved.tobytes(), *parts[at + 1 :]])
    where = [text for text in found if "long" not in text and "faster" not in text]
    assert "outside the reach" in where[0]
    assert [("leaves the printer's space" in text) for text in where[1:]] == [True] * also_off_the_bed


def test_strand_that_comes_from_outside():
    reach = [(x, 0, 0.25, 0, feature, 0, 60, fed) for x, feature, fed in ((108, TRAVEL, 0), (90, OUTER_WALL, 0.6))]
    only(findings(pieces(table(*reach))), "outside the reach of both nozzles once")


def test_travel_out_of_bounds():
    parts = pieces()
    at = next(i for i, part in enumerate(parts) if part[0] == Command.MOVE and record(part)["distance"] > 200)
    far = record(parts[at])
    far["steps"][0, 1] = -7200
    assert any(
        "leaves the printer's space" in text for text in findings([*parts[:at], far.tobytes(), *parts[at + 1 :]])
    )


def test_wrong_axis():
    parts = pieces()
    at = strand(parts, -25)
    moved = record(parts[at])
    moved["steps"][0, 3] = -5
    only(findings([*parts[:at], moved.tobytes(), *parts[at + 1 :]]), "filament axis A moves while tool 0 is not")
    first = next(i for i, part in enumerate(parts) if part[0] == Command.CHANGE_TOOL and part[1] == 1)
    assert "filament axis B moves while tool 1 is not" in findings([*parts[:first], *parts[first + 1 :]])[0]


def test_tool_change_without_a_move():
    parts = pieces()
    change = [i for i, part in enumerate(parts) if part[0] == Command.CHANGE_TOOL][-1]
    feeding = record(parts[strand(parts, -25)])
    feeding["steps"][0] = [2700, 0, 560, 0, -40]
    feeding["distance"] = 10.0
    found = findings([*parts[: change + 1], feeding.tobytes(), *parts[change + 1 :]])
    assert any("the move after a tool change" in text for text in found), found


def test_strand_without_prime():
    moves = rosette(4, 30)
    prime = np.flatnonzero((moves.feature == RETRACT) & (moves.filament > 0))[1]
    moves.filament[prime] = 3.0
    only(findings(pieces(moves)), "a strand of tool 0 begins while its filament is pulled back")


def test_part_before_tower():
    moves = table(
        (30, 0, 0.25, 0, TRAVEL, 0, 150, 0),
        (30, 8, 0.25, 0, TOWER, 0, 60, 0.33),
        (5, 5, 0.5, 1, TRAVEL, 1, 150, 0),
        (9, 5, 0.5, 1, OUTER_WALL, 1, 30, 0.2),
        (30, 0, 0.5, 1, TRAVEL, 1, 150, 0),
        (30, 8, 0.5, 1, TOWER, 1, 60, 0.33),
    )
    assert findings(pieces(moves)) == []
    only(findings(pieces(moves), TOWER_BOX), "does not begin at the cleaning tower")


def test_moves_that_say_something_wrong():
    parts = pieces()
    at = strand(parts, -25)
    for field, value, text in (
        ("distance", np.nan, "no length or no speed"),
        ("distance", np.inf, "no length or no speed"),
        ("speed", 0, "no length or no speed"),
        ("distance", 40.0, "not as long as it says"),
        ("distance", record(parts[at])["distance"] + 0.2, "not as long as it says"),
        ("speed", 400 * 64 + 1, "faster than it can"),
    ):
        broken = record(parts[at])
        broken[field] = value
        only(findings([*parts[:at], broken.tobytes(), *parts[at + 1 :]]), text)


def test_a_wipe_of_hardly_any_length_is_sound():
    """A stub so thin that what is wiped over is shorter than a step of the motors."""
    stub = lathe([[0.3, 0], [0.375, 0.5], [2, 1]], 5)
    settings = PrintSettings(wavelength=0.5, pattern="wave", wipe=1.0, avoid_crossing_perimeters=False)
    settings = settings.changed({"first_layer_height": 0.35})
    assert not findings(pieces(generate(stub, settings).moves, settings))


def test_frame_of_the_build():
    parts = pieces()
    only(findings(parts[:-2]), "starts 1 times and ends 0 times")
    only(findings([parts[-2], *parts[:-2]]), "moves outside the build")
    unhomed = [part for part in parts if part[0] != Command.HOME_MAXIMUM]
    only(findings(unhomed), "nobody knows where it is")
    places = [i for i, part in enumerate(parts) if part[0] == Command.SET_POSITION]
    found = findings([*parts[: places[1]], *parts[places[1] + 1 :]])
    assert any("nobody knows where it is" in text for text in found)


def test_file_cut_short_between_commands():
    parts = pieces()
    for end in (1, 5, len(parts) // 2, len(parts) - 12, len(parts) - 3, len(parts) - 2):
        found = findings(parts[:end])
        assert any("ends 0 times" in text for text in found), (end, found)
    printing = findings(parts[: len(parts) // 2])
    assert {text.split(" is still")[0] for text in printing if "still heated" in text} == {
        "tool 0",
        "tool 1",
        "the bed",
    }


def test_too_much_filament():
    parts = pieces(table((0, 0, 0.25, 0, TRAVEL, 0, 100, 0), (20, 0, 0.25, 0, OUTER_WALL, 0, 5, 10.0)))
    assert findings(parts) == []
    parts = pieces(table((0, 0, 0.25, 0, TRAVEL, 0, 100, 0), (20, 0, 0.25, 0, OUTER_WALL, 0, 5, 14.0)))
    only(findings(parts), "more filament than any nozzle can lay once")


def test_motors_let_go_in_the_middle():
    parts = pieces()
    at = strand(parts, -25)
    off, on = (bytes([Command.SWITCH_AXES, mask]) for mask in (0b00001, 0b10000001))
    only(findings([*parts[:at], off, *parts[at:]]), "an axis moves after its motor was let go")
    assert findings([*parts[:at], on, *parts[at:]]) == []
    released = [*parts, off]
    assert not any("let go" in text for text in findings(released))


@pytest.mark.parametrize(
    ("command", "text"), [(bytes([152, 0]), "resets the printer"), (bytes([143, 31]), "overwrites the printer's home")]
)
def test_commands_that_change_the_printer(command, text):
    parts = pieces()
    only(findings([*parts[:9], command, *parts[9:]]), text)
