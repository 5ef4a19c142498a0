"""The X3G file: byte for byte what GPX makes of the G-code, what the moves say, and taken apart again."""

import numpy as np
import pytest
from dualcolor.core.errors import PrintError
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.settings.presets import preset_values
from dualcolor.core.toolpaths.moves import Moves
from dualcolor.core.x3g.audit import audit
from dualcolor.core.x3g.commands import SIZES, Command
from dualcolor.core.x3g.moves import moves_of_x3g
from dualcolor.core.x3g.reader import read_x3g
from dualcolor.core.x3g.writer import x3g_bytes
from dualcolor.tests.core.x3g.x3g_simulation import print_seconds
from dualcolor.tests.gpx import convert
from dualcolor.tests.printing import OUTER_WALL, RETRACT, TRAVEL, gcode_text, print_time, rosette, table
from dualcolor.tests.real_models import obj_model

STEPS_PER_MM = np.array([88.888889, 88.888889, 400, 96.275201870, 96.275201870])


def gpx_bytes(moves, settings, tmp_path):
    path = tmp_path / "part.gcode"
    path.write_bytes(gcode_text(moves, settings, []))
    assert convert(path) == []
    return path.with_suffix(".x3g").read_bytes()


def noisy():
    """Moves of all lengths, many of them below the printer's resolution, at all speeds."""
    rng = np.random.default_rng(5)
    moves = rosette(12, 900)
    moves.position[:, :2] += rng.normal(0, 1, (len(moves.tool), 2)) * rng.choice([0, 0.003, 0.1], (len(moves.tool), 1))
    still = np.flatnonzero(moves.feature == RETRACT)
    moves.position[still] = moves.position[still - 1]
    moves.speed[:] *= rng.choice([0.01, 0.5, 1.0, 8.0], len(moves.tool))
    moves.filament[:] *= np.where(moves.feature == OUTER_WALL, rng.choice([0.01, 1, 40], len(moves.tool)), 1.0)
    return moves


def through_the_origin():
    """Tool changes where axes stand at zero, which has an influence on the interval of the shift's steps."""
    rows = []
    for layer, (x, y) in enumerate([(0, 0), (0, 5), (5, 0), (-3, -4)]):
        rows += [(x, y, 0.25, layer % 2, TRAVEL, layer, 100, 0), (x + 9, y, 0.25, layer % 2, OUTER_WALL, layer, 30, 1)]
        rows.append((x, y, 0.25, layer % 2, TRAVEL, layer, 100, 0))
    return table(*rows)


def alone(tool):
    return table((0, 0, 0.25, tool, TRAVEL, 0, 100, 0), (9, 0, 0.25, tool, OUTER_WALL, 0, 30, 1))


SETTINGS = PrintSettings()
PRINTS = {
    "rosette": (rosette(30, 120), SETTINGS),
    "noisy": (noisy(), SETTINGS),
    "zero": (through_the_origin(), SETTINGS),
    "right": (alone(0), SETTINGS),
    "hotter first layer": (
        rosette(4, 9),
        SETTINGS.changed({"first_layer_temperature_0": 245, "first_layer_bed_temperature": 120}),
    ),
    "fan": (rosette(6, 30), SETTINGS.changed({"fan_speed": 60})),
    "left": (
        alone(1),
        SETTINGS.changed({"nozzle_temperature_1": 100, "bed_temperature": 0, "first_layer_height": 0.2}),
    ),
}


@pytest.mark.parametrize("name", PRINTS)
def test_equals_gpx(name, tmp_path):
    moves, settings = PRINTS[name]
    assert x3g_bytes(moves, settings, "part") == gpx_bytes(moves, settings, tmp_path)


@pytest.fixture(scope="module")
def spot(data):
    return generate(obj_model(data / "meshes" / "spot" / "spot.obj", 15.0), SETTINGS).moves


def test_real_mesh_equals_gpx_and_passes_the_audit(spot, tmp_path):
    mine = x3g_bytes(spot, SETTINGS, "part")
    assert mine == gpx_bytes(spot, SETTINGS, tmp_path)
    assert audit(read_x3g(mine), SETTINGS.printer_profile) == []


