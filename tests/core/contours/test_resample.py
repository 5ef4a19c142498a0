"""Even points on outlines: as far apart along each loop, on the segments that they say, between what those carry."""

import numpy as np
import pytest
import shapely
from dualcolor.core.contours.resample import even_points, resampled
from dualcolor.core.ragged import starts
from dualcolor.core.slicing.outlines import Outlines

LOOPS = [np.array([[0.0, 0], [7, 0], [7, 3], [0, 3]]), np.array([[12.0, 1], [15, 5], [11.9, 1.1]])]


@pytest.mark.parametrize("step", [0.1, 0.73, 20.0])
def test_points_are_even_along_each_loop_and_carry_what_lies_there(step):
    points = np.concatenate(LOOPS)
    ends = np.concatenate([np.roll(loop, -1, axis=0) for loop in LOOPS])
    outlines = Outlines(
        points, starts(np.array([4, 3])), np.zeros(2, int), np.arange(7), np.stack([points, ends], axis=1)
    )
    even = even_points(outlines, step, 4)
    count = np.diff(even.start)
    assert (count % 4 == 0).all()
    for loops in (slice(0, 2), slice(0, 1), slice(1, 2)):
        total = even.start[loops.stop] - even.start[loops.start]
        face, carried = np.zeros(total, dtype=np.int64), np.zeros((2, total))
        made = resampled(outlines, even, loops, face, carried)
        assert carried == pytest.approx(made)
        for number in range(loops.start, loops.stop):
            own = slice(*(even.start[number : number + 2] - even.start[loops.start]))
            ring = shapely.linearrings(LOOPS[number])
            assert ring.length / count[number] <= step
            arc = np.arange(count[number]) * ring.length / count[number]
            places = shapely.line_interpolate_point(ring, arc)
            assert shapely.distance(shapely.points(made[:, own].T), places).max() < 1e-9
            sides = shapely.linestrings(np.stack([points[face[own]], ends[face[own]]], axis=1))
            assert shapely.distance(sides, shapely.points(made[:, own].T)).max() < 1e-9
