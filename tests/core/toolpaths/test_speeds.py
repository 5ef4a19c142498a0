"""How fast lines are printed: curves against acceleration, short moves against the queue, lines against the melt."""

import numpy as np
import pytest
from dualcolor.core.paths import Feature
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.planes import Layers
from dualcolor.core.toolpaths.order import OrderedPaths
from dualcolor.core.toolpaths.speeds import chord_lengths, extrusion_speeds
from dualcolor.tests.solids import cylinder

FREE = PrintSettings(wave_speed=200.0, min_move_time=0.0, max_volumetric_speed=0.0, first_layer_speed=300.0)


def stack(count=2):
    top = 0.25 * np.arange(1, count + 1)
    return Layers(plane=top - 0.125, top=top, height=np.full(count, 0.25))


def wall(points, layer=1, feature=Feature.OUTER_WALL, width=0.4):
    points = np.asarray(points, dtype=float)
    return OrderedPaths(
        points=points,
        width=np.full(len(points), width),
        start=np.array([0, len(points)]),
        layer=np.array([layer]),
        feature=np.array([int(feature)]),
        island=np.array([0]),
    )


def speeds(paths, settings):
    return extrusion_speeds(paths, stack().height[paths.layer], chord_lengths(paths), settings)


def circle(radius, chords, turn=2 * np.pi):
    angle = np.linspace(0, turn, chords + 1)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


@pytest.mark.parametrize("radius", [0.15, 0.4, 2.0])
def test_a_circle_takes_all_of_the_acceleration(radius):
    speed = speeds(wall(circle(radius, 64)), FREE)[:-1]
    assert speed == pytest.approx(np.sqrt(1000 * radius), abs=1.01)
    assert (speed**2 / radius <= 1000 * 1.001).all()


def test_a_straight_line_and_a_corner_between_long_lines_are_left_alone():
    assert (speeds(wall([[0, 0], [1, 0], [9, 0]]), FREE)[:-1] == 200).all()
    # the turn of 90° over 100 mm counts as a radius of 64 mm; the firmware slows down in the corner itself
    assert (speeds(wall([[0, 0], [100, 0], [100, 100]]), FREE)[:-1] == 200).all()


def test_corners_of_zigzags_are_left_to_the_firmware():
    """At the speed of a curve of that radius it would jump by 48 and 19 mm/s there; the firmware allows 15."""
    zigzag = [[x, y] for y in range(6) for x in ((0.0, 2.0) if y % 2 else (2.0, 0.0))]
    assert (speeds(wall(zigzag, feature=Feature.SKIN), FREE.changed({"skin_speed": 60}))[:-1] == 60).all()
    assert (speeds(wall(np.array(zigzag) * 0.15), FREE)[:-1] == 200).all()
    # at that of this one, by less: 12 mm/s
    fine = speeds(wall(np.array(zigzag) * 0.06), FREE)[1:-2]
    assert fine == pytest.approx(np.sqrt(1000 * 0.09 / (np.pi / 2)), abs=1.01)


def test_half_a_queue_of_short_moves_takes_its_time():
    short = np.column_stack([np.arange(41) * 0.1, np.zeros(41)])
    settings = FREE.changed({"min_move_time": 10})
    assert speeds(wall(short), settings)[:-1] == pytest.approx(10.0)
    # one short chord between long ones starves nobody, and many chords of 2.5 mm are long enough at 200 mm/s
    lone = np.column_stack([np.cumsum([0, 5, 5, 0.05, 5, 5]), np.zeros(6)])
    assert (speeds(wall(lone), settings)[:-1] == 200).all()
    assert (speeds(wall(short * 25), settings)[:-1] == 200).all()


def test_only_long_moves_within_half_a_queue_help_short_ones():
    """The queue holds 16 moves: eight around each chord count, and one of them is long."""
    steps = np.full(40, 0.1)
    steps[20] = 10.0
    line = np.column_stack([np.cumsum([0, *steps]), np.zeros(41)])
    speed = speeds(wall(line), FREE.changed({"min_move_time": 10}))[:-1]
    slow = np.flatnonzero(speed < 100)
    np.testing.assert_allclose(speed[slow], 10.0)
    assert 40 - len(slow) == 8 and 20 not in slow


def test_paths_do_not_see_each_other():
    fine, long = circle(0.2, 30), np.array([[50.0, 0], [90, 0]])
    both = OrderedPaths(
        points=np.concatenate([fine, long]),
        width=np.full(len(fine) + 2, 0.4),
        start=np.array([0, len(fine), len(fine) + 2]),
        layer=np.array([1, 1]),
        feature=np.full(2, int(Feature.OUTER_WALL)),
        island=np.array([0, 0]),
    )
    settings = FREE.changed({"min_move_time": 10})
    speed = speeds(both, settings)
    assert speed[len(fine)] == 200
    assert (speed[: len(fine) - 1] == speeds(wall(fine), settings)[:-1]).all()


def test_no_more_plastic_than_melts():
    settings = FREE.changed({"max_volumetric_speed": 8, "extrusion_multiplier_1": 1.25})
    speed = speeds(wall([[0, 0], [50, 0]], width=0.8), settings)[0]
    assert speed == 32  # 8 / (0.8 · 0.25 · 1.25)


def test_first_layer_and_features():
    line = [[0, 0], [50, 0]]
    settings = PrintSettings(first_layer_speed=20, infill_speed=70, outline_speed=35)
    assert speeds(wall(line, layer=0), settings)[0] == 20
    assert speeds(wall(line, feature=Feature.INFILL), settings)[0] == 70
    assert speeds(wall(line, feature=Feature.INNER_WALL), settings)[0] == 35


def test_waved_wall_of_a_print_keeps_the_rate_and_the_acceleration():
    settings = PrintSettings(pattern="wave", chord_tolerance=0.03, min_move_time=10)
    moves = generate(cylinder(radius=12, height=2), settings).moves
    rows = np.flatnonzero(moves.feature == Feature.OUTER_WALL)
    way = np.linalg.norm(moves.position[rows] - moves.position[rows - 1], axis=1)
    seconds = way / moves.speed[rows]
    run = np.convolve(seconds, np.full(8, 1 / 8), mode="valid")
    whole = rows[7:] - rows[:-7] == 7  # eight moves of one wall
    assert run[whole].min() > 0.009
    step = (moves.position[rows] - moves.position[rows - 1])[:, :2]
    heading = np.arctan2(step[:, 1], step[:, 0])
    turn = np.abs((np.diff(heading) + np.pi) % (2 * np.pi) - np.pi)
    inside = np.diff(rows) == 1
    bend = turn / ((way[1:] + way[:-1]) / 2)
    fastest = np.maximum(moves.speed[rows][1:], moves.speed[rows][:-1])
    assert (fastest**2 * bend)[inside].max() <= 1000 * 1.001
