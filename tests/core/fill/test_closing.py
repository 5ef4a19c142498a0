"""Skins and bridges worked out before the tones are known: they close the print wherever the wall then stands."""

import numpy as np
import pytest
import shapely
from dualcolor.core.fill.bridges import bridged
from dualcolor.core.fill.closing import bridges_in, closing
from dualcolor.core.fill.skins import solid_and_sparse, uncovered
from dualcolor.core.fill.walls import walls_and_fill
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.core.fill.fill_shapes import WIDTH, blobs, covering, shapes, square

STEPS = [-3, -2, -1, 3, 2, 1]


def slopes():
    """Layers of a wobbly body that tapers up and down, and their regions and those's layers."""
    sliced = shapely.buffer(blobs(1, 5)[0], -0.7 * np.abs(np.arange(24) - 9))
    return sliced, *shapely.get_parts(sliced, return_index=True)


def filled(polygons, layer, behind, plan):
    """Skins, sparse fill and all of it, the wall's innermost line so far behind the outlines."""
    islands = shapely.buffer(polygons, -behind, join_style="mitre")
    fill = walls_and_fill(islands, np.full(len(islands), WIDTH), plan)[1]
    found = closing(polygons, layer, int(layer.max()) + 1, plan)
    return found, *solid_and_sparse(fill, found.skins, plan), fill


@pytest.mark.parametrize(
    "pattern, behind", [("offset", 0.2), ("offset", 0.4), ("offset", 0.55), ("wave", 0.39), ("wave", 0.575)]
)
def test_what_lies_bare_is_solid_wherever_the_wall_stands(pattern, behind):
    sliced, polygons, layer = slopes()
    plan = PrintSettings(pattern=pattern)
    found, solid, sparse, fill = filled(polygons, layer, behind, plan)
    assert np.allclose(shapely.area(solid) + shapely.area(sparse), shapely.area(fill))
    bare, _ = uncovered(sparse, layer, covering(sliced), STEPS, 0.0)
    assert shapely.area(shapely.buffer(bare, -0.1)).max(initial=0.0) < 0.01  # but for slivers
    mixed = (shapely.area(solid) > 1) & (shapely.area(sparse) > 1)
    assert mixed.sum() > 6 and not found.skins.whole[mixed].any()
    # No more than a line's width beyond what is bare.
    exposed, owner = uncovered(fill, layer, covering(sliced), STEPS, 0.0)
    near = shapely.buffer([shapely.union_all(exposed[owner == k]) for k in range(len(layer))], 2.2 * WIDTH)
    assert (shapely.area(shapely.difference(solid, near))[mixed] < 0.05 * shapely.area(fill)[mixed]).all()


def test_islands_left_no_room_by_the_plain_wall_are_solid():
    polygons = shapes([square(1.3)] * 9 + [square(9)] * 9)
    layer = np.tile(np.arange(9), 2)
    order = np.argsort(layer, kind="stable")
    found = closing(polygons[order], layer[order], 9, PrintSettings())
    assert found.skins.whole.reshape(9, 2)[:, 0].all()
    assert np.flatnonzero(found.skins.whole.reshape(9, 2)[:, 1]).tolist() == [0, 1, 2, 6, 7, 8]
    islands = shapes([square(0.9)] * 18)
    fill = walls_and_fill(islands, np.full(18, WIDTH), PrintSettings(perimeters=0))[1]
    solid, sparse = solid_and_sparse(fill, found.skins, PrintSettings(infill_density=0))
    assert np.allclose(shapely.area(solid) + shapely.area(sparse), shapely.area(fill))


@pytest.mark.parametrize("behind", [0.2, 0.55])
def test_a_bridge_ends_where_the_fill_does(behind):
    whole = shapely.box(-20, -6, 20, 6)
    pillars = shapely.get_parts(shapely.difference(whole, shapely.box(-10, -7, 10, 7)))
    polygons, layer = shapes([*pillars, *pillars, *pillars, whole, whole, whole]), np.array([0, 0, 1, 1, 2, 2, 3, 4, 5])
    found, solid, sparse, fill = filled(polygons, layer, behind, PrintSettings())
    spanned, solid, sparse = bridged(bridges_in(found, layer, PrintSettings()), solid, sparse)
    assert spanned.island.tolist() == [6]
    assert abs((spanned.angle_deg[0] + 90) % 180 - 90) < 1e-6
    west, south, east, north = spanned.regions[0].bounds
    assert (south, north) == pytest.approx((fill[6].bounds[1], fill[6].bounds[3]))
    assert (west, east) == pytest.approx((-11, 11), abs=0.05)
    assert spanned.regions[0].area + solid[6].area + sparse[6].area == pytest.approx(fill[6].area)


def test_outlines_that_meet_when_simplified_are_one():
    teeth = np.stack([np.linspace(0, 20, 201), np.tile([0.0, 0.04], 101)[:201]], axis=1)
    upper = shapely.Polygon([*teeth, (20, 5), (0, 5)])
    lower = shapely.Polygon([*(teeth - [0, 0.045])[::-1], (0, -5), (20, -5)])
    (outline,) = covering(shapes([shapely.MultiPolygon([upper, lower])]))
    assert outline.is_valid and outline.area == pytest.approx(upper.area + lower.area, rel=0.02)
