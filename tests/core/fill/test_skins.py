"""Skins without holes: the area that walls, skins and the lines in gaps cover, against the region inside the wave."""

import numpy as np
import pytest
import shapely
from dualcolor.core.fill.gap_fill import gap_paths
from dualcolor.core.paths import Feature, Paths
from dualcolor.core.pipeline import generate
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.core.fill.fill_shapes import WIDTH, fill_paths, lines_of, shapes, square, table_is_sound
from dualcolor.tests.real_models import image_file, obj_model
from dualcolor.tests.solids import box, joined, lathe, surface

SOLID = PrintSettings(infill_density=100, skirt_distance=2.0)
BESIDE = (Feature.TOWER, Feature.SKIRT)


def strands(moves, layer):
    """Footprints of a layer's strands, without those of what stands beside the object."""
    rows = np.flatnonzero(moves.extrudes & (moves.layer == layer) & ~np.isin(moves.feature, BESIDE))
    ends = np.stack([moves.position[rows - 1, :2], moves.position[rows, :2]], axis=1)
    return shapely.buffer(shapely.linestrings(ends), moves.width[rows] / 2 + 0.01, quad_segs=4)


def holes(job, layer):
    """(H,) mm², what nothing covers inside the outer wall of a solid layer."""
    printed = shapely.union_all(strands(job.moves, layer))
    waved = [
        shapely.Polygon(job.outlines.points[low:high])
        for low, high, at in zip(job.outlines.start, job.outlines.start[1:], job.outlines.layer, strict=False)
        if at == layer and high - low > 3
    ]
    around = shapely.union_all([shapely.buffer(polygon, 0) for polygon in waved if polygon.exterior.is_ccw])
    around = shapely.difference(around, shapely.union_all([p for p in waved if not p.exterior.is_ccw]))
    bare = shapely.get_parts(shapely.buffer(shapely.difference(around, printed), -0.02))
    return shapely.area(bare)


def lines_in(gaps):
    """The lines in gaps, each of an island and a layer of its own."""
    with gap_paths([shapes(gaps)], (0.0,), np.arange(len(gaps)), np.full(len(gaps), WIDTH)) as lines:
        return Paths.joined(lines())


@pytest.mark.parametrize("pattern", ["wave_offset", "offset"])
@pytest.mark.parametrize("perimeters", [1, 3])
def test_no_holes_in_necks_of_any_width(pattern, perimeters):
    wedge = surface(
        [[0, 0, 0], [40, 3.2, 0], [0, 6.4, 0], [0, 0, 2], [40, 3.2, 2], [0, 6.4, 2]],
        [[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]],
    )
    job = generate(wedge, SOLID.changed({"pattern": pattern, "perimeters": perimeters}))
    for layer in range(3, 6):
        assert holes(job, layer).max(initial=0.0) < 1.0


def test_no_holes_in_discs_rings_and_plates():
    ring = lathe([[6, 0], [9.3, 0], [9.3, 2], [6, 2], [6, 0]])
    for model in (lathe([[12, 0], [12, 2]]), joined(box((0, 0, 0), (30, 4.1, 2))), ring):
        job = generate(model, SOLID)
        assert max(holes(job, layer).max(initial=0.0) for layer in range(job.report["layers"])) < 1.0


@pytest.mark.parametrize(
    "mesh, height, layers",
    [
        ("meshes/spot/spot.obj", 50, [1, 40, 90, 120, 160, 190]),
        ("meshes/nc/gargoyle.obj", 60, [1, 20, 100, 180, 200, 230]),
    ],
)
def test_no_skin_of_a_real_model_has_a_hole(data, mesh, height, layers):
    path = data / mesh
    if not path.is_file():
        pytest.skip(f"{mesh} is not here")
    texture = image_file(data / "meshes/spot/spot_texture.png")
    job = generate(obj_model(path, height, [texture]), SOLID)
    greatest = {layer: holes(job, layer).max(initial=0.0) for layer in layers}
    assert max(greatest.values()) < 1.0, greatest


@pytest.mark.parametrize("pattern, pockets", [("wave_offset", 0.32), ("offset", 0.0)])
@pytest.mark.parametrize("neck", [0.6, 0.65, 0.75])
def test_a_neck_too_narrow_for_a_wall_gets_one_line_along_its_middle(neck, pattern, pockets):
    dumbbell = shapely.union_all([square(10, 0, -12), square(10, 0, 12), shapely.box(-neck / 2, -10, neck / 2, 10)])
    islands = shapes([dumbbell])
    settings = PrintSettings(infill_density=100, pattern=pattern)
    paths = fill_paths(islands, islands, np.zeros(1, dtype=np.int64), settings)
    assert (paths.feature == Feature.INNER_WALL).sum() == 2  # one in each square
    lines = lines_of(paths, Feature.SKIN)
    inside = np.flatnonzero(np.abs(shapely.get_y(shapely.centroid(lines))) < 6)
    assert len(inside) == 1
    west, south, east, north = lines[inside[0]].bounds
    assert west > -0.12 and east < 0.12 and south < -6.5 and north > 6.5
    skin = np.flatnonzero(paths.feature == Feature.SKIN)[inside[0]]
    points = slice(paths.start[skin], paths.start[skin + 1])
    middle = np.abs(paths.points[points, 1]) < 6.5
    # As wide as the neck between the walls' edges, and 0.16 mm into each of them where waves leave pockets.
    assert np.allclose(paths.width[points][middle], min(neck - WIDTH + pockets, 2 * WIDTH), atol=0.02)


