"""From path to path: what is pulled back is fed again, wipes follow the line, tools change in the air."""

import re

import numpy as np
import pytest
import shapely
from dualcolor.core.paths import Feature
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.planes import Layers
from dualcolor.core.toolpaths.approach import TOWER_WIPE_MM, approaches
from dualcolor.core.toolpaths.assemble import assemble
from dualcolor.core.toolpaths.moves import Moves
from dualcolor.core.toolpaths.order import OrderedPaths
from dualcolor.core.toolpaths.travels import Travels
from dualcolor.tests.printing import gcode_text
from dualcolor.tests.solids import cylinder, joined

RING = [[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]]


def printed(lines: list, layer: list[int], feature: Feature = Feature.INNER_WALL, **settings: float) -> Moves:
    points = np.concatenate([np.asarray(line, dtype=float) for line in lines])
    start = np.concatenate([[0], np.cumsum([len(line) for line in lines])])
    apart = np.arange(len(lines))
    paths = OrderedPaths(
        points, np.full(len(points), 0.4), start, np.array(layer), np.full(len(lines), int(feature)), apart
    )
    top = 0.25 * np.arange(1, 5)
    return assemble(paths, Layers(top - 0.125, top, np.full(4, 0.25)), PrintSettings(**settings))


def approach_of(moves: Moves) -> np.ndarray:
    """The rows between the first strand and the second one."""
    laid = np.flatnonzero(moves.extrudes)
    gap = np.flatnonzero(np.diff(laid) > 1)[0]
    return np.arange(laid[gap] + 1, laid[gap + 1])


def test_a_plain_travel():
    moves = printed([RING, [[30, 0], [30, 5]]], [0, 0], retract_restart_extra=0.1, deretract_speed=10.0)
    rows = approach_of(moves)
    assert moves.feature[rows].tolist() == [Feature.RETRACT, Feature.TRAVEL, Feature.RETRACT]
    assert moves.filament[rows] == pytest.approx([-1.3, 0, 1.4])
    assert moves.speed[rows].tolist() == [25, 150, 10]
    assert moves.position[rows].tolist() == [[0, 0, 0.25], [30, 0, 0.25], [30, 0, 0.25]]


def test_each_filament_has_a_flow_and_a_diameter_of_its_own():
    flow = {"extrusion_multiplier_0": 1.1, "extrusion_multiplier_1": 0.9, "filament_diameter_1": 1.8}
    moves = printed([RING, RING], [0, 1], **flow)
    fed = [moves.filament[moves.extrudes & (moves.tool == tool)].sum() for tool in (0, 1)]
    strand = 40 * 0.4 * 0.25 / (np.pi / 4)
    assert fed == pytest.approx([1.1 * strand / 1.75**2, 0.9 * strand / 1.8**2])


def test_a_short_travel_only_moves():
    moves = printed([RING, [[1, 0], [30, 5]]], [0, 0], z_hop=1.0, wipe=2.0)
    rows = approach_of(moves)
    assert moves.feature[rows].tolist() == [Feature.TRAVEL] and moves.position[rows[0], 2] == 0.25


def test_lifted_travel():
    moves = printed([RING, [[30, 0], [30, 5]]], [0, 0], z_hop=0.5)
    rows = approach_of(moves)
    assert moves.position[rows].tolist() == [
        *([0, 0, 0.25], [0, 0, 0.75], [30, 0, 0.75]),
        *([30, 0, 0.25], [30, 0, 0.25]),
    ]
    assert moves.filament[rows] == pytest.approx([-1.3, 0, 0, 0, 1.3])


def test_closed_paths_wipe_over_their_beginning_and_open_ones_go_back():
    moves = printed([RING, [[30, 0], [30, 5]]], [0, 0], wipe=2.0)
    rows = approach_of(moves)
    assert moves.position[rows[:4], :2] == pytest.approx(np.array([[0.5, 0], [1, 0], [1.5, 0], [2, 0]]))
    assert moves.filament[rows] == pytest.approx([-0.325] * 4 + [0, 1.3])
    # 0.5 mm while 0.325 mm are pulled back at 25 mm/s
    assert moves.speed[rows[:4]] == pytest.approx(0.5 / (0.325 / 25))
    assert not moves.extrudes[rows].any()
    back = printed([[[0, 0], [10, 0], [10, 1]], [[30, 0], [30, 5]]], [0, 0], wipe=4.0)
    rows = approach_of(back)
    assert back.position[rows[:4], :2] == pytest.approx(np.array([[10, 0], [9, 0], [8, 0], [7, 0]]))


def test_a_wipe_is_no_longer_than_the_path():
    moves = printed([[[0, 0], [1, 0]], [[30, 0], [30, 5]]], [0, 0], wipe=9.0)
    assert moves.position[approach_of(moves)[3], :2] == pytest.approx([0, 0])


def test_nothing_is_pulled_back_where_the_length_is_none():
    moves = printed([RING, [[30, 0], [30, 5]]], [0, 0], wipe=2.0, retract_length=0.0)
    rows = approach_of(moves)
    assert (moves.filament[rows] == 0).all()
    assert (moves.speed[rows[:4]] == 150).all() and np.isfinite(moves.speed).all()


