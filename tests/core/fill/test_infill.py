"""Patterns of sparse fill: the density that comes out, and the curves that they claim to be."""

import numpy as np
import pytest
import shapely
from dualcolor.core.fill.concentric import nested
from dualcolor.core.fill.walls import walls_and_fill
from dualcolor.core.paths import Feature
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.core.fill.fill_shapes import (
    WIDTH,
    blobs,
    fill_paths,
    lines_of,
    shapes,
    square,
    stack,
    table_is_sound,
)

PATTERNS = ["rectilinear", "grid", "triangles", "gyroid", "concentric"]
SPARSE = {"bottom_solid_layers": 0, "top_solid_layers": 0}


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize("density", [8.0, 20.0, 45.0])
def test_density_is_what_was_asked_for(density, pattern):
    plan = PrintSettings(infill_density=density, infill_pattern=pattern, infill_angle=30, **SPARSE)
    period = 2 * np.pi * 0.3913 * WIDTH * 100 / density
    layers = round(period / plan.layer_height) if pattern == "gyroid" else 2
    side = 100 if pattern == "gyroid" else 400
    sliced, islands, layer = stack([square(side)] * layers)
    paths = fill_paths(sliced, islands, layer, plan)
    lines = lines_of(paths, Feature.INFILL)
    area = walls_and_fill(islands[:1], np.full(1, WIDTH), plan)[1][0].area
    if pattern != "concentric":  # away from the walls, where lines are joined along them
        lines, area = shapely.intersection(lines, square(side - 12)), (side - 12) ** 2
    assert shapely.length(lines).sum() * WIDTH / area / layers == pytest.approx(density / 100, rel=0.05)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_fill_stays_inside_its_region_and_is_joined(pattern):
    islands = blobs(12, 21)
    layer = np.arange(12)
    plan = PrintSettings(infill_density=20, infill_pattern=pattern, **SPARSE)
    paths = fill_paths(islands, islands, layer, plan)
    table_is_sound(paths)
    fill = walls_and_fill(islands, np.full(12, WIDTH), plan)[1]
    chosen = paths.feature == Feature.INFILL
    lines = lines_of(paths, Feature.INFILL)
    # A straight link may cut across a bend of the wall by half a line.
    assert shapely.covers(shapely.buffer(fill, 0.55 * WIDTH)[paths.island[chosen]], lines).all()
    assert (paths.closed[chosen] == (pattern == "concentric")).all()
    spans = 2 * shapely.area(fill).sum() * 0.2 / WIDTH / 20.0  # about, lines being 20 mm long
    assert 12 <= len(lines) < 0.6 * spans or pattern == "concentric"


@pytest.mark.parametrize("pattern", ["rectilinear", "grid", "triangles", "gyroid"])
@pytest.mark.parametrize("overlap", [0.0, 15.0])
def test_sparse_strands_reach_into_the_wall_by_the_overlap(overlap, pattern):
    # The strands, not their middles: links that lay on the wall made it bulge.
    plan = PrintSettings(infill_density=20, infill_pattern=pattern, infill_overlap=overlap, **SPARSE)
    sliced, islands, layer = stack([square(32)] * 8)
    paths = fill_paths(sliced, islands, layer, plan)
    edge = 15 - 1.5 * WIDTH  # of the inner wall, whose middle lies a line within the island
    reach = np.abs(shapely.get_coordinates(lines_of(paths, Feature.INFILL))).max() + WIDTH / 2 - edge
    assert reach == pytest.approx(overlap / 100 * WIDTH, abs=0.15 if pattern == "gyroid" else 1e-3)  # of chords


@pytest.mark.parametrize("turned", [0.0, 37.0])
def test_the_gyroid_is_the_implicit_surface(turned):
    density = 15.0
    scale = 0.3913 * WIDTH * 100 / density
    plan = PrintSettings(
        infill_density=density, infill_pattern="gyroid", infill_angle=turned, first_layer_height=0.3, **SPARSE
    )
    sliced, islands, layer = stack([square(30)] * 60)  # more than two periods
    paths = fill_paths(sliced, islands, layer, plan)
    chosen = np.repeat(paths.feature == Feature.INFILL, np.diff(paths.start))
    inside = chosen & (np.abs(paths.points).max(axis=1) < 12.0)
    height = np.where(paths.layer == 0, 0.15, 0.3 + (paths.layer - 0.5) * 0.25)
    z = np.repeat(height, np.diff(paths.start))[inside] / scale
    angle = np.radians(-turned)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    x, y = (paths.points[inside] @ turn / scale).T
    value = np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)
    assert inside.sum() > 10000
    assert np.abs(value).max() < 1e-9


