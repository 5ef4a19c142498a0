"""Print time against hand-made trapezoids and a slow planner."""

import math

import numpy as np
import pytest
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.printing import OUTER_WALL, RETRACT, TOWER, TRAVEL, print_time, rosette, table

SETTINGS = PrintSettings()
JERK = (15.0, 15.0, 10.0, 20.0)
SHIFT = 35 / 100  # s that the carriage takes from nozzle to nozzle


def total(*rows):
    return print_time(table(*rows), SETTINGS)["total"]


def wall(x, y, speed, z=0.0):
    return (x, y, z, 0, OUTER_WALL, 0, speed, 1e-6)


ORIGIN = (0, 0, 0, 0, TRAVEL, 0, 100, 0)


def test_one_line_from_rest_to_rest():
    # 100 mm at 50 mm/s and 1000 mm/s²: two ramps of 0.05 s and 1.25 mm, the rest at full speed
    assert total(ORIGIN, wall(100, 0, 50)) == pytest.approx(0.1 + 97.5 / 50)
    # 1 mm never reaches 50 mm/s: a triangle
    assert total(ORIGIN, wall(1, 0, 50)) == pytest.approx(2 * math.sqrt(1 / 1000))
    # straight on, it does not matter where the line is divided
    parts = [wall(x, 0, 50) for x in (3, 3.5, 40, 99.9, 100)]
    assert total(ORIGIN, *parts) == pytest.approx(0.1 + 97.5 / 50)


def test_lift_is_slow():
    # 10 mm up at no more than 19.5 mm/s and 150 mm/s²
    ramp = 19.5 / 150
    assert total(ORIGIN, (0, 0, 10, 0, TRAVEL, 0, 100, 0)) == pytest.approx(2 * ramp + (10 - 19.5 * ramp) / 19.5)


def test_corners():
    # a right angle is passed at 15 mm/s, since each axis may change by that
    leg = (50 - 15) / 1000 + 50 / 1000 + (100 - (50**2 - 15**2) / 2000 - 50**2 / 2000) / 50
    assert total(ORIGIN, wall(100, 0, 50), wall(100, 100, 50)) == pytest.approx(2 * leg)
    # turning back: 15 mm/s in all, so 7.5 mm/s
    leg = (50 - 7.5) / 1000 + 50 / 1000 + (100 - (50**2 - 7.5**2) / 2000 - 50**2 / 2000) / 50
    assert total(ORIGIN, wall(100, 0, 50), wall(0, 0, 50)) == pytest.approx(2 * leg)


def test_retraction_slows_down():
    # 1.25 mm of filament at 25 mm/s and 2000 mm/s²; carriage and filament may change places at 15 mm/s
    pull = 2 * (25 - 15) / 2000 + (1.25 - (25**2 - 15**2) / 2000) / 25
    line = 50 / 1000 + (50 - 15) / 1000 + (100 - 50**2 / 2000 - (50**2 - 15**2) / 2000) / 50
    rows = [ORIGIN, wall(100, 0, 50), (100, 0, 0, 0, RETRACT, 0, 25, -1.25), wall(200, 0, 50)]
    assert total(*rows) == pytest.approx(2 * line + pull)


def test_queue_limits_the_speed_of_fine_lines():
    # 16 moves of 0.05 mm are 0.8 mm, from which 40 mm/s can be stopped; at 20 mm/s the queue does not matter
    fine = [wall(0.05 * (n + 1), 0, 200) for n in range(4000)]
    assert total(ORIGIN, *fine) == pytest.approx(200 / 40, rel=0.03)
    slow = [wall(0.05 * (n + 1), 0, 20) for n in range(4000)]
    assert total(ORIGIN, *slow) == pytest.approx(200 / 20 + 20 / 1000)


