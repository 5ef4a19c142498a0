"""Regions of pure black or white: found as a whole, printed in one color, all else untouched."""

from itertools import pairwise, product

import numpy as np
import pytest
from dualcolor.commands.terminal import summary
from dualcolor.core.contours.contours import contours
from dualcolor.core.contours.slant import slant_along
from dualcolor.core.exports import export_gcode, export_x3g
from dualcolor.core.gcode.reader import read_gcode
from dualcolor.core.job.wall_stages import pattern_tone
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.paths import Feature
from dualcolor.core.pattern.modulation import layer_is_black
from dualcolor.core.pattern.solid_regions import (
    _stretch,
    left_to_other_tool,
    runs,
    solid_regions,
    with_solid_regions,
)
from dualcolor.core.pattern.wave import modulated
from dualcolor.core.pipeline import generate
from dualcolor.core.sampling.projector import Projector
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.slices import slices
from dualcolor.core.strands.strands import strands
from dualcolor.core.texture.pyramid import build_pyramids
from dualcolor.core.toolpaths.tool_turns import _ends, tool_of_layer
from dualcolor.core.x3g.audit import audit
from dualcolor.core.x3g.moves import moves_of_x3g
from dualcolor.core.x3g.reader import read_x3g
from dualcolor.tests.gpx import convert
from dualcolor.tests.real_models import image_file, obj_model
from dualcolor.tests.solids import cylinder, picture

SETTINGS = PrintSettings(pattern="wave_offset", solid_regions="set_back", calibration="none")
SIDE = 128


