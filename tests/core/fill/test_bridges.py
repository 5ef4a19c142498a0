"""Bridges over gaps, holes and hollow insides: where, in which direction, and that all else is filled as before."""

import numpy as np
import pytest
import shapely
from dualcolor.core.fill.bridges import bridged, bridges
from dualcolor.core.fill.skins import skins, solid_and_sparse
from dualcolor.core.fill.walls import walls_and_fill
from dualcolor.core.paths import Feature
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.core.fill.fill_shapes import WIDTH, annulus, fill_paths, lines_of, square, stack, table_is_sound
from dualcolor.tests.solids import box, joined

PLAN = PrintSettings()


def found_in(layers, plan=PLAN):
    sliced, islands, layer = stack(layers)
    fill = walls_and_fill(islands, np.full(len(islands), WIDTH), plan)[1]
    solid = skins(fill, layer, sliced, plan)
    spanned = bridges(fill, solid, sliced, layer, plan)
    return *bridged(spanned, *solid_and_sparse(fill, solid, plan)), fill


def beam(turned=0.0, length=40.0, gap=20.0):
    """Layers of two pillars and of the beam that lies on them."""
    whole = shapely.box(-length / 2, -6, length / 2, 6)
    pillars = shapely.difference(whole, shapely.box(-gap / 2, -7, gap / 2, 7))
    return [shapely.affinity.rotate(shape, turned, origin=(0, 0)) for shape in [pillars] * 6 + [whole] * 6]


def across(angle, direction):
    """Degrees between two directions of lines."""
    return abs((angle - direction + 90) % 180 - 90)


@pytest.mark.parametrize("turned", [0.0, 45.0, 73.0])
def test_a_beam_is_bridged_along_from_pillar_to_pillar(turned):
    found, *_ = found_in(beam(turned))
    assert found.island.tolist() == [6]
    assert across(found.angle_deg[0], turned) < 1e-6
    # 20 mm of gap and 1 mm of anchor at both ends; behind the walls the beam is 9.32 mm wide.
    assert found.regions[0].area == pytest.approx(22 * (12 - 2 * 1.54), rel=0.05)


def test_a_hole_is_bridged_the_short_way():
    frame = shapely.difference(square(50), shapely.box(-15, -6, 15, 6))
    found, *_ = found_in([frame] * 6 + [square(50)] * 6)
    assert found.island.tolist() == [6] and across(found.angle_deg[0], 90) < 1e-6
    turned = [shapely.affinity.rotate(shape, 20, origin=(0, 0)) for shape in [frame] * 6 + [square(50)] * 6]
    found, *_ = found_in(turned)
    assert across(found.angle_deg[0], 110) < 1e-6


def test_what_one_side_holds_is_no_bridge():
    found, *_ = found_in([square(20)] * 6 + [shapely.box(-10, -10, 40, 10)] * 6)
    assert not len(found.island)
    found, *_ = found_in([square(20)] * 6 + [square(60)] * 6)
    assert not len(found.island)


def test_small_holes_slopes_and_the_bed_make_no_bridge():
    found, *_ = found_in([annulus(30, 2.0)] * 6 + [square(30)] * 6)
    assert not len(found.island)
    found, *_ = found_in([square(20 + 0.5 * k) for k in range(20)])
    assert not len(found.island)


def test_two_holes_in_one_layer_have_each_their_direction():
    holes = shapely.union(shapely.box(-20, -4, -2, 4), shapely.box(6, -10, 12, 10))
    found, *_ = found_in([shapely.difference(square(60), holes)] * 6 + [square(60)] * 6)
    assert found.island.tolist() == [6, 6]
    for region, angle in zip(found.regions, found.angle_deg, strict=True):
        assert across(angle, 90 if region.centroid.x < 0 else 0) < 1e-6


def test_a_hollow_print_is_closed_by_bridges_from_wall_to_wall():
    layers = [square(30)] * 12
    hollow = PrintSettings(infill_density=0)
    found, _, _, fill = found_in(layers, hollow)
    assert found.island.tolist() == [9]  # the lowest of the three layers that close it
    assert found.regions[0].area == pytest.approx(fill[9].area, rel=0.01)
    assert not len(found_in(layers)[0].island)


def test_bridges_skins_and_sparse_fill_share_the_inside():
    for layers in (beam(), [annulus(40, 14)] * 6 + [square(40)] * 6):
        found, solid, sparse, fill = found_in(layers)
        spanned = np.zeros(len(fill))
        np.add.at(spanned, found.island, shapely.area(found.regions))
        assert spanned.sum() > 50
        assert np.allclose(shapely.area(solid) + shapely.area(sparse) + spanned, shapely.area(fill))


def test_lines_of_a_bridge_end_on_what_carries_them():
    layers = beam()
    sliced, islands, layer = stack(layers)
    paths = fill_paths(sliced, islands, layer, PLAN)
    table_is_sound(paths)
    lines = lines_of(paths, Feature.BRIDGE)
    assert set(paths.layer[paths.feature == Feature.BRIDGE]) == {6}
    steps = np.concatenate([np.diff(shapely.get_coordinates(line), axis=0) for line in lines])
    long = np.abs(steps[:, 0]) > 5
    assert (np.abs(steps[long, 1]) < 1e-9).all() and long.sum() >= 20
    ends = np.concatenate([shapely.get_coordinates(line) for line in lines])
    assert (np.abs(ends[:, 0]) >= 10 + WIDTH).all()  # every turn lies on a pillar
    assert shapely.length(lines).sum() * WIDTH == pytest.approx(22 * 9, rel=0.1)


def test_speed_and_flow_of_bridges_reach_the_moves():
    pillars = box((0, 0, 0), (10, 12, 6)), box((26, 0, 0), (36, 12, 6))
    model = joined(*pillars, box((0, 0, 6), (36, 12, 9)))
    plan = PrintSettings(bridge_speed=23.0, bridge_flow=0.8, skirt_distance=2.0)
    moves = generate(model, plan).moves
    bridge = (moves.feature == Feature.BRIDGE) & moves.extrudes
    assert bridge.sum() > 20 and moves.speed[bridge].max() == pytest.approx(23.0)
    assert np.allclose(moves.width[bridge], 0.8 * WIDTH)
    length = np.linalg.norm(np.diff(moves.position, axis=0), axis=1)[bridge[1:]]
    volume = moves.filament[bridge] * np.pi / 4 * 1.75**2
    assert np.allclose(volume, 0.8 * WIDTH * 0.25 * length)
