"""Walls over air: which parts of them, that only these are slowed, and that all else stays as it was."""

from dataclasses import fields, replace

import numpy as np
import pytest
from dualcolor.core.paths import Feature
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.toolpaths.overhangs import undersides
from dualcolor.tests.printing import gcode_text, lengths
from dualcolor.tests.solids import box, cylinder, joined, lathe

SLOW = 14.25  # no limit gives this speed
WALLS = (Feature.OUTER_WALL, Feature.INNER_WALL)
PLAN = PrintSettings(calibration="none", overhang_speed=SLOW)
BEAM = joined(box((-20, -5, 0), (-10, 5, 5)), box((10, -5, 0), (20, 5, 5)), box((-20, -5, 5), (20, 5, 7)))
FIRST_OF_BEAM = 20
REACH = 1.2  # mm; half a line's width, and half a piece on both sides


def slowed(model, settings=PLAN):
    """Rows of walls that are slower than they would be, the moves, and the moves of the print that is not slowed."""
    with_it = generate(model, settings).moves
    without = generate(model, replace(settings, overhang_speed=0.0)).moves
    slow = np.flatnonzero(with_it.speed == SLOW)
    assert np.isin(with_it.feature[slow], WALLS).all()
    return slow, with_it, without


def test_walls_of_a_beam_are_slow_between_its_pillars_only():
    rows, moves, without = slowed(BEAM)
    assert set(moves.layer[rows]) == {FIRST_OF_BEAM}
    middle = (moves.position[rows] + moves.position[rows - 1]) / 2
    assert np.abs(middle[:, 0]).max() < 10 + REACH
    for feature in WALLS:
        own = moves.feature[rows] == feature
        # Two sides, 20 mm each.
        assert lengths(moves)[rows[own]].sum() == pytest.approx(40, abs=4 * REACH)
    assert lengths(moves)[moves.extrudes].sum() == pytest.approx(lengths(without)[without.extrudes].sum(), rel=1e-9)
    assert moves.filament.sum() == pytest.approx(without.filament.sum(), rel=1e-9)
    # The lines are the same ones, with a point more at each end of what hangs.
    assert len(moves.tool) - len(without.tool) == 8
    others = moves.layer != FIRST_OF_BEAM
    same = without.layer != FIRST_OF_BEAM
    for column in fields(moves):
        if column.name != "position":
            np.testing.assert_array_equal(getattr(moves, column.name)[others], getattr(without, column.name)[same])


@pytest.mark.parametrize("speed", [SLOW, 0.0])
def test_walls_over_air_get_as_much_as_bridges(speed):
    plain, thin = (generate(BEAM, replace(PLAN, bridge_flow=flow, overhang_speed=speed)).moves for flow in (1.0, 0.8))
    for feature in WALLS:
        own = thin.feature == feature
        thinner = np.flatnonzero(own & (np.abs(thin.width - 0.8 * 0.4) < 1e-9))
        assert set(thin.layer[thinner]) == {FIRST_OF_BEAM}
        assert lengths(thin)[thinner].sum() == pytest.approx(40, abs=4 * REACH)
        lost = plain.filament[plain.feature == feature].sum() - thin.filament[own].sum()
        assert lost == pytest.approx(0.2 * lengths(thin)[thinner].sum() * 0.1 / (np.pi / 4 * 1.75**2), rel=1e-6)
        if not speed:
            assert thin.speed[thinner].min() > SLOW


def test_the_same_object_in_one_color_is_slow_over_air_too():
    def times(overhang_speed):
        report = generate(BEAM, replace(PLAN, overhang_speed=overhang_speed)).report["time_s"]
        return report["single_color"], report["total"]

    (alone, dual), (alone_slow, dual_slow) = times(0.0), times(5.0)
    # Two walls on two sides, 20 mm each, at 5 mm/s instead of some 30 to 40.
    assert dual_slow - dual == pytest.approx(80 / 5 - 80 / 35, rel=0.15)
    assert alone_slow - alone == pytest.approx(80 / 5 - 80 / 40, rel=0.15)


def test_all_of_an_island_in_the_air_is_slow():
    mushroom = joined(box((-2, -2, 0), (2, 2, 4)), box((-8, -8, 4), (8, 8, 6)))
    rows, moves, _ = slowed(mushroom)
    outer = rows[moves.feature[rows] == Feature.OUTER_WALL]
    assert lengths(moves)[outer].sum() == pytest.approx(4 * (16 - 0.4), rel=0.02)
    assert set(moves.layer[rows]) == {16}