def slow_planner(moves):
    """Seconds of each row with a way, one row after the other."""
    way, speed, top = [], [], []
    for row in range(1, len(moves.tool)):
        step = moves.position[row] - moves.position[row - 1]
        length = float(np.linalg.norm(step))
        still = length == 0
        length = abs(moves.filament[row]) if still else length
        if length == 0:
            continue
        unit = step * 0 if still else step / length
        limits = [moves.speed[row], 1600 / 60 * length / max(abs(moves.filament[row]), 1e-12)]
        limits += [most / abs(part) for most, part in zip((300, 300, 19.5), unit, strict=True) if part]
        unit = np.append(unit, moves.filament[row] / length)
        most = (1000.0, 1000.0, 150.0, 2000.0)
        acceleration = min(a / abs(part) for a, part in zip(most, unit, strict=True) if part)
        way.append((unit, length, acceleration, moves.tool[row]))
        top.append(min(limits))
    for (unit, _, _, tool), (unit2, _, _, tool2), v, v2 in zip(way, way[1:], top, top[1:], strict=False):
        corner = min([v, v2] + [j / abs(d) for j, d in zip(JERK, unit2 - unit, strict=True) if d])
        speed.append(0.0 if tool != tool2 else corner)
    speed = [0.0, *speed, 0.0]
    for node in range(len(speed) - 1):
        reach = sum(2 * a * d for _, d, a, _ in way[node : node + 16])
        speed[node] = min(speed[node], math.sqrt(reach))
    for node in reversed(range(len(way))):
        speed[node] = min(speed[node], math.sqrt(speed[node + 1] ** 2 + 2 * way[node][2] * way[node][1]))
    for node in range(len(way)):
        speed[node + 1] = min(speed[node + 1], math.sqrt(speed[node] ** 2 + 2 * way[node][2] * way[node][1]))
    seconds = []
    for (_, length, a, _), v, v0, v1 in zip(way, top, speed, speed[1:], strict=False):
        peak = min(v, math.sqrt((v0**2 + v1**2) / 2 + a * length))
        cruise = length - (2 * peak**2 - v0**2 - v1**2) / (2 * a)
        seconds.append((2 * peak - v0 - v1) / a + max(cruise, 0) / peak)
    return seconds + [SHIFT] * int((np.diff(moves.tool) != 0).sum())


@pytest.mark.parametrize("seed", range(5))
def test_vectorised_planner_equals_the_slow_one(seed):
    rng = np.random.default_rng(seed)
    moves = rosette(4, 300)
    moves.position[:, :2] += rng.normal(0, 0.2, (len(moves.tool), 2))
    moves.speed[:] *= rng.choice([0.5, 1.0, 3.0], len(moves.tool))
    still = np.flatnonzero(moves.feature == RETRACT)
    moves.position[still] = moves.position[still - 1]
    assert print_time(moves, SETTINGS)["total"] == pytest.approx(sum(slow_planner(moves)), rel=1e-7)


def test_parts_of_the_time():
    moves = table(
        ORIGIN,
        wall(100, 0, 50),
        (100, 0, 0, 0, RETRACT, 0, 25, -1.25),
        (100, 0, 1, 0, TRAVEL, 0, 19.5, 0),
        (100, 100, 1, 1, TRAVEL, 1, 50, 0),
        (100, 100, 1, 1, RETRACT, 1, 25, 1.25),
        (200, 100, 1, 1, TOWER, 1, 50, 1),
        (200, 200, 1, 1, TRAVEL, 1, 50, 0),
        (200, 200, 1, 1, RETRACT, 1, 25, 1.25),
        (300, 200, 1, 1, OUTER_WALL, 1, 50, 1),
    )
    time = print_time(moves, SETTINGS)
    assert time["tool_change"] == pytest.approx(sum(slow_planner(moves)[1:5]) + SHIFT)
    line = 0.1 + 97.5 / 50
    assert time["tower"] == pytest.approx(line, rel=0.03)  # the corner after it is passed without a stop
    assert time["tower"] < line
    assert time["total"] > time["tool_change"] + time["tower"]
    assert set(time) == {"total", "tool_change", "tower"}


def test_time_is_never_less_than_the_speeds_allow():
    moves = rosette(6, 500)
    way = np.linalg.norm(np.diff(moves.position, axis=0), axis=1)
    assert print_time(moves, SETTINGS)["total"] > (way / moves.speed[1:]).sum()
    alone = table((5, 5, 5, 0, TRAVEL, 0, 10, 0))
    assert print_time(alone, SETTINGS) == {"total": 0.0, "tool_change": 0.0, "tower": 0.0}