def test_walls_that_meet_have_no_line_between_them():
    dumbbell = shapely.union_all([square(10, 0, -12), square(10, 0, 12), shapely.box(-0.23, -10, 0.23, 10)])
    islands = shapes([dumbbell])
    paths = fill_paths(islands, islands, np.zeros(1, dtype=np.int64), PrintSettings(infill_density=100))
    assert np.abs(shapely.get_y(shapely.centroid(lines_of(paths, Feature.SKIN)))).min() > 6


@pytest.mark.parametrize("thickness", [0.6, 0.8, 0.85, 0.9, 0.94, 1.1, 1.2, 1.3, 1.4, 1.75, 1.8, 1.9, 2.0])
def test_a_thin_wall_takes_as_much_plastic_as_it_has_room(thickness):
    """Whatever `infill_density` is for wider places, unless the print is to be hollow."""
    for density in (100.0, 10.0) if thickness > 1.6 else (10.0,):
        flat = PrintSettings(background_tone=0.5, calibration="none", offset_max=0.0, infill_density=density)
        assert printed_share(thickness, flat) == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("thickness", [2.2, 2.6, 3.0])
def test_lines_across_narrow_walls_overfill_them_by_their_overlap_at_most(thickness):
    """Links from line to line would add half as much again."""
    flat = PrintSettings(background_tone=0.5, calibration="none", offset_max=0.0, infill_density=100.0)
    overlap = 2 * 0.15 * WIDTH / thickness
    assert 1.0 < printed_share(thickness, flat) < 1.01 + overlap


@pytest.mark.parametrize("thickness", [0.6, 0.8, 0.9, 1.0, 1.1])
@pytest.mark.parametrize("pattern", ["wave", "wave_offset"])
@pytest.mark.parametrize("perimeters", [0, 1])
def test_a_wall_too_thin_for_waves_takes_no_more_than_it_has_room(thickness, pattern, perimeters):
    """Waves leave pockets that lines in the gaps behind them fill; where there is no wave there are none."""
    waved = PrintSettings(pattern=pattern, background_tone=0.5, calibration="none", perimeters=perimeters)
    assert printed_share(thickness, waved) == pytest.approx(1.0, abs=0.06)


@pytest.mark.parametrize("thickness", [1.8, 2.0])
def test_a_gap_between_waves_leaves_no_void_that_one_line_can_fill(thickness):
    """Pockets of the waves stay; a gap that has no room for two walls takes a line up to twice as wide as usual."""
    waved = PrintSettings(pattern="wave", background_tone=0.5, calibration="none")
    assert printed_share(thickness, waved) > 0.9


def printed_share(thickness, settings):
    """What a tube takes of the plastic that has room in it."""
    model = lathe([[10 - thickness, 0], [10, 0], [10, 3], [10 - thickness, 3], [10 - thickness, 0]])
    moves = generate(model, settings).moves
    rows = moves.extrudes & ~np.isin(moves.feature, BESIDE)
    printed = moves.filament[rows].sum() * np.pi / 4 * 1.75**2
    return printed / (3 * np.pi * (10**2 - (10 - thickness) ** 2))


def test_what_is_inside_narrow_walls_stays_empty_in_a_hollow_print():
    flat = PrintSettings(background_tone=0.5, calibration="none", offset_max=0.0, infill_density=0.0)
    hollow = flat.changed({"top_solid_layers": 0, "bottom_solid_layers": 0})
    assert printed_share(2.0, hollow) == pytest.approx(0.8, abs=0.02)


def test_no_gap_is_too_regular_for_its_middle():
    # GEOS finds no Delaunay triangulation of the points along this one's boundary.
    half = [
        [0.1499379871182146, -14.19685552009811],
        [0.1359514948450813, -14.5398680675337],
        [0.1265011245393188, -14.542276422438247],
        [-0.1398580881899115, -14.534166814537215],
        [-0.1434750310349929, -14.521534226477337],
    ]
    gap = shapely.Polygon([*half, *(-np.array(half))])
    paths = lines_in([gap])
    assert np.ptp(paths.points[:, 1]) > 28 and paths.width.max() < 0.31


@pytest.mark.parametrize("ripple", [0.0, 0.015])
def test_a_line_in_a_gap_holds_as_much_as_the_gap_and_is_no_zigzag(ripple):
    """Sides that are rough by less than a strand notices, as outlines of scans are."""
    x = np.arange(0, 20, 0.1)
    rough = np.random.default_rng(2).normal(size=(2, len(x))) * ripple
    sides = [np.column_stack([x, 0.3 + rough[0]]), np.column_stack([x, rough[1]])[::-1]]
    gap = shapely.Polygon(np.concatenate(sides))
    paths = lines_in([gap])
    lines = np.split(paths.points, paths.start[1:-1])
    ways = [np.append(np.hypot(*np.diff(line, axis=0).T), 0.0) for line in lines]
    assert (np.concatenate(ways) * paths.width).sum() == pytest.approx(gap.area, rel=0.02)
    assert len(paths.points) < 80


def test_lines_in_gaps_are_as_long_whatever_lies_above():
    finger = shapely.union(square(10), shapely.box(-0.3, 0, 0.3, 12))
    alone, stacked = (lines_in(found) for found in ([finger - square(9.9)], [finger - square(9.9)] * 3))
    assert len(stacked.layer) == 3 * len(alone.layer) > 0
    assert np.allclose(stacked.points, np.tile(alone.points, (3, 1)))
    assert alone.points[:, 1].max() == pytest.approx(12.0)


def test_what_walls_fill_has_no_lines_in_gaps():
    islands = shapes([square(20), shapely.Point(0, 0).buffer(9, 64)])
    layer = np.array([3, 4])
    sliced = shapes([square(20)] * 9)
    paths = fill_paths(sliced, islands, layer, PrintSettings(perimeters=4))
    table_is_sound(paths)
    assert set(paths.feature) == {Feature.INNER_WALL, Feature.INFILL}