def test_gyroid_chords_stay_close_to_the_curve():
    plan = PrintSettings(infill_density=15, infill_pattern="gyroid", **SPARSE)
    sliced, islands, layer = stack([square(30)] * 30)
    paths = fill_paths(sliced, islands, layer, plan)
    scale = 0.3913 * WIDTH * 100 / 15
    within = np.repeat(paths.feature == Feature.INFILL, np.diff(paths.start))[:-1]
    within[paths.start[1:-1] - 1] = False
    ends = np.stack([paths.points[:-1], paths.points[1:]])[:, within]
    within = (np.abs(ends).max(axis=(0, 2)) < 12.0).nonzero()[0]
    angle = np.radians(-45)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    row = np.repeat(paths.layer, np.diff(paths.start))[:-1]
    row = row[np.repeat(paths.feature == Feature.INFILL, np.diff(paths.start))[:-1] & _not_last(paths)]
    z = np.where(row == 0, 0.125, 0.25 + (row - 0.5) * 0.25)[within] / scale
    x, y = (ends.mean(axis=0)[within] @ turn / scale).T
    value = np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)
    slope = np.hypot(np.cos(x) * np.cos(y) - np.sin(z) * np.sin(x), np.cos(y) * np.cos(z) - np.sin(x) * np.sin(y))
    assert (np.abs(value) / np.maximum(slope, 0.3) * scale).max() < 0.12


def _not_last(paths):
    keep = np.ones(len(paths.points) - 1, dtype=bool)
    keep[paths.start[1:-1] - 1] = False
    return keep


def test_triangles_run_in_three_directions_through_common_points():
    plan = PrintSettings(infill_density=12, infill_pattern="triangles", infill_angle=10, **SPARSE)
    sliced, islands, layer = stack([square(100)] * 2)
    paths = fill_paths(sliced, islands, layer, plan)
    spacing = 3 * WIDTH / 0.12
    step = np.diff(paths.points, axis=0)[_not_last(paths)]
    owner = np.repeat(paths.feature == Feature.INFILL, np.diff(paths.start))[:-1][_not_last(paths)]
    middle = ((paths.points[1:] + paths.points[:-1]) / 2)[_not_last(paths)][owner]
    step = step[owner]
    lengths = []
    for direction in np.radians([10, 70, 130]):
        normal = np.array([-np.sin(direction), np.cos(direction)])
        along = (np.abs(step @ normal) < 1e-6) & (np.hypot(*step.T) > 10)
        number = (middle[along] @ normal) / spacing
        assert np.allclose(number, np.round(number), atol=1e-6)
        lengths.append(np.hypot(*step[along].T).sum())
    assert np.ptp(lengths) < 0.05 * sum(lengths)


def test_concentric_loops_divide_a_square_and_a_ring_evenly():
    ring = shapely.difference(shapely.Point(0, 0).buffer(30, 64), shapely.Point(0, 0).buffer(18, 64))
    levels, owner = nested(shapes([square(40), shapely.Polygon(), ring]), 4.3)
    # The square is 20 mm deep: five loops; the ring 12 mm across: one loop, at 3 mm from both its edges.
    assert sorted(owner.tolist()) == [0] * 5 + [2]
    sides = sorted(np.ptp(shapely.get_coordinates(level)[:, 0]) for level in levels[owner == 0])
    assert sides == pytest.approx([4, 12, 20, 28, 36])
    hole = levels[owner == 2][0]
    assert hole.bounds[2] == pytest.approx(27, abs=0.1)
    assert shapely.Polygon(hole.interiors[0]).bounds[2] == pytest.approx(21, abs=0.1)
