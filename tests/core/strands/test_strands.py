"""Strands are the extruding moves and nothing else, with the extruded volume."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from dualcolor.core.paths import Feature
from dualcolor.core.strands.settling import sag_depth, settled
from dualcolor.core.strands.spans import FARTHEST, unsupported_distance
from dualcolor.core.strands.strands import Strands, semi_axes, split_by_roundness, strands
from dualcolor.core.toolpaths.moves import Moves
from dualcolor.tests.strand_volume import volume_mm3


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
    np.testing.assert_allclose(across / up, width / height)


def test_in_mid_air_it_is_the_circle_of_the_same_area():
    width, height = np.array([0.4, 0.6]), np.array([0.25, 0.1])
    across, up = semi_axes(width, height, 1.0)
    np.testing.assert_allclose(2 * across, np.sqrt(4 * width * height / np.pi))
    np.testing.assert_allclose(across, up)


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


def laid(*lines, width=0.4, height=0.2) -> Strands:
    """Strands from (layer, points) pairs, points being (x, y)."""
    counts = [len(points) for _, points in lines]
    layer = np.array([layer for layer, _ in lines], dtype=np.int64)
    z = np.repeat((layer + 0.5) * height, counts)
    points = np.column_stack([np.concatenate([np.array(points, dtype=float) for _, points in lines]), z])
    start = np.concatenate([[0], np.cumsum(counts)])
    feature = np.full(len(lines), int(Feature.OUTER_WALL))
    none = np.zeros(len(z))
    row = np.arange(len(z))
    heights = np.full(len(lines), height)
    return Strands(points, start, layer % 2, feature, layer, np.full(len(z), width), heights, none, none, row)


def of_layer(found: Strands, layer: int) -> slice:
    (number,) = np.flatnonzero(found.layer == layer)
    return slice(*found.start[number : number + 2].tolist())


def bridge(span: float, **size) -> Strands:
    """A line along x over two lines across it, `span` apart."""
    return laid((0, [(0, -5), (0, 5)]), (0, [(span, -5), (span, 5)]), (1, [(0, 0), (span, 0)]), **size)


def test_a_line_on_a_line_stays_as_it_is():
    straight = laid((0, [(0, 0), (30, 0)]), (1, [(0, 0), (30, 0)]), (2, [(0.5, 0.19), (29.5, 0.19)]))
    found = settled(straight, 0.3)
    np.testing.assert_array_equal(found.points, straight.points)
    np.testing.assert_array_equal(found.roundness, 0)
    np.testing.assert_array_equal(found.start, straight.start)


def test_the_first_layer_lies_on_the_bed_even_where_it_is_not_called_0():
    found = settled(laid((4, [(0, 0), (30, 0)])), 0.3)
    assert found.points[:, 2].tolist() == pytest.approx([0.9, 0.9]) and not found.roundness.any()


def test_a_bridge_sinks_between_its_supports():
    span = 10.0
    found = settled(bridge(span), sag=2.0)
    line = of_layer(found, 1)
    x, z = found.points[line, 0], found.points[line, 2]
    free = np.clip(np.minimum(x, span - x) - 0.2, 0, None)
    np.testing.assert_allclose(z, 0.3 - sag_depth(free, 2.0), atol=1e-9)
    assert np.diff(x).max() <= 0.5 and x[0] == 0 and x[-1] == span
    eased = np.clip(free / 0.2, 0, 1)
    np.testing.assert_allclose(found.roundness[line], eased**2 * (3 - 2 * eased), atol=1e-3)
    assert found.roundness[line][len(x) // 2] == 1 and found.roundness[line][0] == 0
    # Cube root of 3 · 1040 · 9.81 · 1 s · (2 · 4.8 mm)⁴ / (128 · 10⁴ Pa·s), in meters, with the limit's effect on top.
    unlimited = (3 * 1040 * 9.81 * 0.0096**4 / 128e4) ** (1 / 3) * 1e3
    assert 0.3 - z.min() == pytest.approx(2.0 * np.tanh(unlimited / 2.0), rel=1e-6)


def test_sparse_infill_sinks_alike_with_half_the_points():
    lines = bridge(10.0)
    seen = settled(lines, 0.3)
    hidden = settled(replace(lines, feature=np.full(len(lines), int(Feature.INFILL))), 0.3)
    of_seen, of_hidden = (found.points[of_layer(found, 1)] for found in (seen, hidden))
    assert len(of_hidden) < 0.6 * len(of_seen) and np.diff(of_hidden[:, 0]).max() <= 1.0
    np.testing.assert_allclose(of_hidden[:, 2], np.interp(of_hidden[:, 0], of_seen[:, 0], of_seen[:, 2]), atol=0.005)


def test_sag_grows_with_the_span_up_to_its_limit():
    deepest = []
    for span in (1.0, 2.0, 5.0, 20.0, 50.0):
        found = settled(bridge(span), 0.25)
        deepest.append(0.3 - found.points[of_layer(found, 1), 2].min())
    assert deepest == sorted(deepest)
    assert 0.0 < deepest[0] < 0.03 and 0.24 < deepest[-1] <= 0.25
    flat = settled(bridge(5.0), 0.0)
    np.testing.assert_allclose(flat.points[of_layer(flat, 1), 2], 0.3)


def test_a_loose_end_hangs_lowest():
    found = settled(laid((0, [(0, 0), (10, 0)]), (1, [(5, 0), (13, 0)])), 0.3)
    line = of_layer(found, 1)
    x, z = found.points[line, 0], found.points[line, 2]
    assert (np.diff(z) <= 1e-12).all() and (z[x <= 10.2] == pytest.approx(0.3)) and z[-1] < 0.25


def test_waves_in_opposite_phase_rest_where_they_cross():
    x = np.linspace(0, 12, 241)
    below, above = 0.375 * np.cos(2 * np.pi * x / 1.2), -0.375 * np.cos(2 * np.pi * x / 1.2)
    waves = laid((0, np.column_stack([x, below])), (1, np.column_stack([x, above])), (2, np.column_stack([x, above])))
    found = settled(waves, 0.3)
    line = slice(found.start[1], found.start[2])
    dense = np.linspace(0, 12, 24001)
    curve = np.column_stack([dense, 0.375 * np.cos(2 * np.pi * dense / 1.2)])
    away = np.array([np.hypot(*(curve - point).T).min() for point in np.column_stack([x, above])])
    across = 0.75 * np.abs(np.cos(2 * np.pi * x / 1.2))
    assert (away <= across + 1e-9).all()
    free = unsupported_distance(waves.points, waves.start, waves.layer, waves.width)[241:482]
    np.testing.assert_allclose(free, np.clip(away - 0.2, 0, None), atol=0.03)
    assert found.roundness[line].max() > 0.5 and found.roundness[line].min() == 0
    assert not found.roundness[found.start[2] :].any()  # the third lies on the second


def test_nothing_jumps_along_a_strand():
    found = settled(bridge(7.3), 0.3)
    line = of_layer(found, 1)
    step = np.diff(found.points[line, 0])
    assert np.abs(np.diff(found.points[line, 2]) / step).max() < 0.2
    assert np.abs(np.diff(found.roundness[line]) / step).max() < 1.5 / 0.2 + 0.1


def test_the_unsupported_distance_is_that_to_the_nearest_strand_below():
    rng = np.random.default_rng(5)
    ends = rng.uniform(-12, 12, (40, 2, 2))
    lines = [(k % 2, np.linspace(a, b, 60)) for k, (a, b) in enumerate(ends)]
    many = laid(*lines)
    found = unsupported_distance(many.points, many.start, many.layer, many.width)
    layer = np.repeat(many.layer, np.diff(many.start))
    for point, free in zip(many.points[layer == 1, :2], found[layer == 1], strict=True):
        a, b = ends[0::2, 0], ends[0::2, 1]
        share = np.clip(((point - a) * (b - a)).sum(1) / ((b - a) ** 2).sum(1), 0, 1)
        true = np.hypot(*(a + share[:, None] * (b - a) - point).T).min() - 0.2
        assert free == pytest.approx(np.clip(true, 0, FARTHEST), abs=0.02 + 0.05 * max(true, 0))
    assert not found[layer == 0].any()


def test_a_sunken_strand_keeps_its_volume():
    straight = bridge(6.0)
    found = settled(straight, 0.5)
    assert volume_mm3(found).sum() == pytest.approx(volume_mm3(straight).sum(), rel=1e-9)
    line = of_layer(found, 1)
    assert 0.97 * 0.4 < found.width[line].min() < 0.4


def test_parts_of_even_roundness_meet_at_their_ends():
    whole = settled(bridge(10.0), 0.3)
    parts, level = split_by_roundness(whole, 4)
    assert volume_mm3(parts).sum() == pytest.approx(volume_mm3(whole).sum(), rel=1e-9)
    mine = np.flatnonzero(parts.layer == 1)
    assert level[mine][0] < 1 and level[mine].max() == 1 and set(level[:2]) == {0}
    assert (np.diff(level[mine]) != 0).all()
    for a, b in itertools.pairwise(mine):
        np.testing.assert_array_equal(parts.points[parts.start[a + 1] - 1], parts.points[parts.start[b]])
    middle = np.concatenate([(parts.roundness[a:b][1:] + parts.roundness[a:b][:-1]) / 2 for a, b in
                             zip(parts.start[:-1], parts.start[1:], strict=True)])  # fmt: skip
    assert np.abs(middle - np.repeat(level, np.diff(parts.start) - 1)).max() <= 1 / 6 + 1e-9