def test_estimate_agrees_with_a_simulation_of_the_file(spot):
    for moves in (spot, rosette(6, 400)):
        simulated = print_seconds(read_x3g(x3g_bytes(moves, SETTINGS)))
        assert print_time(moves, SETTINGS)["total"] == pytest.approx(simulated, rel=0.02)


@pytest.mark.parametrize(
    ("mesh", "preset"),
    [("cat-low-resolution", "set_back"), ("koala_low_resolution", "paper"), ("nc/gargoyle", "set_back")],
)
def test_estimate_of_real_meshes_agrees_too(data, mesh, preset):
    settings = PrintSettings(support_enable=True).changed(preset_values([preset]))
    moves = generate(obj_model(data / "meshes" / f"{mesh}.obj", 10.0), settings).moves
    estimate, simulated = print_time(moves, settings)["total"], print_seconds(read_x3g(x3g_bytes(moves, settings)))
    assert estimate == pytest.approx(simulated, rel=0.05)


def test_file_says_what_the_moves_say():
    moves = rosette(8, 300)
    commands = read_x3g(x3g_bytes(moves, SETTINGS, "W\u00fcrfel\n" + "x" * 40))
    printed = np.flatnonzero(commands.code == Command.MOVE)[-len(moves.tool) - 2 : -2]
    np.testing.assert_array_equal(commands.tool[printed], moves.tool)
    assert commands.known[printed].all()
    place = commands.steps[printed] / STEPS_PER_MM
    assert np.abs(place[:, :3] - moves.position).max() < 0.0005 + 0.5 / 88
    for tool in (0, 1):
        mine = moves.tool == tool
        fed = np.cumsum(moves.filament[mine])
        counter = -place[mine, 3 + tool]
        assert np.abs((counter - counter[0]) - (fed - fed[0])).max() < 1.5 / 96  # no drift over all roundings
    np.testing.assert_allclose(commands.speed[printed], moves.speed, atol=1 / 60 + 1 / 64)
    way = np.linalg.norm(np.diff(moves.position, axis=0), axis=1)
    way = np.where(way > 0, way, np.abs(moves.filament[1:]))
    np.testing.assert_allclose(commands.distance[printed[1:]], way, atol=0.002)
    changes = np.flatnonzero(commands.code == Command.CHANGE_TOOL)
    assert (commands.code[changes[1:] + 1] == Command.MOVE_UNPLANNED).all()
    assert len(changes) == 1 + 2 + 7
    assert bytes(commands.data[commands.offset[0] + 5 :][:25]) == b"W?rfel?" + b"x" * 17 + b"\0"


def test_heaters_and_frame():
    settings = SETTINGS.changed({"nozzle_temperature_0": 215, "nozzle_temperature_1": 260, "bed_temperature": 105})
    commands = read_x3g(x3g_bytes(rosette(2, 9), settings))
    heat = np.flatnonzero(commands.code == Command.TOOL_ACTION)
    said = [commands.argument(heat, byte).tolist() for byte in (2, 1, 4, 5)]
    targets = [(action, tool, low + 256 * high) for action, tool, low, high in zip(*said, strict=True)]
    heating = [(31, 0, 105), (3, 0, 140), (3, 1, 140), (3, 0, 215), (3, 1, 260)]
    assert targets == [*heating, (31, 0, 0), (3, 0, 0), (3, 1, 0)]
    assert [commands.code[0], *commands.code[-3:]] == [Command.BUILD_START, *(Command(c) for c in (150, 154, 151))]
    percent = commands.argument(np.flatnonzero(commands.code == Command.PROGRESS), 1)
    assert percent[0] == 0 and percent[-1] == 100 and (np.diff(percent) > 0).all()


def test_no_moves_is_a_mistake_of_the_program():
    with pytest.raises(ValueError, match="no moves"):
        x3g_bytes(Moves(*(column[:0] for column in vars(rosette(1, 9)).values())), SETTINGS)


