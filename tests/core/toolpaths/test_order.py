"""The printing order loses nothing: every line is printed once, as wide as it was, whichever way round."""

import itertools

import numpy as np
import pytest
from dualcolor.core.paths import Feature, Paths
from dualcolor.core.settings import PrintSettings
from dualcolor.core.toolpaths.order import ordered

FEATURES = [Feature.OUTER_WALL, Feature.INNER_WALL, Feature.SKIN, Feature.INFILL]


def scattered(lines, seed):
    """Open and closed lines of any widths on three layers and two islands."""
    rng = np.random.default_rng(seed)
    count = rng.integers(3, 7, lines)
    feature = rng.choice(FEATURES, lines).astype(np.int64)
    return Paths(
        points=rng.uniform(-50, 50, (count.sum(), 2)),
        start=np.concatenate([[0], np.cumsum(count)]),
        layer=rng.integers(0, 3, lines),
        feature=feature,
        island=rng.integers(0, 2, lines),
        closed=np.isin(feature, FEATURES[:2]),
        width=rng.uniform(0.3, 0.6, count.sum()),
    )


def strands(points, width, start, closed, *marks):
    """What is laid down, in no order: layer and feature, both ends of each piece, its width."""
    found = set()
    for path, (begin, end) in enumerate(itertools.pairwise(start)):
        rows = [*range(begin, end), *([begin] if closed[path] else [])]
        for one, other in itertools.pairwise(rows):
            ends = tuple(sorted([tuple(points[one]), tuple(points[other])]))
            found.add((*(mark[path] for mark in marks), ends, width[one]))
    return found


@pytest.mark.parametrize("lines", [40, 400])
@pytest.mark.parametrize("seam_position", ["rear", "nearest", "valley"])
def test_every_line_is_printed_once_and_as_wide_as_it_was(lines, seam_position):
    paths = scattered(lines, lines)
    order = ordered(paths, PrintSettings(seam_position=seam_position))
    before = strands(paths.points, paths.width, paths.start, paths.closed, paths.layer, paths.feature)
    never = np.zeros(lines, dtype=bool)  # closed ones repeat their first point
    assert strands(order.points, order.width, order.start, never, order.layer, order.feature) == before
    assert len(order.points) == len(paths.points) + paths.closed.sum()
    assert (np.diff(order.layer) >= 0).all()
    islands = np.flatnonzero(np.diff(order.layer * 2 + order.island))
    assert len(islands) == 5  # three layers of two islands, each finished before the next one begins
    walls = np.isin(order.feature, FEATURES[:2])
    group = order.layer * 2 + order.island
    assert not (walls[1:] & ~walls[:-1] & (np.diff(group) == 0)).any()


@pytest.mark.parametrize("lines", [20, 200])
def test_the_nearest_end_of_all_lines_that_are_left_comes_next(lines):
    rng = np.random.default_rng(lines)
    ends = rng.uniform(-50, 50, (lines, 2, 2))
    paths = Paths(
        points=ends.reshape(-1, 2),
        start=np.arange(0, 2 * lines + 1, 2),
        layer=np.zeros(lines, dtype=np.int64),
        feature=np.full(lines, int(Feature.INFILL)),
        island=np.zeros(lines, dtype=np.int64),
        closed=np.zeros(lines, dtype=bool),
        width=np.full(2 * lines, 0.4),
    )
    printed = ordered(paths, PrintSettings()).points.reshape(-1, 2, 2)
    for number in range(1, lines):
        left = printed[number:].reshape(-1, 2) - printed[number - 1, 1]
        assert np.argmin(np.hypot(*left.T)) == 0
    assert {frozenset(map(tuple, line)) for line in printed} == {frozenset(map(tuple, line)) for line in ends}
