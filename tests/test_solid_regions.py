"""Regions of pure black or white: found as a whole, the other colour hidden behind, all else untouched."""

import numpy as np
import pytest
from dualcolor.core.mesh import triangulate
from dualcolor.core.pattern.contours import contours
from dualcolor.core.pattern.modulation import layer_is_black
from dualcolor.core.pattern.sampling import Projector
from dualcolor.core.pattern.slant import slant_along
from dualcolor.core.pattern.solid_regions import connected, runs, solid_regions, with_solid_regions
from dualcolor.core.pattern.wave import modulated
from dualcolor.core.pipeline import generate, pattern_tone
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.slices import slices
from dualcolor.core.texture.pyramid import build_pyramids
from dualcolor.tests.solids import cylinder, picture

SETTINGS = PrintSettings(pattern="wave_offset", solid_regions="set_back", calibration="none")
SIDE = 128


def painted(**patches):
    """A grey picture, with (low u, high u, low v, high v) of black and white patches in eighths."""
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


def test_a_region_is_found_with_its_area_and_colour():
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


def test_small_regions_and_grey_are_left_alone():
    lines, tone, slant, solid = found(painted(black=(2, 4, 2, 6)), SETTINGS.changed({"solid_region_area": 200.0}))
    assert not len(solid.area) and (solid.region == -1).all()
    depth, set_back = modulated(lines, tone, slant, SETTINGS)
    after = with_solid_regions(lines, depth, set_back, slant, solid, SETTINGS)
    assert np.array_equal(after[0], depth) and np.array_equal(after[1], set_back)


@pytest.mark.parametrize("pattern", ["wave", "wave_offset", "offset"])
@pytest.mark.parametrize("black", [True, False])
def test_the_other_colour_is_behind_and_nothing_waves(pattern, black):
    settings = SETTINGS.changed({"pattern": pattern})
    lines, tone, slant, solid = found(painted(**{"black" if black else "white": (2, 6, 0, 8)}), settings)
    before = modulated(lines, tone, slant, settings)
    depth, set_back = with_solid_regions(lines, *before, slant, solid, settings)
    outside = solid.region < 0
    assert np.array_equal(depth[outside], before[0][outside])
    assert np.array_equal(set_back[outside], before[1][outside])
    turn = np.degrees(np.arctan2(lines.points[:, 1], lines.points[:, 0])) % 360
    middle = (turn > 120) & (turn < 240)
    own = layer_is_black(lines.layer[lines.loop]) == black
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


def test_things_are_connected_along_chains():
    label = connected(7, np.array([5, 1, 3, 2]), np.array([3, 2, 1, 6]))
    assert label.tolist() == [0, 1, 1, 1, 4, 1, 1]
    chain = np.arange(999)
    assert (connected(1000, chain, chain + 1) == 0).all()
    assert connected(3, np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)).tolist() == [0, 1, 2]


def test_a_print_reports_regions_and_their_cost():
    model = painted(black=(1, 4, 1, 7), white=(5, 7, 1, 7))
    plain = generate(model, SETTINGS.changed({"solid_regions": "none"}))
    solid = generate(model, SETTINGS)
    said = solid.report["solid_regions"]
    assert said["regions"] == 2 and said["black_mm2"] > said["white_mm2"] > 25 and said["outline_time_s"] < 0
    assert solid.report["tool_changes"] == plain.report["tool_changes"]
    assert "solid_regions" not in plain.report
