"""Room beside walls: circles that touch them, where rings, gaps and slits say how wide these are."""

import numpy as np
import pytest
from dualcolor.core.contours.clearance import BLOCK, EASING, wall_distances
from dualcolor.core.ragged import starts

STEP = 0.1


def circle(radius, x=0.0, hole=False):
    """Evenly spaced points (2, N), in whole blocks, and outward normals of the material; holes are clockwise."""
    count = BLOCK * round(2 * np.pi * radius / STEP / BLOCK)
    turn = np.arange(count) * 2 * np.pi / count * (-1 if hole else 1)
    around = np.stack([np.cos(turn), np.sin(turn)])
    return radius * around + [[x], [0.0]], around * (-1 if hole else 1)


def measured(loops, layer, inside, outside):
    """Thickness and clearance of each of the loops."""
    points, normal = (np.concatenate(rows, axis=1) for rows in zip(*loops, strict=True))
    start = starts(np.array([loop.shape[1] for loop, _ in loops]))
    found = wall_distances(points, STEP * 1.1, normal, start, np.array(layer), inside, outside)
    return [np.split(values, start[1:-1]) for values in found]


def test_rings_are_as_thick_as_their_radii_tell_whatever_lies_on_other_layers():
    rings = [(10.0, 9.2), (7.0, 6.5), (10.0, 8.0), (9.5, 8.6)]
    loops = [loop for outer, inner in rings for loop in (circle(outer), circle(inner, hole=True))]
    thickness, clearance = measured(loops, [0, 0, 0, 0, 1, 1, 2, 2], 3.0, 2.6)
    for number, (outer, inner) in enumerate(rings):
        for values in thickness[2 * number : 2 * number + 2]:
            assert values == pytest.approx(outer - inner, abs=0.01)
    between = 9.2 - 7.0  # the gap of the two rings of layer 0
    for number, values in enumerate(clearance):
        assert values == pytest.approx(between if number in (1, 2) else 2.6, abs=0.01)


@pytest.mark.parametrize("gap", [0.3, 0.8])
def test_a_gap_between_discs_widens_away_from_its_narrowest_place(gap):
    """The middle of a circle that touches both discs is as far from either; widths are eased over a few neighbors."""
    radius, apart = 5.0, 10.0 + gap
    first, second = circle(radius), circle(radius, x=apart)
    thickness, clearance = measured([first, second], [0, 0], 2.0, 2.0)
    assert thickness[0].min() == thickness[1].min() == 2.0
    facing = np.maximum(first[1][0], 1e-9)  # cosine of the way to the other disc
    expected = np.minimum(apart / facing - 2 * radius, 2.0)
    eased = np.min([np.roll(expected, by) for by in range(-2 * EASING, 2 * EASING + 1)], axis=0)
    assert (clearance[0] <= expected + 0.01).all() and (clearance[0] >= eased - 0.01).all()
    assert clearance[0].min() == pytest.approx(gap, abs=0.01)
    assert np.sort(clearance[1]) == pytest.approx(np.sort(clearance[0]), abs=0.01)