def test_reader_follows_relative_and_lost_axes():
    def point(code, steps, mask=None):
        body = bytes([code]) + np.array(steps, dtype="<i4").tobytes()
        body += b"" if code == Command.SET_POSITION else bytes(4)
        return body if mask is None else body + bytes([mask])

    recall, message = bytes([144, 0b00011]), bytes([149, 0, 0, 0, 0]) + b"hello\0"
    file = point(140, [10, 20, 30, 0, 0]) + point(142, [5, 5, 5, 5, 5], 0b11001) + message
    file += point(142, [1, 1, 1, 1, 1], 0b11111) + recall + point(139, [7, 7, 7, 7, 7])
    commands = read_x3g(file)
    assert commands.code.tolist() == [140, 142, 149, 142, 144, 139]
    assert commands.steps[1].tolist() == [15, 5, 5, 5, 5]
    assert commands.steps[3].tolist() == [16, 6, 6, 6, 6]
    assert commands.known[4].tolist() == [False, False, True, True, True]
    assert commands.way[5].tolist() == [0, 0, 1, 1, 1]
    assert commands.steps[5].tolist() == [7] * 5


@pytest.mark.parametrize("seed", range(3))
def test_damaged_files_give_one_sentence(seed):
    rng = np.random.default_rng(seed)
    whole = bytearray(x3g_bytes(rosette(2, 20), SETTINGS, "part"))
    for _ in range(150):
        damaged = bytearray(whole)
        for place in rng.integers(0, len(whole), rng.integers(1, 6)):
            damaged[place] = rng.integers(0, 256)
        damaged = bytes(damaged[: rng.integers(1, len(whole) + 1)])
        try:
            audit(read_x3g(damaged), SETTINGS.printer_profile)
        except PrintError as error:
            assert "X3G" in error.message and "\n" not in str(error)
    for kind, text in {
        b"": "empty",
        bytes(whole[:-1]): "breaks off",
        b"G1 X5\n": "damaged",
        b"\x86\x05": "tool 5",
    }.items():
        with pytest.raises(PrintError, match=text):
            read_x3g(kind)


def test_a_file_that_ends_after_any_command_is_read_or_has_no_plastic():
    whole = x3g_bytes(rosette(2, 20), SETTINGS, "part")
    laid = 0
    for end in read_x3g(whole).offset[1:].tolist():
        try:
            laid = int(moves_of_x3g(whole[:end], "part").moves.extrudes.sum())
        except PrintError as error:
            assert "no plastic" in error.message and not laid
    assert laid == moves_of_x3g(whole, "part").moves.extrudes.sum() > 10


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize("length", [1e-40, -1.0, 0.0, 3e38])
def test_lengths_that_a_file_makes_up_change_nothing_that_is_laid_down(length):
    whole = np.frombuffer(x3g_bytes(rosette(2, 20), SETTINGS, "part"), dtype=np.uint8).copy()
    commands = read_x3g(whole.tobytes())
    strand = np.flatnonzero(np.isfinite(commands.distance) & (commands.way[:, :2] != 0).any(axis=1))
    said = commands.distance[strand].astype("<f4").view(np.uint8).reshape(-1, 4)
    within = next(at for at in range(32) if (whole[commands.offset[strand, None] + at + np.arange(4)] == said).all())
    expected = moves_of_x3g(whole.tobytes(), "part").moves
    whole[commands.offset[strand, None] + within + np.arange(4)] = np.array([length], dtype="<f4").view(np.uint8)
    found = moves_of_x3g(whole.tobytes(), "part").moves
    assert (found.position == expected.position).all() and (found.filament == expected.filament).all()


@pytest.mark.parametrize("code", sorted(SIZES))
def test_cut_off_commands(code):
    for size in range(1, SIZES[code]):
        with pytest.raises(PrintError):
            read_x3g(bytes([Command.PROGRESS, 0, 0, code]) + bytes([65] * (size - 1)))
