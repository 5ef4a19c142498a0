"""What the lines of the outer wall leave inside: regions with their holes, wherever those lie."""

from types import SimpleNamespace

import numpy as np
import pytest
import shapely
from dualcolor.core.ragged import starts
from dualcolor.core.toolpaths.outer_wall import inside_of_lines

SQUARE = shapely.box(0, 0, 20, 20)
HOLES = {
    "clear": [shapely.box(2, 2, 6, 6), shapely.box(10, 10, 14, 18)],
    "none": [],
    "across the edge": [shapely.box(15, 5, 25, 9), shapely.box(2, 2, 4, 4)],
    "overlapping": [shapely.box(2, 2, 8, 8), shapely.box(6, 6, 12, 12)],
    "one in the other": [shapely.box(2, 2, 12, 12), shapely.box(4, 4, 6, 6)],
    "outside": [shapely.box(30, 30, 33, 33)],
    "touching": [shapely.box(0, 5, 4, 9)],
    "all of it": [shapely.box(-1, -1, 21, 21)],
}


def inside(shells, holes):
    """Of shells, one a region, and the holes of each."""
    rings = [shapely.orient_polygons(shell).exterior for shell in shells]
    rings += [shapely.orient_polygons(hole).exterior.reverse() for own in holes for hole in own]
    loops = [shapely.get_coordinates(ring)[:-1] for ring in rings]
    region = np.concatenate([np.arange(len(shells)), np.repeat(np.arange(len(shells)), [len(own) for own in holes])])
    points = np.concatenate(loops)
    lines = SimpleNamespace(points=points, start=starts(np.array([len(loop) for loop in loops])), polygon=region)
    return inside_of_lines(lines, points, len(shells) + 1, 0.001)


@pytest.mark.parametrize("some", [list(HOLES), ["clear"], ["overlapping", "clear"], ["none", "outside"]])
def test_holes_are_cut_out_wherever_they_lie(some):
    holes = [HOLES[name] for name in some]
    shells = [SQUARE] * len(some)
    found = inside(shells, holes)
    assert shapely.is_valid(found).all() and shapely.is_empty(found[-1])
    for name, region, own in zip(some, found, holes, strict=False):
        assert region.symmetric_difference(SQUARE.difference(shapely.union_all(own))).area < 1e-9, name


def test_a_line_that_crosses_itself_bounds_two_places_with_their_holes():
    bow = np.array([[0, 0], [10, 8], [10, 0], [22, 0], [22, 9], [16, 9], [0, 2.0]])
    hole = shapely.box(18, 3, 20, 5)
    loops = [bow, shapely.get_coordinates(shapely.orient_polygons(hole).exterior.reverse())[:-1]]
    points = np.concatenate(loops)
    lines = SimpleNamespace(points=points, start=np.array([0, 7, 11]), polygon=np.zeros(2, dtype=np.int64))
    (region,) = inside_of_lines(lines, points, 1, 0.001)
    assert region.is_valid and not region.intersects(hole.buffer(-0.01)) and region.intersects(hole.buffer(0.5))
