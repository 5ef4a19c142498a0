"""What the points of strands know of their moves."""

import numpy as np
import pytest
from dualcolor.core.paths import Feature
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.strands.point_attributes import NO_TONE, moves_of_layers, point_attributes, tone_of_moves
from dualcolor.core.strands.settling import settled
from dualcolor.core.strands.strands import strands
from dualcolor.tests.solids import box


@pytest.fixture(scope="module", params=[0, 2])
def printed(request):
    """A brick whose tone is 0.7, with and without a raft."""
    return generate(box((0, 0, 0), (12, 9, 2)), PrintSettings(background_tone=0.7, raft_layers=request.param))


def test_moves_are_numbered_within_their_layer(printed):
    moves = printed.moves
    laid = strands(moves)
    number = point_attributes(moves)(laid)["move"]
    level = np.repeat(laid.layer, np.diff(laid.start))
    for layer, count in enumerate(moves_of_layers(moves)):
        assert count == np.count_nonzero(moves.extrudes & (moves.layer == layer))
        mine = number[level == layer]
        assert mine[0] == 0 and mine[-1] == count - 1
        assert (np.diff(mine) >= 0).all() and len(np.unique(mine)) == count


def test_points_have_the_speed_of_their_move(printed):
    moves = printed.moves
    laid = settled(strands(moves), 0.3)
    speed = point_attributes(moves)(laid)["speed"]
    skin = np.repeat(laid.feature == Feature.SKIN, np.diff(laid.start))
    expected = moves.speed[(moves.feature == Feature.SKIN) & moves.extrudes]
    assert set(np.unique(speed[skin])) <= set(np.unique(expected))
    assert speed.min() == moves.speed[moves.extrudes].min()


def test_the_outer_wall_has_the_tone_asked_for_and_nothing_else_has_one(printed):
    tone = tone_of_moves(printed.outlines, printed.moves, printed.settings.raft_layers)
    wall = printed.moves.feature == Feature.OUTER_WALL
    assert wall.any()
    np.testing.assert_allclose(tone[wall], 0.7, atol=1e-6)
    assert (tone[~wall] == NO_TONE).all()


def test_each_place_has_its_own_tone(printed):
    outlines = printed.outlines
    painted = type(outlines)(**{**vars(outlines), "tone": outlines.points[:, 0]})
    tone = tone_of_moves(painted, printed.moves, printed.settings.raft_layers)
    wall = np.flatnonzero(printed.moves.feature == Feature.OUTER_WALL)
    away = np.abs(tone[wall] - printed.moves.position[wall, 0])
    assert (away < 1e-9).mean() > 0.95 and away.max() < 1.0


def test_walls_above_all_outlines_have_no_tone(printed):

    moves, layers = printed.moves, printed.outlines.layer.max() + 1
    wall = moves.feature == Feature.OUTER_WALL
    tone = tone_of_moves(printed.outlines, moves, printed.settings.raft_layers - layers)
    assert (tone[wall] == NO_TONE).all()


def test_unsupported_distance_is_that_of_the_settled_strands(printed):
    laid = settled(strands(printed.moves), 0.3)
    found = point_attributes(printed.moves)(laid)
    np.testing.assert_array_equal(found["unsupported"], laid.unsupported)
    assert (found["tone"] == NO_TONE).all()
