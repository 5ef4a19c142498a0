"""Clipping of many regions at once, against GEOS and areas that are known."""

import numpy as np
import pytest
import shapely
from dualcolor.core.fill.clipping import parted
from fill_shapes import annulus, blobs, shapes, square


def differs(one, other):
    """Greatest area by which shapes differ, mm²."""
    return shapely.area(shapely.symmetric_difference(one, other)).max(initial=0.0)


@pytest.mark.parametrize("seed", range(4))
def test_as_geos_has_it(seed):
    random = np.random.default_rng(seed)
    whole = shapes([*blobs(30, seed), *shapely.multipolygons(blobs(10, seed + 50, 4.0)[:, None])])
    moved = shapely.affinity.translate
    cutters = shapes([moved(blob, *random.normal(size=2) * 4) for blob in blobs(40, seed + 100)])
    cutters[::3] = [shapely.union(one, moved(one, 35.0)) for one in cutters[::3]]  # of several parts
    within, beyond, sound = parted(whole, cutters)
    assert sound.all() and shapely.is_valid(within).all() and shapely.is_valid(beyond).all()
    assert differs(within, shapely.intersection(whole, cutters)) < 1e-9
    assert differs(beyond, shapely.difference(whole, cutters)) < 1e-9


def test_whichever_way_rings_run():
    whole, cutter = annulus(10, 4), square(6, 4.1, 0.3)
    turned = [shapely.reverse(shape) for shape in (whole, cutter)]
    first, second = (parted(shapes([whole]), shapes([cutter])), parted(shapes(turned[:1]), shapes(turned[1:])))
    for one, other in zip(first[:2], second[:2], strict=True):
        assert differs(one, other) < 1e-9
    assert np.isclose(shapely.area(first[0])[0], shapely.intersection(whole, cutter).area)


def test_shapes_that_do_not_cross():
    nothing = shapely.Polygon()
    whole = shapes([square(4), square(4), annulus(10, 4), square(10), square(10), nothing, square(4)])
    cutters = shapes([square(6), square(2), square(2), annulus(6, 4), square(2, 20), square(2), nothing])
    within, beyond, sound = parted(whole, cutters)
    assert sound.all()
    np.testing.assert_allclose(shapely.area(within), [16, 4, 0, 20, 0, 0, 0])
    np.testing.assert_allclose(shapely.area(beyond), [0, 12, 84, 80, 100, 0, 16])
    assert shapely.get_num_geometries(beyond)[3] == 2


def test_none_at_all():
    within, beyond, sound = parted(shapes([]), shapes([]))
    assert len(within) == len(beyond) == len(sound) == 0


def test_touching_outlines_are_left_to_others():
    whole = shapes([square(4), square(4), square(4), square(4)])
    corner = shapely.Polygon([(2, 0), (6, -3), (6, 3)])
    cutters = shapes([square(4, 2.0), square(4, 4.0), corner, square(4, 1.0, 0.5)])
    within, beyond, sound = parted(whole, cutters)
    assert sound.tolist() == [False, False, False, True]
    assert shapely.is_empty(within[:3]).all() and shapely.is_empty(beyond[:3]).all()
    assert np.isclose(shapely.area(within)[3], 3 * 3.5) and np.isclose(shapely.area(beyond)[3], 16 - 3 * 3.5)


def test_what_touches_itself_is_right_or_left_to_others():
    corners = shapely.multipolygons([shapely.box(-4, -4, 0, 0), shapely.box(0, 0, 4, 4)])
    pinched = shapely.Polygon([(-4, -4), (4, -4), (4, 4), (-4, 4)], [[(0, 4), (-2, 1), (2, 1)]])
    whole = shapes([corners, corners, pinched, pinched])
    cutters = shapes([square(3), square(9, 3.3, 1.2), shapely.box(-5, 0, 5, 5), shapely.box(-5, 2, 0.5, 5)])
    within, beyond, sound = parted(whole, cutters)
    assert shapely.is_valid(within[sound]).all() and shapely.is_valid(beyond[sound]).all()
    assert differs(within[sound], shapely.intersection(whole, cutters)[sound]) < 1e-9
    assert differs(beyond[sound], shapely.difference(whole, cutters)[sound]) < 1e-9
    assert sound.tolist() == [True, True, True, False]  # the last one cuts shell and hole beside where they touch
