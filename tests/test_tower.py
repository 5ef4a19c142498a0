"""The cleaning tower and the skirt: form, place, reach."""

import numpy as np
import pytest
import shapely
from dualcolor.core.errors import MeshError
from dualcolor.core.printer import REPLICATOR_2X
from dualcolor.core.settings import PrintSettings
from dualcolor.core.toolpaths.moves import Feature
from dualcolor.core.toolpaths.skirt import skirt_paths
from dualcolor.core.toolpaths.tower import tower_paths

REACH = shapely.box(*REPLICATOR_2X.reach_min[:2], *REPLICATOR_2X.reach_max[:2])
SETTINGS = PrintSettings()


def bounds(*corners):
    return np.array(corners, dtype=float).reshape(2, 2)


def first_ring(paths):
    return shapely.LinearRing(paths.points[: paths.start[1]])


def test_the_same_closed_w_on_every_layer():
    paths = tower_paths(7, bounds(-20, -20, 20, 20), SETTINGS)
    assert paths.layer.tolist() == list(range(7))
    assert paths.closed.all() and (paths.feature == Feature.TOWER).all() and (paths.island == -1).all()
    assert len(paths.width) == len(paths.points) == paths.start[-1]
    layers = paths.points.reshape(7, -1, 2)
    assert (layers == layers[0]).all()
    ring = first_ring(paths)
    assert ring.is_simple and ring.is_ccw
    assert 5 <= ring.length * SETTINGS.extrusion_width * SETTINGS.layer_height <= 8  # mm³ of purge a layer
    lines = shapely.Polygon(ring).buffer(-SETTINGS.extrusion_width / 2)
    assert lines.geom_type == "Polygon" and lines.area > 0  # its two lines stand side by side all along
    teeth = shapely.Polygon(ring).convex_hull.difference(shapely.Polygon(ring))
    assert len([part for part in teeth.geoms if part.area > 1]) == 3  # a W has three notches


@pytest.mark.parametrize(
    ("occupied", "axis", "sign"),
    [
        ((-60, -30, 20, 30), 0, 1),
        ((-20, -30, 60, 30), 0, -1),
        ((-104, -60, 104, -20), 1, 1),
        ((-104, 20, 104, 60), 1, -1),
    ],
)
def test_tower_stands_where_there_is_room(occupied, axis, sign):
    occupied = bounds(*occupied)
    ring = first_ring(tower_paths(1, occupied, SETTINGS))
    strand = ring.buffer(SETTINGS.extrusion_width / 2, join_style="mitre")
    assert REACH.covers(ring.buffer(SETTINGS.extrusion_width / 2))
    offset = np.array(strand.centroid.coords[0]) - occupied.mean(axis=0)
    assert offset[axis] * sign > np.ptp(occupied, axis=0)[axis] / 2
    gap = ring.buffer(SETTINGS.extrusion_width / 2).distance(shapely.box(*occupied.ravel()))
    assert gap == pytest.approx(SETTINGS.tower_distance, abs=0.3)


def test_tower_stays_in_reach_beside_an_object_at_the_edge():
    ring = first_ring(tower_paths(1, bounds(-100, 71, -50, 73), SETTINGS))
    assert REACH.covers(ring.buffer(SETTINGS.extrusion_width / 2))


def test_no_room_and_no_tower():
    with pytest.raises(MeshError, match="no room") as error:
        tower_paths(3, bounds(-100, -70, 100, 70), SETTINGS)
    assert "tower_type" in error.value.hint
    assert not len(tower_paths(3, bounds(-100, -70, 100, 70), SETTINGS.changed({"tower_type": "none"})).layer)
    assert not len(tower_paths(0, bounds(0, 0, 1, 1), SETTINGS).layer)


def test_skirt_keeps_its_distance():
    settings = SETTINGS.changed({"skirts": 3})
    footprint = shapely.union_all([shapely.box(-10, -10, 10, 10), shapely.box(18, -8, 26, 8)])
    paths = skirt_paths(footprint, settings)
    assert paths.layer.tolist() == [0, 0, 0] and (paths.island == -2).all() and (paths.feature == Feature.SKIRT).all()
    for path, distance in enumerate((7.0, 6.6, 6.2)):
        ring = shapely.LinearRing(paths.points[paths.start[path] : paths.start[path + 1]])
        assert ring.is_ccw and shapely.Polygon(ring).covers(footprint)
        assert ring.distance(footprint) == pytest.approx(distance, abs=0.15)
        assert paths.closed[path]


def test_skirt_without_room_or_wish():
    plate = shapely.box(-95, -65, 95, 65)
    paths = skirt_paths(plate, SETTINGS.changed({"skirts": 10}))
    assert 0 < len(paths.layer) < 10
    assert REACH.covers(shapely.LineString(paths.points).buffer(0.2))
    assert not len(skirt_paths(shapely.box(-104, -60, 95, 60), SETTINGS).layer)
    assert not len(skirt_paths(plate, SETTINGS.changed({"skirts": 0})).layer)
    assert not len(skirt_paths(shapely.Polygon(), SETTINGS).layer)
    apart = shapely.union_all([shapely.box(-50, 0, -40, 10), shapely.box(40, 0, 50, 10)])
    assert len(skirt_paths(apart, SETTINGS).layer) == 2
