"""Brim, ooze shield and skirt, and all that stands on the bed together: form, order, reach."""

from itertools import pairwise

import numpy as np
import pytest
import shapely
import shapely.affinity
from dualcolor.core.paths import Feature, Paths
from dualcolor.core.pipeline import generate
from dualcolor.core.toolpaths.brim import brim_area, brim_paths
from dualcolor.core.toolpaths.loops import on_layers
from dualcolor.core.toolpaths.order import ordered
from dualcolor.core.toolpaths.shield import shield_paths, shield_walls
from dualcolor.core.toolpaths.skirt import skirt_paths, skirt_warnings
from dualcolor.core.toolpaths.surroundings import Ground, ground, shadow, surrounding_paths
from dualcolor.tests.core.toolpaths.bed import REACH, SETTINGS, loops_of, stack
from dualcolor.tests.solids import box, lathe

# Brim


def test_brim_loops_are_a_line_apart_from_the_outside_in():
    settings = SETTINGS.changed({"brim_width": 3.0, "first_layer_extrusion_width": 0.6})
    plate = shapely.box(-10, -10, 10, 10).difference(shapely.box(-5, -5, 5, 5))
    paths = brim_paths(plate, settings)
    assert (paths.layer == 0).all() and (paths.feature == Feature.BRIM).all() and (paths.width == 0.6).all()
    rings = [shapely.LinearRing(loop) for loop in loops_of(paths, Feature.BRIM)]
    assert [ring.distance(plate) for ring in rings] == pytest.approx([2.7, 2.1, 1.5, 0.9, 0.3], abs=0.02)
    assert all(shapely.Polygon(ring).covers(plate) and ring.is_ccw for ring in rings)  # none in the hole
    order = ordered(paths, settings)
    assert np.diff([np.abs(order.points[first]).max() for first in order.start[:-1]]).max() < 0
    strands = shapely.union_all([ring.buffer(0.3) for ring in rings])
    assert brim_area(plate, settings).symmetric_difference(shapely.union(plate, strands).buffer(0)).area < 101
    assert not len(brim_paths(plate, SETTINGS).layer)
    apart = settings.changed({"brim_separation": 0.15})
    rings = [shapely.LinearRing(loop) for loop in loops_of(brim_paths(plate, apart), Feature.BRIM)]
    assert [ring.distance(plate) for ring in rings] == pytest.approx([2.85, 2.25, 1.65, 1.05, 0.45], abs=0.02)
    assert max(abs(np.array(brim_area(plate, apart).bounds))) == pytest.approx(13.15, abs=0.01)


def test_brims_of_neighbors_grow_together():
    settings = SETTINGS.changed({"brim_width": 4.0})
    pair = shapely.MultiPolygon([shapely.box(-10, 0, -2, 8), shapely.box(2, 0, 10, 8)])
    rings = [shapely.LinearRing(loop) for loop in loops_of(brim_paths(pair, settings), Feature.BRIM)]
    for k, ring in enumerate(rings):
        for other in rings[k + 1 :]:
            assert ring.distance(other) > 0.38
    assert len(rings) == 5 + 2 * 5  # together from 2 mm on
    separate = [ring.centroid.x > 0 for ring in rings[5:]]
    assert separate in ([True] * 5 + [False] * 5, [False] * 5 + [True] * 5)  # one part after the other


def test_brim_of_an_object_within_a_ring_stays_together():
    around = shapely.Point(0, 0).buffer(30).difference(shapely.Point(0, 0).buffer(29))
    parts = shapely.union_all([around, shapely.box(-9, -2, -5, 2), shapely.box(5, -2, 9, 2)])
    paths = brim_paths(parts, SETTINGS.changed({"brim_width": 2.0}))
    sides = [np.sign(loop[:, 0].mean().round(3)) for loop in loops_of(paths, Feature.BRIM)]
    assert len(sides) == 15 and sum(a != b for a, b in pairwise(sides)) == 2


# Ooze shield


