"""Strands are the extruding moves and nothing else, with the extruded volume."""

import numpy as np
import pytest
from dualcolor.core.beads import semi_axes, strands, volume_mm3
from dualcolor.core.toolpaths.moves import Feature, Moves


def table(rows: list[tuple]) -> Moves:
    """Moves from (x, y, z, tool, feature, layer, width, height, filament) rows."""
    x, y, z, tool, feature, layer, width, height, filament = (np.array(column) for column in zip(*rows, strict=True))
    position = np.stack([x, y, z], axis=1).astype(float)
    speed = np.full(len(rows), 30.0)
    return Moves(position, tool, feature, layer, width * 1.0, height * 1.0, speed, filament * 1.0)


def two_layers() -> Moves:
    wall, tower, travel, retract = Feature.OUTER_WALL, Feature.TOWER, Feature.TRAVEL, Feature.RETRACT
    return table(
        [
            (0, 0, 0.3, 0, travel, 0, 0, 0, 0),
            (10, 0, 0.3, 0, wall, 0, 0.4, 0.3, 1),
            (10, 5, 0.3, 0, wall, 0, 0.5, 0.3, 1),
            (10, 5, 0.3, 0, retract, 0, 0, 0, -1),
            (20, 5, 0.3, 0, travel, 0, 0, 0, 0),
            (20, 5, 0.3, 0, retract, 0, 0, 0, 1),
            (24, 5, 0.3, 0, wall, 0, 0.4, 0.3, 1),
            (24, 8, 0.3, 0, tower, 0, 0.4, 0.3, 1),
            (0, 0, 0.55, 1, travel, 1, 0, 0, 0),
            (0, 7, 0.55, 1, wall, 1, 0.4, 0.25, 1),
        ]
    )


def test_runs_of_one_kind_become_strands_that_start_where_the_nozzle_stood():
    laid = strands(two_layers())
    assert laid.start.tolist() == [0, 3, 5, 7, 9]
    assert laid.tool.tolist() == [0, 0, 0, 1]
    assert laid.layer.tolist() == [0, 0, 0, 1]
    assert laid.feature.tolist() == [Feature.OUTER_WALL, Feature.OUTER_WALL, Feature.TOWER, Feature.OUTER_WALL]
    assert laid.points[:3, :2].tolist() == [[0, 0], [10, 0], [10, 5]]
    assert laid.points[3:5, :2].tolist() == [[20, 5], [24, 5]]
    assert laid.points[5:7, :2].tolist() == [[24, 5], [24, 8]]
    assert laid.width.tolist() == [0.4, 0.4, 0.5, 0.4, 0.4, 0.4, 0.4, 0.4, 0.4]


def test_strands_lie_half_a_layer_below_the_nozzle():
    laid = strands(two_layers())
    assert laid.height.tolist() == [0.3, 0.3, 0.3, 0.25]
    np.testing.assert_allclose(laid.points[:7, 2], 0.15)
    np.testing.assert_allclose(laid.points[7:, 2], 0.55 - 0.125)


def test_every_extruding_row_is_one_segment():
    moves = two_layers()
    laid = strands(moves)
    segments = len(laid.points) - len(laid)
    assert segments == np.count_nonzero(moves.extrudes)


def test_the_oval_has_the_extruded_area_and_touches_the_layers_above_and_below():
    width, height = np.array([0.4, 0.6]), np.array([0.25, 0.1])
    across, up = semi_axes(width, height)
    np.testing.assert_allclose(np.pi * across * up, width * height)
    assert (2 * up > height).all()


def test_volume_is_length_times_width_times_height():
    np.testing.assert_allclose(
        volume_mm3(strands(two_layers())),
        [10 * 0.4 * 0.3 + 5 * 0.5 * 0.3, 4 * 0.4 * 0.3, 3 * 0.4 * 0.3, 7 * 0.4 * 0.25],
    )


def test_a_change_of_height_alone_begins_a_new_strand():
    rows = [(0, 0, 1, 0, 0, 0, 0, 0, 0), (1, 0, 1, 0, 2, 0, 0.4, 0.2, 1), (2, 0, 1, 0, 2, 0, 0.4, 0.3, 1)]
    assert strands(table(rows)).start.tolist() == [0, 2, 4]


@pytest.mark.parametrize("rows", [[], [(1, 0, 1, 0, 2, 0, 0.4, 0.2, 1)]])
def test_nothing_extruded_is_no_strand(rows):
    none = np.zeros(0, dtype=np.int64)
    moves = (
        table(rows)
        if rows
        else Moves(np.zeros((0, 3)), none, none, none, none * 1.0, none * 1.0, none * 1.0, none * 1.0)
    )
    laid = strands(moves)
    assert len(laid) == 0 and laid.start.tolist() == [0]
    assert volume_mm3(laid).tolist() == []


def test_selected_strands_keep_their_points():
    laid = strands(two_layers())
    chosen = laid.selected(laid.feature == Feature.OUTER_WALL)
    assert chosen.start.tolist() == [0, 3, 5, 7]
    np.testing.assert_array_equal(chosen.points[5:], laid.points[7:])
    assert chosen.tool.tolist() == [0, 0, 1]
