"""Contours: where they lie, what they carry, what is filtered out of them, and how places on them are found."""

import numpy as np
import pytest
from dualcolor.core.contours.along_loops import dot, filtered, gaussian, steps
from dualcolor.core.contours.grid import PointGrid, nearest
from dualcolor.core.contours.inset import inset
from dualcolor.tests.pattern_stages import lines_of
from dualcolor.tests.robustness.strategies import examples
from dualcolor.tests.solids import cylinder, joined, picture
from hypothesis import given
from hypothesis import strategies as st


def test_contour_lies_half_a_line_inside_the_surface():
    lines = lines_of(cylinder(radius=10, sides=720))
    radius = np.hypot(*lines.points.T)
    # A circle of radius r filtered with a Gaussian of 0.3 mm shrinks by sigma²/(2r) = 4.5 µm.
    assert radius == pytest.approx(9.8 - 0.0045, abs=0.003)
    assert np.hypot(*(lines.normal - lines.points / radius[:, None]).T).max() < 0.01


def test_contour_points_carry_their_own_place_on_the_surface():
    lines = lines_of(cylinder(radius=10, sides=360, textures=[picture(np.zeros((2, 2)))]))
    turn = np.exp(2j * np.pi * lines.carried[:, 0])
    at = (lines.points @ [1, 1j]) / np.hypot(*lines.points.T)
    assert np.abs(turn - at).max() < 0.002


def test_detail_finer_than_the_wave_is_filtered_and_the_shape_stays():
    turn = np.linspace(0, 2 * np.pi, 2000, endpoint=False)
    start = np.array([0, 2000])
    ripple = np.stack([np.cos(turn), np.sin(turn)]) * (10 + 0.2 * np.cos(105 * turn))
    kernel = gaussian(0.3 / (2 * np.pi * 10 / 2000))
    radius = np.hypot(*filtered(ripple, start, kernel))
    assert np.ptp(radius) / 0.4 < 0.02  # ripples of 0.6 mm, half the wavelength
    assert radius.mean() == pytest.approx(10, abs=0.01)


def test_filter_wraps_around_each_loop_and_keeps_the_mean():
    values = np.arange(10.0)
    start = np.array([0, 4, 10])
    smooth = filtered(values, start, np.array([0.25, 0.5, 0.25]))
    assert smooth[0] == pytest.approx(0.25 * 3 + 0.5 * 0 + 0.25 * 1)
    assert smooth[9] == pytest.approx(0.25 * 8 + 0.5 * 9 + 0.25 * 4)
    assert smooth[:4].mean() == pytest.approx(values[:4].mean())


def test_places_are_found_again_on_every_loop():
    lines = lines_of(joined(cylinder(radius=5, height=2), cylinder(radius=3, height=2, x=20)))
    rng = np.random.default_rng(1)
    arc = rng.uniform(0, lines.arc_start[-1], 500)
    before, after, share = lines.locate(arc)
    assert (lines.loop[before] == lines.loop[after]).all()
    assert (lines.loop[before] == np.searchsorted(lines.arc_start, arc, side="right") - 1).all()
    assert ((share >= 0) & (share <= 1)).all()


@given(st.integers(0, 2**32 - 1))
@examples(30)
def test_grid_finds_the_nearest_point_of_the_layer(seed):
    rng = np.random.default_rng(seed)
    points, layer = rng.uniform(0, 5, (200, 2)), rng.integers(0, 3, 200)
    query, wanted = rng.uniform(-1, 6, (50, 2)), rng.integers(0, 3, 50)
    found, group = PointGrid(points, layer, 0.7).candidates(query, wanted)
    away = np.hypot(*(points[found] - np.repeat(query, np.diff(group), axis=0)).T)
    where, filled = nearest(away, group)
    for q in range(50):
        distance = np.where(layer == wanted[q], np.hypot(*(points - query[q]).T), np.inf)
        if distance.min() < 0.7:
            assert filled[q]
            assert away[where[q]] == pytest.approx(distance.min())
        assert (layer[found[group[q] : group[q + 1]]] == wanted[q]).all()


def test_an_inset_deeper_than_a_bend_is_reduced_until_it_does_not_fold():
    turn = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    normal = np.stack([np.cos(turn), np.sin(turn)])
    start, kernel = np.array([0, 60]), gaussian(2.0)
    for radius, folds in ((0.4, False), (0.1, True)):
        points = radius * normal
        moved, step, share = inset(points, normal, np.full(60, 0.2), start, kernel)
        assert (dot(step, steps(points, start)) > 0).all()
        assert (np.hypot(*moved) > 0).all() and np.isclose(np.hypot(*moved), 0.2).all() != folds
        assert np.all(np.asarray(share) == (0.0 if folds else 1.0))
