"""Lines for a renderer of smooth curves: dense, closed at their ends, else as they were."""

import numpy as np
from dualcolor.core.strands.smooth_rods import for_smooth_curves


def test_points_between_and_round_ends():
    points = np.array([(0, 0, 0), (3, 0, 0), (3, 2, 0), (9, 9, 9), (9, 9, 10)], dtype=float)
    made, counts, radius = for_smooth_curves(points, np.array([3, 2]), np.full(5, 0.2))
    assert counts.sum() == len(made) == len(radius)
    one, other = made[: counts[0]], made[counts[0] :]
    assert np.linalg.norm(np.diff(one, axis=0), axis=1).max() <= 0.24 + 1e-9
    np.testing.assert_allclose(one[[0, -1]], [(-0.2, 0, 0), (3, 2.2, 0)], atol=1e-9)
    np.testing.assert_allclose(other[[0, -1]], [(9, 9, 8.8), (9, 9, 10.2)], atol=1e-9)
    assert radius[0] < 0.01 and radius[counts[0] - 1] < 0.01 and radius[counts[0]] < 0.01
    assert (np.diff(radius[:4]) > 0).all() and radius[4] == 0.2
    for corner in points[:3]:
        assert np.linalg.norm(one - corner, axis=1).min() < 1e-9


def test_a_line_whose_width_varies_keeps_it():
    x, wide = np.array([0.0, 1.0, 3.0]), np.array([0.1, 0.3, 0.15])
    made, _, radius = for_smooth_curves(np.outer(x, [1.0, 0, 0]), np.array([3]), wide)
    inner = slice(3, -3)
    np.testing.assert_allclose(radius[inner], np.interp(made[inner, 0], x, wide))


def test_nothing_stays_nothing():
    made, counts, radius = for_smooth_curves(np.zeros((0, 3)), np.zeros(0, dtype=np.int64), np.zeros(0))
    assert len(made) == len(counts) == len(radius) == 0