@pytest.mark.parametrize(("step", "hangs"), [(0.3, False), (0.37, False), (0.45, True), (0.8, True)])
def test_a_cone_hangs_where_it_grows_by_more_than_a_line(step, hangs):
    layers = 12
    rows, moves, _ = slowed(lathe([[8, 0], [8 + step * layers, 0.25 * layers]]))
    outer = moves.feature[rows] == Feature.OUTER_WALL
    if not hangs:
        assert not len(rows)
        return
    assert sorted(set(moves.layer[rows[outer]])) == list(range(1, layers))
    radius = 8 + step * (np.arange(1, layers) + 0.5) - 0.2
    assert lengths(moves)[rows[outer]].sum() == pytest.approx(2 * np.pi * radius.sum(), rel=0.03)
    # The wall behind hangs where the step is as wide as two lines.
    assert (~outer).any() == (step >= 0.8)


@pytest.mark.parametrize("model", [cylinder(), box((0, 0, 0), (12, 9, 3)), lathe([[12, 0], [4, 3]])])
@pytest.mark.parametrize("pattern", ["offset", "wave"])
def test_prints_without_overhangs_stay_as_they_were(model, pattern):
    """Roofs, upright walls and waves, whose crests hang over each other as they should."""
    texts = [
        gcode_text(generate(model, replace(PLAN, pattern=pattern, overhang_speed=speed)).moves, PLAN, [])
        for speed in (SLOW, 0.0)
    ]
    assert texts[0] == texts[1]


def test_waves_over_air_are_slow_and_others_are_not():
    rows, moves, _ = slowed(BEAM, replace(PLAN, pattern="wave", max_curve_acceleration=20000.0, min_move_time=0.0))
    outer = rows[moves.feature[rows] == Feature.OUTER_WALL]
    assert set(moves.layer[outer]) == {FIRST_OF_BEAM}
    assert np.abs(moves.position[outer, 0]).max() < 10 + REACH
    along = np.abs(np.diff(moves.position[:, 0], prepend=0.0))[outer].sum()
    assert along == pytest.approx(40, abs=4 * REACH)


@pytest.mark.parametrize(("length", "slow"), [(0.8, False), (4.0, True)])
def test_a_strand_carries_itself_over_a_short_ledge(length, slow):
    ledge = joined(box((-6, -6, 0), (6, 6, 6)), box((6, 0, 3), (6.9, length, 6)))
    rows, _, _ = slowed(ledge)
    assert bool(len(rows)) == slow


def test_the_raft_lies_below_and_carries():
    rows, moves, _ = slowed(BEAM, replace(PLAN, raft_layers=3))
    assert set(moves.layer[rows]) == {FIRST_OF_BEAM + 3}


def test_a_mesh_that_is_inside_out_hangs_too():
    beam = replace(BEAM, corner_vertex=BEAM.corner_vertex.reshape(-1, 3)[:, ::-1].ravel())
    assert lengths(slowed(beam)[1])[slowed(beam)[0]].sum() == pytest.approx(80, abs=8 * REACH)


def test_slower_lines_stay_slower_and_the_first_layer_is_not_asked():
    moves = generate(BEAM, replace(PLAN, overhang_speed=300.0)).moves
    without = generate(BEAM, replace(PLAN, overhang_speed=0.0)).moves
    for layer in (0, FIRST_OF_BEAM):
        assert set(moves.speed[moves.layer == layer]) == set(without.speed[without.layer == layer])


def test_upright_walls_are_done_with_at_once():
    printed = generate(cylinder(), PLAN)
    assert undersides(printed.mesh, printed.slices.layers.plane, PLAN) is None
    beam = generate(BEAM, PLAN)
    found = undersides(beam.mesh, beam.slices.layers.plane, PLAN)
    assert np.flatnonzero(found.on).tolist() == [FIRST_OF_BEAM]
    x = np.array([0.0, 9.5, -9.5, 0.0, 0.0])
    y = np.array([4.8, 4.8, -4.8, 40.0, -300.0])
    assert found.near(x, y, np.full(5, FIRST_OF_BEAM)).tolist()[:3] == [True] * 3
