"""Fewer points within a tolerance, against the distances of what was left out."""

from itertools import pairwise

import numpy as np
import pytest
import shapely
from dualcolor.core.pattern.chords import PIECE_POINTS, chord_ends


def closed(points):
    """Kept points of one loop, and how far off the farthest of the others lies."""
    count = np.array([points.shape[1]])
    keep = chord_ends(points, np.zeros(1, dtype=np.int64), count, np.zeros(1, dtype=np.int64), 0.01)
    kept = np.append(np.flatnonzero(keep), count)
    off = 0.0
    for begin, end in pairwise(kept):
        passed = points[:, np.arange(begin, end + 1) % count[0]].T
        off = max(off, shapely.distance(shapely.linestrings(passed[[0, -1]]), shapely.points(passed)).max())
    return keep, off


@pytest.mark.parametrize("seed", range(12))
def test_nothing_left_out_is_off_by_more_than_the_tolerance(seed):
    """Smooth loops, rough ones, loops that turn back on themselves and stand still."""
    rng = np.random.default_rng(seed)
    turn = np.linspace(0, 2 * np.pi, int(rng.integers(9, 700)), endpoint=False)
    loop = np.exp(1j * turn) * rng.uniform(0.3, 20) + 0.3 * np.exp(-5j * turn) * rng.uniform(0, 3)
    loop += rng.normal(scale=rng.choice([0.0, 0.003, 0.3]), size=(2, len(turn))).T @ [1, 1j]
    if seed % 3 == 0:
        loop[::7] = loop[np.maximum(np.arange(len(loop))[::7] - 1, 0)]
    if seed % 4 == 0:
        loop = np.concatenate([loop, loop[-2::-1]])
    keep, off = closed(np.stack([loop.real, loop.imag]))
    assert keep[0] and off <= 0.01 + 1e-9


def test_no_more_points_than_by_splitting_at_the_farthest():
    turn = np.linspace(0, 2 * np.pi, 640, endpoint=False)
    loop = 20 * np.exp(1j * turn) + np.exp(4j * turn)
    points = np.stack([loop.real, loop.imag])
    split = shapely.simplify(
        shapely.linestrings(np.append(points, points[:, :1], axis=1).T), 0.01, preserve_topology=False
    )
    keep, _ = closed(points)
    assert keep.sum() < shapely.get_num_coordinates(split)


def test_lines_of_any_length_are_each_as_alone():
    rng = np.random.default_rng(1)
    counts = rng.integers(1, 3 * PIECE_POINTS, 40)
    lines = [np.cumsum(rng.normal(scale=0.1, size=(2, count + 1)) + 0.2, axis=1) for count in counts]
    last = np.cumsum(counts + 1) - 1
    together = chord_ends(np.concatenate(lines, axis=1), last - counts, counts, last, 0.05)
    alone = [
        chord_ends(line, np.array([0]), np.array([count]), np.array([count]), 0.05)
        for line, count in zip(lines, counts, strict=True)
    ]
    assert (together == np.concatenate(alone)).all()
    assert together[last].all() and together[last - counts].all() and not together.all()
