"""The first layer has lines of a width of its own: walls, skins and sparse fill, by place, distance and amount."""

import numpy as np
import pytest
from dualcolor.core.paths import Feature
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.solids import box

SIDE = 24.0
OWN = (Feature.OUTER_WALL, Feature.INNER_WALL, Feature.SKIN)


def plate(**values):
    plan = PrintSettings(flat_layers=2, skirt_distance=2.0, tower_type="none", perimeters=2, **values)
    return generate(box((0, 0, 0), (SIDE, SIDE, 1.0)), plan).moves


def rows_of(moves, layer, *features):
    return moves.extrudes & (moves.layer == layer) & np.isin(moves.feature, features)


@pytest.mark.parametrize("width", [0.3, 0.4, 0.6])
def test_all_lines_of_the_first_layer_have_its_width_and_fill_its_area(width):
    moves = plate(first_layer_extrusion_width=width)
    for feature in OWN:
        own = rows_of(moves, 0, feature)
        assert own.any() and np.allclose(moves.width[own], width)
        assert np.allclose(moves.width[rows_of(moves, 1, feature)], 0.4)
    volume = moves.filament[rows_of(moves, 0, *OWN)].sum() * np.pi / 4 * 1.75**2
    assert volume == pytest.approx(SIDE**2 * 0.25, rel=0.03)


@pytest.mark.parametrize("width", [0.3, 0.6])
def test_the_outer_edge_stays_and_walls_lie_a_width_apart(width):
    moves = plate(first_layer_extrusion_width=width)
    reach = [np.abs(moves.position[rows_of(moves, 0, feature), :2]).max() for feature in OWN[:2]]
    assert reach[0] == pytest.approx(SIDE / 2 - width / 2, abs=0.03)
    assert reach[0] - reach[1] == pytest.approx(width, abs=0.03)
    above = np.abs(moves.position[rows_of(moves, 1, Feature.OUTER_WALL), :2]).max()
    assert above == pytest.approx(SIDE / 2 - 0.2, abs=0.03)


def test_lines_of_skins_lie_a_width_apart():
    moves = plate(first_layer_extrusion_width=0.6)
    rows = np.flatnonzero(rows_of(moves, 0, Feature.SKIN))
    step = moves.position[rows, :2] - moves.position[rows - 1, :2]
    direction = np.array([1.0, 1.0]) / np.sqrt(2)
    along = np.abs(step @ direction) > 3
    place = np.unique(np.round(moves.position[rows[along], :2] @ [-direction[1], direction[0]], 4))
    assert len(place) > 20 and np.allclose(np.diff(place), 0.6, atol=1e-3)


def test_on_a_raft_the_object_has_no_first_layer_of_its_own():
    moves = plate(first_layer_extrusion_width=0.6, raft_layers=2)
    own = moves.extrudes & np.isin(moves.feature, OWN)
    assert np.allclose(moves.width[own], 0.4)


def reach_of_wall(moves, layer):
    return np.abs(moves.position[rows_of(moves, layer, Feature.OUTER_WALL), :2]).max(axis=0)


def test_elephant_foot_compensation_narrows_the_first_layer_alone():
    moves = plate(elephant_foot_compensation=0.15)
    assert reach_of_wall(moves, 0) == pytest.approx(SIDE / 2 - 0.2 - 0.15, abs=0.03)
    assert reach_of_wall(moves, 1) == pytest.approx(SIDE / 2 - 0.2, abs=0.03)
    volume = moves.filament[rows_of(moves, 0, *OWN)].sum() * np.pi / 4 * 1.75**2
    assert volume == pytest.approx((SIDE - 0.3) ** 2 * 0.25, rel=0.02)
    raised = plate(elephant_foot_compensation=0.15, raft_layers=2)
    assert reach_of_wall(raised, 2) == pytest.approx(SIDE / 2 - 0.2, abs=0.03)


@pytest.mark.parametrize(("thickness", "left"), [(0.7, 0.7), (1.0, 0.8), (2.0, 1.7)])
def test_elephant_foot_compensation_leaves_thin_walls_two_lines(thickness, left):
    plan = PrintSettings(pattern="offset", elephant_foot_compensation=0.15)
    moves = generate(box((0, 0, 0), (SIDE, thickness, 1.0)), plan).moves
    rows = rows_of(moves, 0, Feature.OUTER_WALL) & (np.abs(moves.position[:, 0]) < SIDE / 4)
    edge = np.abs(moves.position[rows, 1]) + moves.width[rows] / 2
    assert edge == pytest.approx(left / 2, abs=0.01)
