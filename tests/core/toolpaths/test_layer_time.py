"""Layers that would be printed too fast to set are slowed: by how much, which lines, and what counts."""

import numpy as np
import pytest
from dualcolor.core.paths import Feature
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.statistics import single_color
from dualcolor.core.toolpaths.layer_time import layer_time_warnings, slow_short_layers
from dualcolor.core.toolpaths.move_times import move_seconds
from dualcolor.tests.printing import OUTER_WALL, RETRACT, TRAVEL, table
from dualcolor.tests.solids import box, cylinder, lathe

SETTINGS = PrintSettings(slowdown_below_layer_time=10.0, min_print_speed=5.0)
HURRIED = SETTINGS.changed({"slowdown_below_layer_time": 0})
CUBE = box([0, 0, 0], [4, 4, 4])


def layer_seconds(moves, settings):
    return np.bincount(moves.layer, move_seconds(moves, settings.printer_profile))


def slowed(moves, settings=SETTINGS):
    slow_short_layers(moves, np.unique(moves.layer), settings)
    return moves


def test_a_line_takes_the_time_of_its_layer():
    """100 mm in 10 s; starting and stopping costs nothing at 10 mm/s, which an axis may jump by."""
    moves = slowed(table((0, 0, 0.25, 0, TRAVEL, 0, 150, 0), (100, 0, 0.25, 0, OUTER_WALL, 0, 60, 3.3)))
    assert moves.speed == pytest.approx([150, 10], rel=0.01)


def test_the_fastest_lines_give_way_first_and_no_more_than_needed():
    """In 10 s: 20 mm at 4 mm/s take 5 s, 30 mm of bridge at 30 mm/s take 1 s, the other 80 mm the 4 s that remain."""
    lengths, speeds = [20, 40, 30, 40], [4, 60, 30, 25]
    features = [OUTER_WALL, Feature.INFILL, Feature.BRIDGE, Feature.TOWER]
    ends = np.cumsum(lengths)
    rows = [(x, 0, 0.25, 0, f, 0, v, 0.03 * d) for x, d, v, f in zip(ends, lengths, speeds, features, strict=True)]
    moves = slowed(table((0, 0, 0.25, 0, TRAVEL, 0, 150, 0), *rows))
    assert moves.speed[[0, 1, 3]].tolist() == [150, 4, 30]
    assert moves.speed[[2, 4]] == pytest.approx(20, rel=0.02)


def test_the_speed_never_falls_below_the_least():
    moves = slowed(table((0, 0, 0.25, 0, TRAVEL, 0, 150, 0), (20, 0, 0.25, 0, OUTER_WALL, 0, 60, 0.6)))
    assert moves.speed[1] == 5.0
    told = layer_time_warnings(moves, move_seconds(moves, SETTINGS.printer_profile), SETTINGS)
    assert len(told) == 1 and "1 layer takes" in told[0] and "4.0 s" in told[0]


def test_the_way_to_a_layer_and_the_change_of_tool_count():
    rows = [(0, 0, 0.25, 0, TRAVEL, 0, 150, 0), (60, 0, 0.25, 0, OUTER_WALL, 0, 60, 2.0)]
    rows += [(60, 0, 0.25, 0, RETRACT, 0, 2.0, -8.0), (60, 0, 0.5, 1, TRAVEL, 1, 150, 0)]
    rows += [(60, 0, 0.5, 1, RETRACT, 1, 2.0, 8.0), (0, 0, 0.5, 1, OUTER_WALL, 1, 60, 2.0)]
    moves = slowed(table(*rows))
    assert layer_seconds(moves, SETTINGS) == pytest.approx([10, 10], rel=0.01)
    assert moves.speed[1] == pytest.approx(10, rel=0.02)  # 4 s of retracting leave 6 s for 60 mm
    assert moves.speed[5] == pytest.approx(60 / (6 - 0.44), rel=0.05)  # and the carriage shifts by 35 mm


@pytest.mark.parametrize("model", [CUBE, lathe([[10, 0], [0.5, 12]])], ids=["cube", "cone"])
@pytest.mark.parametrize("change", [{}, {"pattern": "wave", "raft_layers": 2}], ids=["offset", "wave"])
def test_no_layer_of_a_small_print_is_short(model, change):
    hurried = generate(model, HURRIED.changed(change)).moves
    moves = generate(model, SETTINGS.changed(change)).moves
    before, after = layer_seconds(hurried, SETTINGS), layer_seconds(moves, SETTINGS)
    short = before < 10
    assert short.sum() > 8 and after[short].min() > 9.8 and after[short].max() < 10.2
    assert (after[~short] == before[~short]).all()
    assert (moves.position == hurried.position).all() and (moves.filament == hurried.filament).all()
    lines = moves.extrudes
    assert (moves.speed[~lines] == hurried.speed[~lines]).all()
    assert moves.speed[lines].min() >= min(5.0, hurried.speed[lines].min())
    for layer in np.flatnonzero(short):
        own = lines & (moves.layer == layer)
        common = moves.speed[own].max()
        assert moves.speed[own].tolist() == np.minimum(hurried.speed[own], common).tolist()


def test_a_layer_does_not_depend_on_those_beside_it():
    """Without tool changes the nozzle does not stand still between layers; nor does the ninth one ask for the tenth."""
    moves = generate(cylinder(4, 4), HURRIED.changed({"mostly_white_below": 99})).moves
    alone = []
    for layers in ([8], [8, 9], list(range(5, 12))):
        slow_short_layers(moves, np.array(layers), SETTINGS)
        alone.append(moves.speed[moves.layer == 8].copy())
        moves.speed[:] = generate(cylinder(4, 4), HURRIED.changed({"mostly_white_below": 99})).moves.speed
    assert (alone[0] == alone[1]).all() and (alone[0] == alone[2]).all()


def test_a_print_of_one_color_is_slowed_too(monkeypatch):
    """Its time is told by some layers, within a hundredth."""
    settings, tall = SETTINGS.changed({"min_print_speed": 10.0}), cylinder(3, 20)
    told = generate(tall, settings).report["time_s"]["single_color"]
    monkeypatch.setattr(single_color, "_KNOWN_LAYERS", 10000)
    assert told == pytest.approx(generate(tall, settings).report["time_s"]["single_color"], rel=0.01)
    assert told > 2 * generate(tall, HURRIED).report["time_s"]["single_color"]