def test_shield_stands_on_every_layer_at_its_distance():
    settings = SETTINGS.changed({"ooze_shield": True, "ooze_shield_distance": 3.0})
    shadow = shapely.box(-10, -5, 10, 5)
    paths = shield_paths(shield_walls(shadow, settings), 7, settings)
    assert paths.layer.tolist() == list(range(7)) and (paths.feature == Feature.OOZE_SHIELD).all()
    for loop in loops_of(paths, Feature.OOZE_SHIELD):
        ring = shapely.LinearRing(loop)
        assert ring.distance(shadow) == pytest.approx(3.2, abs=0.1)
        assert shapely.Polygon(ring).contains(shadow)
    assert not len(shield_paths(shield_walls(shadow, SETTINGS), 7, SETTINGS).layer)


def test_shield_is_as_wide_on_the_bed_as_the_first_layer_and_its_brim_touches_it():
    settings = SETTINGS.changed({"ooze_shield": True, "brim_width": 3.0, "first_layer_extrusion_width": 0.8})
    square = shapely.box(-10, -10, 10, 10)
    paths = surrounding_paths(Ground(square, square), stack(3), settings)
    shield = paths.selected(paths.feature == Feature.OOZE_SHIELD)
    assert np.unique(shield.width[shield.start[:-1]]).tolist() == [0.4, 0.8]
    assert (shield.width[: shield.start[1]] == 0.8).all() and (shield.width[shield.start[1] :] == 0.4).all()
    (wall,) = (shapely.LinearRing(loop) for loop in loops_of(paths, Feature.OOZE_SHIELD, layer=0))
    around = [shapely.LinearRing(loop) for loop in loops_of(paths, Feature.BRIM)]
    assert min(loop.distance(wall) for loop in around) == pytest.approx(0.8, abs=0.03)


def test_repeated_layers_keep_every_path():
    single = brim_paths(shapely.box(0, 0, 5, 5), SETTINGS.changed({"brim_width": 1.0}))
    thrice = on_layers(single, 3, 0.7)
    assert (thrice.width == np.repeat([single.width[0], 0.7, 0.7], len(single.points))).all()
    assert thrice.layer.tolist() == [0] * 3 + [1] * 3 + [2] * 3
    assert (np.diff(thrice.start) == np.tile(np.diff(single.start), 3)).all()
    assert (thrice.points == np.tile(single.points, (3, 1))).all()
    assert not len(on_layers(single, 0, 0.7).layer)


# All together