@pytest.mark.parametrize("wipe", [0.0, 3.0])
def test_tool_change(wipe):
    extra = {"retract_restart_extra_toolchange": 0.2, "z_hop_toolchange": 0.6, "z_hop": 0.1}
    moves = printed([RING, [[30, 0], [30, 5]]], [0, 1], wipe=wipe, **extra)
    rows = approach_of(moves)
    pulls = 4 if wipe else 1
    changed = np.flatnonzero(np.diff(moves.tool[rows])) + 1
    assert changed.tolist() == [pulls + 1]
    assert moves.filament[rows[:pulls]].sum() == pytest.approx(-4.0)
    assert moves.filament[rows[pulls:]] == pytest.approx([0, 0, 0, 4.2])
    assert moves.position[rows[pulls:], 2] == pytest.approx([0.85, 1.1, 0.5, 0.5])
    assert (moves.layer[rows] == [0] * (pulls + 1) + [1] * 3).all()
    assert moves.position[rows[pulls - 1], :2] == pytest.approx([wipe, 0])


def test_the_tower_always_wipes_on_the_way_out():
    moves = printed([RING, [[30, 0], [30, 5]]], [0, 0], feature=Feature.TOWER)
    rows = approach_of(moves)
    assert moves.position[rows[3], :2] == pytest.approx([TOWER_WIPE_MM, 0])
    assert moves.filament[rows[:4]].sum() == pytest.approx(-1.3)


@pytest.mark.parametrize("extra", [0.0, 0.15])
def test_a_whole_print_feeds_again_what_it_pulls_back(extra):
    settings = PrintSettings(
        skirt_distance=2.0,
        wipe=1.5,
        z_hop=0.3,
        retract_restart_extra=extra,
        retract_restart_extra_toolchange=2 * extra,
        only_retract_when_crossing_perimeters=False,
    )
    moves = generate(joined(cylinder(radius=5, height=2), cylinder(radius=4, height=2, x=16)), settings).moves
    pulled = np.where(moves.feature == Feature.RETRACT, moves.filament, 0.0)
    for tool in (0, 1):
        mine = moves.tool == tool
        fed = pulled[mine]
        changes = np.isclose(fed, settings.retract_length_toolchange + 2 * extra)
        travels = np.isclose(fed, settings.retract_length + extra)
        assert changes.sum() >= 3 and travels.sum() > 10
        wanted = np.cumsum(changes * 2 * extra + travels * extra)
        # Both tools come pulled back from the start of the file.
        balance = np.cumsum(fed) - (settings.retract_length, settings.retract_length_toolchange)[tool]
        laid = moves.extrudes[mine]
        assert balance[laid] == pytest.approx(wanted[laid])
    way = np.linalg.norm(np.diff(moves.position, axis=0), axis=1)
    wiping = np.flatnonzero((moves.filament[1:] < 0) & (way > 0)) + 1
    assert len(wiping) > 40
    # Where it wipes, this tool has just laid a strand of the same layer.
    for row in wiping[::7]:
        here = moves.extrudes & (moves.layer == moves.layer[row]) & (np.arange(len(moves.tool)) < row)
        rows = np.flatnonzero(here)
        strands = shapely.linestrings(np.stack([moves.position[rows - 1, :2], moves.position[rows, :2]], axis=1))
        assert shapely.distance(strands, shapely.points(moves.position[row, :2])).min() < 1e-6
    # Lifted travels pass above the layer by the hop.
    far = (moves.feature[1:] == Feature.TRAVEL) & (np.hypot(*np.diff(moves.position[:, :2], axis=0).T) > 3)
    rows = np.flatnonzero(far)[1:] + 1
    top = 0.25 * (moves.layer[rows] + 1)
    assert (moves.position[rows, 2] >= top + 0.3 - 1e-9).all()


@pytest.mark.parametrize("length", [0.0, 1.3])
def test_nothing_drips_on_the_way_from_the_priming_line_to_the_print(length):
    settings = PrintSettings(retract_length=length)
    moves = generate(cylinder(radius=5, height=1), settings).moves
    fed = np.flatnonzero(moves.filament)[0]
    assert (moves.feature[fed] == Feature.RETRACT) == (length > 0)
    if length:
        assert moves.filament[fed] == length
        np.testing.assert_array_equal(moves.position[fed], moves.position[fed - 1])
    told = gcode_text(moves, settings, []).decode().splitlines()
    begin = told.index("; layer 0")
    # The axis of the first tool before the print: one priming line, less what is pulled back until the first strand.
    counters = [float(word[1:]) for line in told[:begin] for word in line.split() if re.fullmatch(r"A\d+\.\d+", word)]
    assert counters[-1] == pytest.approx(max(counters) - length)
    first_strand = next(line for line in told[begin:] if " A" in line and " X" in line)
    assert float(first_strand.split(" A")[1].split()[0]) > max(counters)


def test_after_a_tool_change_the_nozzle_goes_straight():
    """In the air it need not go around anything, so the places on the way are those of the other travels alone."""
    lines = [[[0, 0], [10, 0]], [[30, 0], [30, 5]], [[60, 0], [60, 5]]]
    points, start = np.concatenate(lines).astype(float), np.array([0, 2, 4, 6])
    same = np.zeros(3, dtype=np.int64)
    paths = OrderedPaths(points, np.full(6, 0.4), start, same, np.full(3, int(Feature.INNER_WALL)), same)
    via = np.array([[1.0, 1], [2, 2], [3, 3]])
    ways = Travels(via, np.array([0, 0, 1, 3]), np.zeros(3, dtype=bool))
    length = np.array([10.0, 0, 5, 0, 5, 0])
    for tools, expected in (([0, 0, 0], via), ([0, 1, 1], via[1:]), ([0, 0, 1], via[:1])):
        found = approaches(paths, np.array(tools), length, ways, PrintSettings())
        assert found.places.tolist() == expected.tolist() and found.via.sum() == len(expected)
