"""What hangs in the air with nothing below is told: how long it is and where, and only where it is worth a word."""

import math
from dataclasses import replace

import pytest
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.solids import box, joined, lathe

PLAN = PrintSettings(calibration="none", offset_max=0.0)
# The underside of the bar lies 5 mm high, free for 12 mm on one side and for 3 mm on the other.
TEE = joined(box((-4, -4, 0), (4, 4, 5)), box((-7, -4, 5), (16, 4, 8)))
WIDTH = 0.4
REACH = 1.2  # mm; half a line's width, and half a piece on both sides


def hanging(inside):
    """Mm of a line so far inside the bar's outline that lie beyond the foot."""
    return 2 * (12 - inside) + 2 * (3 - inside) + 2 * (8 - 2 * inside)


def told(job):
    return [warning for warning in job.warnings if "hang in the air" in warning]


@pytest.mark.parametrize("raft, low", [(0, 5.0), (3, 5.0 + 0.75 + 0.2)])
def test_walls_in_the_air_are_told_with_their_length_and_place(raft, low):
    job = generate(TEE, replace(PLAN, raft_layers=raft))
    found = job.report["hanging_walls"]
    # The inner wall lies one and a half lines inside: out, across and back on both sides.
    assert found["length_mm"] == pytest.approx(hanging(1.5 * WIDTH), abs=4 * REACH)
    longest = 2 * (12 - 1.5 * WIDTH) + 8 - 3 * WIDTH
    assert found["longest"]["length_mm"] == pytest.approx(longest, abs=2 * REACH)
    assert found["layers"] == 1 and found["z_from"] == found["z_to"] == pytest.approx(low)
    assert found["longest"]["z"] == found["z_from"]
    # The bar's middle is the bed's: the foot ends half a millimeter left of it.
    assert found["longest"]["x"] > -0.5 - REACH
    (warning,) = told(job)
    assert "support_enable" in warning and f"z {low:.2f} mm" in warning


def test_supports_and_small_ledges_are_no_reason_to_warn():
    assert not told(generate(TEE, replace(PLAN, support_enable=True)))
    ledge = joined(box((-4, -4, 0), (4, 4, 5)), box((-4.7, -4.7, 5), (4.7, 4.7, 8)))
    assert not told(generate(ledge, PLAN))


def test_what_the_bed_catches_does_not_hang():
    job = generate(joined(box((-4, -4, 0), (4, 4, 0.5)), box((-12, -4, 0.5), (12, 4, 4))), PLAN)
    assert job.report["hanging_walls"] == {"length_mm": 0.0, "layers": 0} and not told(job)


def test_steep_objects_have_nothing_to_tell():
    job = generate(lathe([[4, 0], [9, 11], [5, 18], [7, 30]]), PLAN)
    assert job.report["hanging_walls"] == {"length_mm": 0.0, "layers": 0}


def test_without_inner_walls_the_outline_is_looked_at():
    found = generate(TEE, replace(PLAN, perimeters=0)).report["hanging_walls"]
    assert found["length_mm"] == pytest.approx(hanging(0.5 * WIDTH), abs=4 * REACH)


def funnel(angle, rim=6.0):
    """A post of 4 mm radius whose wall leans out by an angle, ° from the horizontal, for `rim` mm."""
    top = 5 + rim * math.tan(math.radians(angle))
    return lathe([[4, 0], [4, 5], [4 + rim, top], [4 + rim, top + 3]])


@pytest.mark.parametrize("angle", [12, 20, 28])
def test_outer_walls_that_lean_upon_each_other_hang(angle):
    """Down to 32° each line lies beyond the one below by more than its width."""
    job = generate(funnel(angle), PLAN)
    found = job.report["hanging_walls"]
    layers = 6 * math.tan(math.radians(angle)) / 0.25
    around = 2 * math.pi * 7 * layers
    assert found["layers"] == pytest.approx(layers, abs=1.5)
    assert found["length_mm"] == pytest.approx(around, rel=0.25) and found["z_from"] == pytest.approx(5.0, abs=0.26)
    assert len(told(job)) == 1


@pytest.mark.parametrize("angle, rim", [(36, 6), (20, 1.2)], ids=["steep enough", "two layers"])
def test_steep_walls_and_short_slopes_are_held(angle, rim):
    assert not told(generate(funnel(angle, rim), PLAN))