def painted(**patches):
    """A gray picture, with (low u, high u, low v, high v) of black and white patches in eighths."""
    tone = np.full((SIDE, SIDE), 0.5)
    for name, (left, right, low, high) in patches.items():
        part = slice(low * SIDE // 8, high * SIDE // 8), slice(left * SIDE // 8, right * SIDE // 8)
        tone[part] = 0.0 if name.startswith("black") else 1.0
    return cylinder(radius=10, height=16, textures=[picture(tone)])


def found(model, settings=SETTINGS):
    mesh = triangulate(model, settings)
    cut = slices(mesh, settings)
    lines = contours(cut.outlines, cut.loop_polygon, settings)
    tone = pattern_tone(lines, build_pyramids(mesh, model.textures, 0.5, "trilinear"), settings)
    slant = slant_along(lines, mesh)
    projector = Projector(lines, settings.projection_threshold)
    return lines, tone, slant, solid_regions(lines, tone, slant, projector, settings)


def test_a_region_is_found_with_its_area_and_color():
    """A quarter of the way around, half of the height; the filter takes up to a wavelength off at each border."""
    *_, solid = found(painted(black=(2, 4, 2, 6)))
    whole = np.pi / 2 * 10 * 8
    assert solid.is_black.tolist() == [True]
    assert (np.pi / 2 * 10 - 2.8) * 6.5 < solid.area[0] < whole


def test_regions_are_told_apart_and_joined_across_the_seam():
    *_, solid = found(painted(black_low=(1, 3, 0, 3), black_high=(1, 3, 5, 8), white=(4, 6, 0, 8)))
    assert sorted(solid.is_black.tolist()) == [False, True, True]
    *_, around = found(painted(black_end=(7, 8, 0, 8), black_begin=(0, 1, 0, 8)))
    assert len(around.area) == 1
    *_, arch = found(painted(black_left=(1, 2, 0, 8), black_right=(4, 5, 0, 8), black_top=(1, 5, 6, 8)))
    assert len(arch.area) == 1


def test_small_regions_and_gray_are_left_alone():
    lines, tone, slant, solid = found(painted(black=(2, 4, 2, 6)), SETTINGS.changed({"solid_region_area": 200.0}))
    assert not len(solid.area) and (solid.region == -1).all()
    depth, set_back = modulated(lines, tone, slant, SETTINGS)
    after = with_solid_regions(lines, depth, set_back, slant, solid, SETTINGS)
    assert np.array_equal(after[0], depth) and np.array_equal(after[1], set_back)


@pytest.mark.parametrize("pattern", ["wave", "wave_offset", "offset"])
@pytest.mark.parametrize("black", [True, False])
def test_the_other_color_is_behind_and_nothing_waves(pattern, black):
    settings = SETTINGS.changed({"pattern": pattern})
    lines, tone, slant, solid = found(painted(**{"black" if black else "white": (2, 6, 0, 8)}), settings)
    before = modulated(lines, tone, slant, settings)
    depth, set_back = with_solid_regions(lines, *before, slant, solid, settings)
    outside = solid.region < 0
    assert np.array_equal(depth[outside], before[0][outside])
    assert np.array_equal(set_back[outside], before[1][outside])
    turn = np.degrees(np.arctan2(lines.points[:, 1], lines.points[:, 0])) % 360
    middle = (turn > 120) & (turn < 240)
    own = layer_is_black(lines.layer[lines.loop], PrintSettings()) == black
    assert depth[middle] == pytest.approx(0, abs=1e-9) and set_back[middle & own] == pytest.approx(0, abs=1e-9)
    assert set_back[middle & ~own] == pytest.approx(0.5)
    # Nowhere does a line jump: from a wavelength to the next the way back is made in steps.
    step = np.abs(np.diff(set_back))[np.diff(lines.loop) == 0]
    assert step.max() < 0.25


def test_set_back_ends_where_strands_would_hang():
    settings = SETTINGS.changed({"solid_set_back": 2.0})
    lines, tone, slant, solid = found(painted(black=(2, 6, 0, 8)), settings)
    _, set_back = with_solid_regions(lines, *modulated(lines, tone, slant, settings), slant, solid, settings)
    assert set_back.max() == pytest.approx(settings.max_unsupported + settings.extrusion_width / 2)


def test_runs_go_on_across_the_beginning_of_a_loop():
    kind = np.array([1, 1, 0, 2, 1, 2, 2, 0, 2, 1, 1, 1])
    run = runs(kind, np.array([0, 5, 9, 12]))
    assert run[0] == run[1] == run[4] and run[5] == run[6] == run[8] and len(set(run[9:])) == 1
    assert len(set(run.tolist())) == 6


def test_a_wave_is_longer_than_its_outline_by_the_arc_of_a_sine():
    chosen = PrintSettings(pattern="wave")
    x = np.linspace(0, 1, 5001)
    for depth in (0.0, 0.375, 0.75, 1.5):
        path = np.hypot(np.diff(x * chosen.wavelength * np.sqrt(2)), np.diff(depth / 2 * np.sin(2 * np.pi * x))).sum()
        expected = path / (chosen.wavelength * np.sqrt(2))
        assert _stretch(np.array([depth]), chosen) == pytest.approx(expected, rel=1e-3)
    assert _stretch(np.array([0.75]), PrintSettings(pattern="offset")) == 1


def test_a_print_reports_regions_and_their_cost():
    model = painted(black=(1, 4, 1, 7), white=(5, 7, 1, 7))
    plain = generate(model, SETTINGS.changed({"solid_regions": "none"}))
    solid = generate(model, SETTINGS)
    said = solid.report["solid_regions"]
    assert said["regions"] == 2 and said["black_mm2"] > said["white_mm2"] > 25 and said["outline_time_s"] < 0
    assert solid.report["tool_changes"] == plain.report["tool_changes"]
    assert "solid_regions" not in plain.report


CHANGING = SETTINGS.changed({"solid_regions": "tool_change", "pattern": "offset", "skirt_distance": 2.0})
BLACK_ANGLES, WHITE_ANGLES = (60, 165), (240, 300)  # of the patches below, without their borders


@pytest.fixture(scope="module")
def two_patches():
    """A gray cylinder, a black patch on one side, a smaller white one on the other."""
    return generate(painted(black=(1, 4, 1, 7), white=(5, 7, 1, 7)), CHANGING)


def wall_strands(moves, angles, heights=(4.0, 12.0)):
    """Rows of the outer wall between two directions and two heights, clear of the patches' borders."""
    x, y, z = moves.position.T
    turn = np.degrees(np.arctan2(y, x)) % 360
    rows = moves.extrudes & (moves.feature == Feature.OUTER_WALL) & (turn > angles[0]) & (turn < angles[1])
    rows[1:] &= (turn[:-1] > angles[0]) & (turn[:-1] < angles[1])
    return rows & (z > heights[0]) & (z < heights[1])


def test_solid_regions_have_one_color_on_every_layer(two_patches):
    moves = two_patches.moves
    for angles, tool in ((BLACK_ANGLES, 0), (WHITE_ANGLES, 1)):
        rows = wall_strands(moves, angles)
        assert len(np.unique(moves.layer[rows])) > 30 and (moves.tool[rows] == tool).all()
        radius = np.hypot(*moves.position[rows, :2].T)
        assert np.ptp(radius) < 0.03  # neither waves nor set back
    rows = wall_strands(moves, (190, 220))
    assert (moves.tool[rows] == moves.layer[rows] % 2).all()


def test_walls_are_cut_without_gap_or_overlap(two_patches):
    """Each layer's pieces add up to its outline, and begin where others end."""
    moves, outlines = two_patches.moves, two_patches.outlines
    step = np.hypot(*np.diff(moves.position[:, :2], axis=0, prepend=moves.position[:1, :2]).T)
    wall = moves.extrudes & (moves.feature == Feature.OUTER_WALL)
    printed = np.bincount(moves.layer[wall], step[wall])
    first, last = outlines.start[:-1], outlines.start[1:]
    ahead = np.arange(1, len(outlines.points) + 1)
    ahead[last - 1] = first
    length = np.hypot(*(outlines.points[ahead] - outlines.points).T)
    np.testing.assert_allclose(printed, np.add.reduceat(length, first), atol=1e-6)
    assert (np.diff(moves.tool)[wall[1:]] == 0).all()


def test_a_layer_changes_its_tool_once_and_then_primes_on_the_tower(two_patches):
    moves = two_patches.moves
    change = np.flatnonzero(np.diff(moves.tool)) + 1
    assert np.bincount(moves.layer[change]).max() == 1
    strand = np.flatnonzero(moves.extrudes)
    after = strand[np.searchsorted(strand, change)]
    assert (moves.feature[after] == Feature.TOWER).all()
    tower = moves.feature == Feature.TOWER
    for layer in range(two_patches.report["layers"]):
        assert len(np.unique(moves.tool[tower & (moves.layer == layer)])) == 1
    said = two_patches.report["solid_regions"]
    assert said["tool_changes"] == 0 and said["tool_changes_in_layers"] == (np.diff(moves.layer)[change - 1] == 0).sum()
    assert said["tool_changes_in_layers"] > 40 and 0 < said["tool_change_time_s"] < 60
    assert any(line.startswith("solid regions: 2, ") for line in summary(two_patches))
    rows = wall_strands(moves, (0, 360), (0, 99)) & (moves.tool != moves.layer % 2)
    step = np.hypot(*np.diff(moves.position[:, :2], axis=0, prepend=moves.position[:1, :2]).T)
    assert step[rows].sum() == pytest.approx(said["other_tool_mm"], rel=0.05)


def center(laid, tool):
    """(4,) mm, the middle of one tool's strands above the priming lines, and their length in meters."""
    inside = np.ones(len(laid.points) - 1, dtype=bool)
    inside[laid.start[1:-1] - 1] = False
    lines = inside & np.repeat(laid.tool == tool, np.diff(laid.start))[1:] & (laid.points[1:, 2] > 1.0)
    middle = (laid.points[1:] + laid.points[:-1])[lines] / 2
    length = np.linalg.norm(np.diff(laid.points, axis=0)[lines], axis=1)
    return np.append(length @ middle / length.sum(), length.sum() / 1000)


def check_files(result, folder):
    """No complaint of the audit nor of GPX, and both readers find each line's tool again."""
    export_x3g(result, folder / "p.x3g")
    data = (folder / "p.x3g").read_bytes()
    tower = result.moves.extrudes & (result.moves.feature == Feature.TOWER)
    box = result.moves.position[tower, :2]
    around = np.stack([box.min(axis=0) - 0.5, box.max(axis=0) + 0.5])
    assert audit(read_x3g(data), result.settings.printer_profile, around) == []
    export_gcode(result, folder / "p.gcode")
    read = read_gcode((folder / "p.gcode").read_bytes(), "p")
    assert read.settings.solid_regions == "tool_change"
    laid = strands(result.moves)
    for back in (strands(read.moves), strands(moves_of_x3g(data, "p").moves)):
        for tool in (0, 1):
            was, now = (center(table, tool) for table in (laid, back))
            assert np.abs(was - now).max() < 0.05
    assert convert(folder / "p.gcode") == []


def test_files_of_layers_with_two_tools(two_patches, tmp_path):
    check_files(two_patches, tmp_path)


def test_a_solid_two_colored_object_costs_one_tool_change(tmp_path):
    """All of it is one of the two colors, so every layer is printed by both tools, the first one too."""
    halves = painted(black=(0, 4, 0, 8), white=(4, 8, 0, 8))
    settings = CHANGING.changed({"standby_temperature_delta": 20.0, "ooze_shield": True, "raft_layers": 2})
    for chosen, more in ((CHANGING, 1), (settings, 1)):
        result = generate(halves, chosen)
        assert result.report["solid_regions"]["tool_changes"] == more
        for angles, tool in (((20, 160), 0), ((200, 340), 1)):
            rows = wall_strands(result.moves, angles, (0, 99))
            assert rows.any() and (result.moves.tool[rows] == tool).all()
        check_files(result, tmp_path)


def test_spots_patches_change_the_tool(data, tmp_path):
    """Its patches are a dark gray of tone 0.14 on a light one of 0.89."""
    model = obj_model(data / "meshes/spot/spot.obj", 30.0, [image_file(data / "meshes/spot/spot_texture.png")])
    result = generate(model, CHANGING.changed({"solid_region_tolerance": 0.15, "solid_region_area": 10}))
    said = result.report["solid_regions"]
    assert said["regions"] >= 4 and said["black_mm2"] > 30 and said["white_mm2"] > 3 * said["black_mm2"]
    assert said["tool_changes"] <= 1 and said["tool_changes_in_layers"] > 50
    check_files(result, tmp_path)


def test_short_pieces_stay_with_the_layers_own_tool():
    """A border of a third of a wavelength between two patches goes with them, a sliver of a patch stays."""
    settings = CHANGING.changed({"wavelength": 2.0})
    lines, *_, solid = found(painted(black=(2, 6, 0, 8)), settings)
    here = (lines.layer[lines.loop] == 21).nonzero()[0]
    region = np.full(len(lines.arc), -1)
    along = lines.arc[here] - lines.arc[here[0]]
    region[here[((along > 10) & (along < 20)) | ((along > 20.7) & (along < 30)) | ((along > 40) & (along < 41))]] = 0
    swapped = left_to_other_tool(lines, type(solid)(region, np.array([True]), np.array([99.0])), settings)
    expected = np.zeros(len(lines.arc), dtype=bool)
    expected[here[(along > 10) & (along < 30)]] = True
    assert np.array_equal(swapped, expected)


def test_the_tools_of_layers_take_turns_with_the_fewest_changes():
    own = tool_of_layer(np.arange(6), PrintSettings())
    kinds = {0: (True, False), 1: (False, True), 2: (True, True)}
    for chosen in product((0, 1, 2), repeat=6):
        used = np.array([kinds[kind] for kind in chosen])
        first, last = _ends(used, own)
        assert all(used[layer, [first[layer], last[layer]]].all() for layer in range(6))
        changes = (first != last).sum() + (first[1:] != last[:-1]).sum()
        starts = [[(0, 0)], [(1, 1)], [(0, 1), (1, 0)]]
        least = min(
            sum(a != b for a, b in order) + sum(x[1] != y[0] for x, y in pairwise(order))
            for order in product(*(starts[kind] for kind in chosen))
        )
        assert changes == least


def test_the_preview_shows_the_right_filament(scene, two_patches):
    from dualcolor.bridge.strands.preview import build_preview
    from dualcolor.bridge.strands.strand_curves import read_strands
    from dualcolor.bridge.units import mm_per_unit

    unit, seen = mm_per_unit(scene), {}
    for shown in build_preview(two_patches).objects:
        points, counts, _, labels = read_strands(shown)
        points = points * unit
        turn = np.degrees(np.arctan2(points[:, 1], points[:, 0])) % 360
        inside = np.repeat(labels["feature"] == Feature.OUTER_WALL, counts) & (np.abs(points[:, 2] - 8) < 4)
        for name, (low, high) in (("black", BLACK_ANGLES), ("white", WHITE_ANGLES)):
            tools = np.repeat(labels["tool"], counts)[inside & (turn > low) & (turn < high)]
            seen.setdefault(name, set()).update((shown.name.split(".")[0].split()[-1], int(tool)) for tool in tools)
    assert seen == {"black": {("Black", 0)}, "white": {("White", 1)}}
