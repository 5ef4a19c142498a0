"""Scan lines and their joins against analytic shapes, and invariants on random ones."""

import numpy as np
import pytest
import shapely
from dualcolor.core.fill.bridges import bridged, bridges
from dualcolor.core.fill.hatch import crossings, spans
from dualcolor.core.fill.offsets import offset
from dualcolor.core.fill.paths import fill_areas, fill_lines, hatch_paths, plain_hatching, wall_areas
from dualcolor.core.fill.skins import skins
from dualcolor.core.fill.walls import walls_and_fill
from dualcolor.core.paths import Feature
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.core.fill.fill_shapes import (
    WIDTH,
    annulus,
    blobs,
    covering,
    fill_paths,
    lines_of,
    shapes,
    square,
    stack,
    table_is_sound,
)
from dualcolor.tests.robustness.strategies import examples
from hypothesis import given
from hypothesis import strategies as st


def length_along(lines, angle_deg):
    """Total length of the segments in one direction."""
    total = 0.0
    for line in lines:
        steps = np.diff(shapely.get_coordinates(line), axis=0)
        length = np.linalg.norm(steps, axis=1)
        across = steps @ [-np.sin(np.radians(angle_deg)), np.cos(np.radians(angle_deg))]
        total += length[np.abs(across) < 1e-6].sum()
    return total


@pytest.mark.parametrize("angle", [0.0, 17.0, 45.0, 90.0])
def test_solid_fill_covers_the_area_once(angle):
    sliced, islands, layer = stack([annulus(40, 12)])
    plan = PrintSettings(infill_density=100, infill_angle=angle)
    paths = fill_paths(sliced, islands, layer, plan)
    fill = walls_and_fill(islands, np.full(len(islands), WIDTH), plan)[1][0]
    lines = lines_of(paths, Feature.SKIN)
    assert shapely.length(lines).sum() * WIDTH == pytest.approx(fill.area, rel=0.03)
    assert shapely.covers(fill.buffer(1e-6), lines).all()
    assert len(lines) <= 6  # the ring falls into a few cells
    printed = shapely.union_all(shapely.buffer(lines, 0.5 * WIDTH + 1e-3))
    assert shapely.difference(fill.buffer(-WIDTH), printed).area < 0.005 * fill.area


@given(st.lists(st.tuples(st.integers(-6, 6), st.integers(-6, 6)), min_size=3, max_size=9), st.integers(1, 2))
@examples(80)
def test_vertices_on_scan_lines_do_not_break_the_pairing(corners, spacing):
    region = shapely.buffer(shapely.make_valid(shapely.Polygon(corners)), 0)
    on_grid = shapely.set_precision(shapely.set_precision(region, 1.0), 0.0)  # every vertex is on a scan line
    column = shapes([on_grid])
    cut = crossings(column, np.zeros(1), np.full(1, float(spacing)))
    found = spans(cut)
    assert (cut.line[found.left] == cut.line[found.right]).all()
    for line in range(-7, 8):
        row = cut.line[found.left] == line
        height = line * spacing + 1e-7  # a line takes what is just above it
        inside = shapely.intersection(on_grid, shapely.LineString([(-50, height), (50, height)]))
        assert (cut.x[found.right] - cut.x[found.left])[row].sum() == pytest.approx(inside.length, abs=1e-4)


@pytest.mark.parametrize("pattern", ["rectilinear", "grid"])
@pytest.mark.parametrize("density", [5.0, 10.0, 25.0, 60.0])
def test_density_is_the_share_of_the_area_under_lines(density, pattern):
    sliced, islands, layer = stack([square(102)] * 2)
    plan = PrintSettings(
        bottom_solid_layers=0, top_solid_layers=0, infill_density=density, infill_pattern=pattern, infill_angle=30
    )
    paths = fill_paths(sliced, islands, layer, plan)
    area = walls_and_fill(islands, np.full(len(islands), WIDTH), plan)[1][0].area
    for k, directions in enumerate(((30, 120), (30, 120)) if pattern == "grid" else ((30,), (-30,))):
        lengths = [length_along(lines_of(paths, Feature.INFILL, k), direction) for direction in directions]
        assert sum(lengths) * WIDTH / area == pytest.approx(density / 100, rel=0.04)
        assert np.ptp(lengths) < 0.05 * sum(lengths)


def test_sparse_lines_of_every_second_layer_stack_up():
    outline = blobs(1, 3)[0]
    shifted = [square(60), square(60), shapely.union(square(60), square(20, 30, 7)), square(60)]
    sliced, islands, layer = stack([*shifted, outline])
    plan = PrintSettings(bottom_solid_layers=0, top_solid_layers=0)
    paths = fill_paths(sliced, islands, layer, plan)

    def offsets(k, angle):
        steps = [shapely.get_coordinates(line) for line in lines_of(paths, Feature.INFILL, k)]
        normal = np.array([-np.sin(np.radians(angle)), np.cos(np.radians(angle))])
        found = [line[:-1] @ normal for line in steps]
        along = [np.abs(np.diff(line, axis=0) @ normal) < 1e-6 for line in steps]
        return np.concatenate(found)[np.concatenate(along)]

    for k in range(5):
        lines = offsets(k, 45 if k % 2 == 0 else -45) / 4.0
        assert len(lines) > 4 and np.allclose(lines, np.round(lines), atol=1e-6)


