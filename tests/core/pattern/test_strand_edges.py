"""Where lines step back, the front of the strand steps back where it should, not only its middle."""

import numpy as np
import pytest
from dualcolor.core.contours.contours import Contours
from dualcolor.core.pattern.strand_edges import widened
from dualcolor.core.settings import PrintSettings

RADIUS, SPACING = 0.2, 0.2


def contour(count, room=1.0):
    """A closed line of points 0.2 mm apart, so wide a circle that it is nearly straight."""
    size = count * SPACING / (2 * np.pi)
    turn = 2 * np.pi * np.arange(count) / count
    points = size * np.column_stack([np.cos(turn), np.sin(turn)])
    ones = np.ones(count)
    return Contours(
        points=points,
        normal=points / size,
        start=np.array([0, count]),
        layer=np.zeros(1, dtype=np.int64),
        polygon=np.zeros(1, dtype=np.int64),
        arc=np.arange(count) * SPACING,
        arc_start=np.array([0.0, count * SPACING]),
        face=np.zeros(count, dtype=np.int64),
        carried=np.zeros((count, 3)),
        width=2 * RADIUS * ones,
        room_inside=room * ones,
        room_outside=ones,
    )


def front(set_back):
    """How far back the front of the strand is, 20 times a point, from all that its width sweeps."""
    fine = 20
    at = np.arange(len(set_back) * fine) / fine
    middle = np.interp(at, np.arange(len(set_back) + 1), np.append(set_back, set_back[0]))
    off = np.arange(-fine, fine + 1)
    swept = RADIUS - np.sqrt(RADIUS**2 - (off * SPACING / fine) ** 2)
    return (np.stack([np.roll(middle, shift) for shift in off]) + swept[:, None]).min(axis=0)


@pytest.mark.parametrize("depth", [0.1, 0.28, 0.35])
@pytest.mark.parametrize("first", [0, 37])  # also across the beginning of the line
def test_front_of_black_lines_is_back_where_it_should_be(depth, first):
    wanted = np.roll(np.repeat([0.0, depth, 0.0, depth], [20, 3, 30, 7]), first)
    printed = np.where(wanted > 0, 0.9, 0.6)
    made = widened(contour(60), printed, wanted, PrintSettings())
    bars = wanted.sum() * 20  # what lies back of the wanted front, in all
    assert front(made).sum() == pytest.approx(bars, rel=0.09)  # between the points there are chords
    assert front(wanted).sum() < bars * (0.95 if depth < 0.2 else 0.85)
    assert made.max() <= depth
    # No more of the line than its own width is moved.
    near = np.convolve(np.tile(wanted, 3), np.ones(3))[61:121] > 0
    assert (made[~near] == 0).all()


def test_long_slope_is_moved_by_what_its_width_covers():
    wanted = np.concatenate([np.linspace(0, 1.6, 17), np.linspace(1.5, 0, 16), np.zeros(20)])
    made = widened(contour(len(wanted), room=5.0), np.ones(len(wanted)), wanted, PrintSettings())
    slope = 0.1 / SPACING
    assert made[1:15] - wanted[1:15] == pytest.approx(RADIUS * (np.sqrt(1 + slope**2) - 1), abs=1e-3)


def test_only_black_lines_without_waves_and_with_calibration_and_within_the_room():
    wanted = np.repeat([0.0, 0.3, 0.0], [20, 10, 20])
    dark, light = np.full(50, 0.2), np.full(50, 0.9)
    lines = contour(50)
    assert np.array_equal(widened(lines, dark, wanted, PrintSettings()), wanted)
    assert widened(lines, light, wanted, PrintSettings(calibration="none")) is wanted
    assert widened(lines, light, wanted, PrintSettings(pattern="wave_offset")) is wanted
    assert widened(lines, light, wanted, PrintSettings()).sum() > wanted.sum() + 0.2
    tight = widened(contour(50, room=0.05), light, wanted, PrintSettings())
    assert tight.max() == wanted.max() and tight[19] == pytest.approx(0.05)