def circle(radius: float, layer: int) -> Paths:
    turn = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    points = (radius + 0.3 * np.cos(20 * turn))[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
    none = np.zeros(1, dtype=np.int64)
    feature = np.full(1, int(Feature.OUTER_WALL))
    return Paths(points, np.array([0, 200]), none + layer, feature, none, none == 0, np.full(200, 0.4))


@pytest.mark.parametrize("shield", [False, True])
@pytest.mark.parametrize("brim", [0.0, 5.0])
@pytest.mark.parametrize("placement", ["auto", "manual"])
def test_nothing_crosses_anything_on_the_first_layer(shield, brim, placement):
    wanted = {"ooze_shield": shield, "brim_width": brim, "skirts": 2, "tower_placement": placement, "tower_x": 45}
    settings = SETTINGS.changed(wanted)
    walls = Paths.joined([circle(12, 0), circle(16, 1), circle(9, 2)])
    regions = np.array([shapely.Point(0, 0).buffer(radius + 0.2) for radius in (12, 16, 9)], dtype=object)
    on_bed = ground(shadow(walls.points, regions, settings), regions[0], walls, settings)
    assert on_bed.first.covers(shapely.LineString(walls.points[:200]))
    assert shapely.Polygon(on_bed.shadow.exterior).covers(shapely.MultiPoint(walls.points))
    paths = surrounding_paths(on_bed, stack(3), settings)
    every = Paths.joined([paths, walls])
    rings = [
        (feature, shapely.LinearRing(loop))
        for feature in (Feature.SKIRT, Feature.BRIM, Feature.TOWER, Feature.OOZE_SHIELD, Feature.OUTER_WALL)
        for loop in loops_of(every, feature, layer=0)
    ]
    assert {feature for feature, _ in rings} >= {Feature.SKIRT, Feature.TOWER, Feature.OUTER_WALL}
    for k, (_, ring) in enumerate(rings):
        for _, other in rings[k + 1 :]:
            assert ring.distance(other) > 0.35  # side by side at the nearest
    order = ordered(every, settings)
    first = [Feature(feature) for feature in order.feature[order.layer == 0]]
    wanted_order = [Feature.SKIRT, Feature.TOWER, Feature.BRIM, Feature.OOZE_SHIELD, Feature.OUTER_WALL]
    assert list(dict.fromkeys(first)) == [feature for feature in wanted_order if feature in first]
    assert order.feature[order.layer == 1][0] == Feature.TOWER
    tower = [shapely.LinearRing(loop) for loop in loops_of(paths, Feature.TOWER)]
    if placement == "auto":
        assert min(ring.distance(on_bed.shadow) for ring in tower) >= settings.tower_distance


@pytest.mark.parametrize(("pattern", "wave"), [("wave", SETTINGS.wave_depth_max / 2), ("offset", 0.0)])
@pytest.mark.parametrize("scale", [1.0, 40.0])
def test_the_shadow_covers_all_layers_with_their_waves_and_hardly_more(pattern, wave, scale):
    settings = SETTINGS.changed({"pattern": pattern})
    oval = shapely.affinity.scale(shapely.Point(0, 0).buffer(10, quad_segs=50), scale, 0.6 * scale)
    turned = [shapely.affinity.rotate(oval, turn) for turn in np.linspace(0, 150, 50)]
    beside = [shapely.affinity.translate(oval, 30.0 * scale, 3.0), shapely.affinity.translate(oval, -5.0, 31.0 * scale)]
    regions = np.array([*turned, oval.exterior.buffer(1), *beside])
    lines = shapely.buffer(regions, -settings.extrusion_width / 2)
    points = shapely.get_coordinates(shapely.segmentize(lines, 0.2))
    covered = shadow(points, regions[:0], settings)
    whole = shapely.union_all(regions)
    assert covered.covers(shapely.buffer(whole, wave)) and not any(
        part.interiors for part in shapely.get_parts(covered)
    )
    square = max(0.3, np.ptp(points, axis=0).max() / 1000)
    bays = shapely.buffer(shapely.buffer(whole, 4.1 + wave), -4.1)
    assert shapely.buffer(shapely.union(whole, bays), wave + 3 * square).covers(covered)
    # Supports are told by their areas.
    column = shapely.box(-60 * scale, 0, -50 * scale, 7)
    assert shadow(points, np.array([column]), settings).covers(shapely.union(whole, column))


def test_bays_of_the_shadow_stay_open_and_rings_are_filled():
    bay = shapely.box(-20, -20, 20, 20).difference(shapely.box(-10, -10, 10, 30))
    ring = shapely.box(-20, -20, 20, 20).difference(shapely.box(-10, -10, 10, 10))
    open_bay, filled = (shadow(np.zeros((0, 2)), np.array([shape]), SETTINGS) for shape in (bay, ring))
    assert not open_bay.intersects(shapely.box(-8.5, -8.5, 8.5, 30))
    assert filled.covers(shapely.box(-20, -20, 20, 20)) and not filled.interiors


# Skirt


def test_skirt_keeps_its_distance():
    settings = SETTINGS.changed({"skirts": 3})
    footprint = shapely.union_all([shapely.box(-10, -10, 10, 10), shapely.box(18, -8, 26, 8)])
    paths = skirt_paths(footprint, settings)
    assert paths.layer.tolist() == [0, 0, 0] and (paths.feature == Feature.SKIRT).all()
    for path, distance in enumerate((7.0, 6.6, 6.2)):
        ring = shapely.LinearRing(paths.points[paths.start[path] : paths.start[path + 1]])
        assert ring.is_ccw and shapely.Polygon(ring).covers(footprint)
        assert ring.distance(footprint) == pytest.approx(distance, abs=0.15)
        assert paths.closed[path]
    order = ordered(paths, settings)
    assert (np.diff([np.abs(order.points[first]).max() for first in order.start[:-1]]) < 0).all()


def test_skirt_without_room_or_wish():
    plate = shapely.box(-95, -65, 95, 65)
    for outline, loops in ((plate, 10), (shapely.box(-90, -70.4, 90, 60), 4)):
        paths = skirt_paths(outline, SETTINGS.changed({"skirts": 10}))
        assert len(paths.layer) == loops  # nearer than asked for, fewer where even that does not do
        rings = [shapely.LinearRing(paths.points[a:b]) for a, b in pairwise(paths.start)]
        assert REACH.covers(shapely.MultiLineString(rings).buffer(0.199))
        assert min(ring.distance(outline) for ring in rings) >= 1.2 - 0.06
    assert not len(skirt_paths(shapely.box(-104, -60, 95, 60), SETTINGS).layer)
    assert not len(skirt_paths(plate, SETTINGS.changed({"skirts": 0})).layer)
    assert not len(skirt_paths(shapely.Polygon(), SETTINGS).layer)
    apart = shapely.union_all([shapely.box(-50, 0, -40, 10), shapely.box(40, 0, 50, 10)])
    assert len(skirt_paths(apart, SETTINGS).layer) == 2


def test_loops_around_several_parts_count_once():
    apart = shapely.union(shapely.box(-103.5, -10, -90, 10), shapely.box(60, -10, 103.5, 10))  # room for one
    for wanted, said in ((1, []), (2, ["1 of 2 loops"]), (4, ["1 of 4 loops"])):
        settings = SETTINGS.changed({"skirts": wanted})
        made = skirt_paths(apart, settings)
        found = skirt_warnings(made, settings)
        assert len(made.layer) == 2 and len(found) == len(said)
        assert all(words in text for words, text in zip(said, found, strict=True))


def test_a_skirt_without_room_is_a_warning():
    for width, said in ((50, []), (209, ["no skirt"]), (206.2, ["2 of 3 loops"])):
        block = generate(box((0, 0, 0), (width, 40, 0.5)), SETTINGS.changed({"skirts": 3, "tower_type": "none"}))
        found = [warning for warning in block.warnings if "skirt" in warning]
        assert len(found) == len(said) and all(part in text for part, text in zip(said, found, strict=True))


def test_an_empty_ground_has_nothing_around_it():
    empty = Ground(shapely.Polygon(), shapely.Polygon())
    settings = SETTINGS.changed({"tower_type": "none", "ooze_shield": True, "brim_width": 3.0})
    assert not len(surrounding_paths(empty, stack(3), settings).layer)


@pytest.mark.parametrize("shield", [False, True])
def test_no_brim_within_a_hole(shield):
    """A plate with a hole in which a post stands; within an ooze shield both have their brim outside."""
    plate = shapely.box(-12, -12, 12, 12).difference(shapely.box(-8, -8, 8, 8))
    first = shapely.union(plate, shapely.box(-2, -2, 2, 2))
    settings = SETTINGS.changed({"brim_width": 3.0, "ooze_shield": shield, "ooze_shield_distance": 9.0})
    loops = loops_of(surrounding_paths(Ground(shapely.box(-12, -12, 12, 12), first), stack(3), settings), Feature.BRIM)
    beside_plate = [loop for loop in loops if np.abs(loop).max() < 18]
    assert len(beside_plate) == 8 and min(np.abs(loop).max() for loop in loops) > 12
    assert (len(loops) > 8) == shield


@pytest.mark.parametrize("values", [{"tone": 0.0}, {"tone": 1.0}, {"tone": 1.0, "elephant_foot_compensation": 0.2}])
def test_the_brim_touches_walls_that_are_set_back(values):
    tone = values.pop("tone")
    plan = SETTINGS.changed({"brim_width": 2.0, "pattern": "offset", "tower_type": "none", "skirts": 0, **values})
    moves = generate(lathe([(12, 0), (12, 1)], tone=tone), plan).moves
    radius, strand = np.hypot(*moves.position[:, :2].T), moves.extrudes & (moves.layer == 0)
    wall, brim = (radius[strand & (moves.feature == feature)] for feature in (Feature.OUTER_WALL, Feature.BRIM))
    assert brim.min() - wall.max() == pytest.approx(plan.extrusion_width, abs=0.03)