@pytest.mark.parametrize("pattern", ["rectilinear", "grid", "triangles"])
def test_random_regions_are_filled_once_and_never_left(pattern, monkeypatch):
    monkeypatch.setattr("dualcolor.core.fill.paths._CROWDED", 0.0)  # all lines of skins have the full width
    islands = blobs(24, 7)
    layer = np.arange(24) // 2
    plan = PrintSettings(infill_density=30, infill_pattern=pattern, bottom_solid_layers=1, top_solid_layers=2)
    sliced = shapes([shapely.unary_union(list(islands[layer == k])) for k in range(12)])
    inside = walls_and_fill(islands, np.full(len(islands), WIDTH), plan)[1]
    found = skins(inside, layer, covering(sliced), plan)
    spanned = bridges(inside, found, covering(sliced), layer, plan)
    walls = wall_areas(islands, np.full(len(islands), shapely.MultiLineString()), layer, plan)
    areas = fill_areas(walls[-1], found.regions, found.whole, plan)
    paths = fill_lines(walls, areas, spanned, layer, plan)
    table_is_sound(paths)
    solid, sparse = areas
    assert shapely.area(shapely.intersection(solid, sparse)).max() < 1e-6
    _, solid, sparse = bridged(spanned, solid, sparse)
    sparse = offset(sparse, -WIDTH / 2)  # lines lie within it with their whole width
    scanned, printed = 0, 0
    for feature, regions in ((Feature.SKIN, solid), (Feature.INFILL, sparse)):
        of_fill = paths.width[paths.start[:-1]] == WIDTH  # lines in gaps lie beside the regions
        lines = lines_of(paths, feature)[of_fill[paths.feature == feature]]
        island = paths.island[of_fill & (paths.feature == feature)]
        assert len(lines) and (paths.layer[of_fill & (paths.feature == feature)] == layer[island]).all()
        assert shapely.covers(shapely.buffer(regions, WIDTH)[island], lines).all()
        for k in range(24):
            crossed = {"grid": [45, 135], "triangles": [45, 105, 165]} if feature == Feature.INFILL else {}
            angles = crossed.get(pattern, [45 if layer[k] % 2 == 0 else -45])
            spacing = WIDTH if feature == Feature.SKIN else WIDTH / 0.3 * len(angles)
            for angle in angles:
                cut = crossings(regions[k : k + 1], np.full(1, float(angle)), np.full(1, spacing))
                found = spans(cut)
                length = cut.x[found.right] - cut.x[found.left]
                length = length[length >= WIDTH / 2]
                scanned += len(length)
                if feature == Feature.SKIN:
                    laid = shapely.length(lines[island == k]).sum() * WIDTH  # links included
                    assert laid == pytest.approx(regions[k].area, rel=0.013)
                else:
                    assert length_along(lines[island == k], angle) == pytest.approx(length.sum(), rel=1e-3, abs=0.5)
        printed += len(lines)
    assert printed < 0.2 * scanned  # joined into long spans


def test_joins_of_a_comb_stay_out_of_its_gaps():
    teeth = [shapely.box(3 * k, 0, 3 * k + 2, 20) for k in range(8)]
    comb = shapely.union_all([*teeth, shapely.box(0, 0, 23, 3)])
    plan = PrintSettings(infill_density=100, infill_angle=0, perimeters=0)
    islands = shapes([comb])
    lines = lines_of(fill_paths(islands, islands, np.zeros(1, dtype=np.int64), plan), Feature.SKIN)
    assert shapely.covers(comb, lines).all()
    assert len(lines) == 8  # one for each tooth, the first of them goes on into the back


def test_where_a_ring_starts_makes_no_difference():
    region = blobs(1, 13, span=30.0)[0]
    island = np.zeros(1, dtype=np.int64)
    plan = PrintSettings(infill_density=15)

    def rolled(ring, share):
        points = shapely.get_coordinates(ring)[:-1]
        return np.roll(points, int(share * len(points)), axis=0)

    results = []
    for share in np.linspace(0, 1, 40, endpoint=False):
        turned = shapely.Polygon(rolled(region.exterior, share), [rolled(hole, share) for hole in region.interiors])
        for solid, sparse in (([turned], [shapely.Polygon()]), ([shapely.Polygon()], [turned])):
            results.append(hatch_paths(plain_hatching(shapes(solid), shapes(sparse), island, plan), island))
    for first, later in ((results[0], results[2::2]), (results[1], results[3::2])):
        for paths in later:
            assert np.array_equal(paths.start, first.start)
            assert np.allclose(paths.points, first.points, atol=1e-9)
