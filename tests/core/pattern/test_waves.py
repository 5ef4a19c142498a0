"""From tones to waves, against the paper: signs, shape, what is supported, fading, tessellation."""

import numpy as np
import pytest
import shapely
from dualcolor.core.contours.places import average_along_wall
from dualcolor.core.pattern.modulation import faded, layer_sign, shape, supported, wave_reach
from dualcolor.core.sampling.quality import displacement_at
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.pattern_stages import WAVE, WAVE_OFFSET, lines_of, printed
from dualcolor.tests.solids import box, cylinder, joined
from hypothesis import given
from hypothesis import strategies as st

# Tone to shape


def test_sign_flips_after_every_pair_of_layers():
    assert layer_sign(np.arange(8)).tolist() == [1, -1, -1, 1, 1, -1, -1, 1]


@pytest.mark.parametrize("pattern", ["wave", "wave_offset", "offset"])
@pytest.mark.parametrize("tone", [0.0, 1.0])
def test_the_attenuated_color_stands_behind_the_other(pattern, tone):
    chosen = PrintSettings(pattern=pattern, offset_max=0.3, max_unsupported=0.7)
    _, _, outline = printed(cylinder(radius=12, height=4), tone, chosen)
    loop = np.repeat(np.arange(len(outline.layer)), np.diff(outline.start))
    is_black = outline.layer[loop] % 2 == 0
    outermost = np.hypot(*outline.points.T)
    black, white = outermost[is_black].max(), outermost[~is_black].max()
    depth, back = (0.375 / 2 if pattern != "offset" else 0.0), (0.3 if pattern != "wave" else 0.0)
    assert (white - black if tone == 1.0 else black - white) == pytest.approx(depth + back, abs=0.01)


def test_at_half_both_colors_have_their_full_depth():
    _, _, outline = printed(cylinder(radius=12, height=4), 0.5, WAVE_OFFSET)
    assert outline.depth == pytest.approx(0.75, abs=1e-9)
    assert outline.set_back == pytest.approx(0.0)


def test_tone_to_shape_by_pattern():
    tone = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
    black, white = np.ones(5, dtype=bool), np.zeros(5, dtype=bool)
    depth, back = shape(tone, black, WAVE)
    assert depth == pytest.approx([0.75, 0.75, 0.75, 0.5625, 0.375])
    assert back == pytest.approx(0)
    depth, back = shape(tone, white, WAVE_OFFSET)
    assert depth == pytest.approx([0.375, 0.5625, 0.75, 0.75, 0.75])
    assert back == pytest.approx([0.3, 0.15, 0, 0, 0])
    depth, back = shape(tone, black, PrintSettings(pattern="offset", offset_max=0.3))
    assert depth == pytest.approx(0)
    assert back == pytest.approx([0, 0, 0, 0.15, 0.3])


def test_set_back_begins_at_its_onset():
    tone = np.array([0.5, 0.7, 0.8, 1.0])
    chosen = PrintSettings(pattern="offset", offset_max=0.3, offset_onset=0.4)
    _, back = shape(tone, np.ones(4, dtype=bool), chosen)
    assert back == pytest.approx([0, 0, 0.1, 0.3])


def test_a_wave_reaches_as_far_as_its_depth_or_half_way_to_the_next():
    depth = np.array([0.0, 0.1, 0.75, 50.0])
    none, shallow, papers, deep = wave_reach(depth, 1.2)
    assert none == 0
    assert shallow == pytest.approx(0.1, rel=0.02)
    # The paper's: its middle lies 0.28 mm outside the strand below, which is 0.4 mm wide.
    assert papers - 0.2 == pytest.approx(0.28, abs=0.005)
    assert deep < 50.0 / 2 + 0.6
    assert (np.diff(wave_reach(np.linspace(0, 3, 50), 1.2)) > 0).all()


@pytest.mark.parametrize("pattern", ["wave", "wave_offset", "offset"])
@pytest.mark.parametrize("slant", [-45.0, 0.0, 45.0])
def test_no_strand_stands_out_farther_than_it_may(pattern, slant):
    depth, back = np.array([0.2, 0.75, 1.5]), np.array([0.0, 0.3, 0.6])
    chosen = PrintSettings(pattern=pattern, max_unsupported=0.2)
    if pattern == "offset":
        depth = np.zeros(3)
    new_depth, new_back = supported(depth, back, np.full(3, slant), chosen)
    step = -0.25 * np.tan(np.radians(slant))
    needed = wave_reach(np.append(0, np.sort(new_depth)), 1.2)[1:] + new_back + step
    assert (needed <= 0.2 + 0.2 + 1e-3).all()
    assert (new_depth <= depth).all() and (new_back <= back).all()
    assert (needed[-1] == pytest.approx(0.4, abs=1e-2)) or (new_back[-1] == back[-1])


def test_upright_walls_carry_the_default_and_the_papers_pattern_unchanged():
    for chosen in (PrintSettings(), PrintSettings(pattern="wave")):
        shaped = shape(np.linspace(0, 1, 11), np.arange(11) % 2 == 0, chosen)
        assert supported(*shaped, np.zeros(11), chosen) == pytest.approx(np.array(shaped))


@given(st.lists(st.tuples(*[st.floats(0, 3)] * 4), min_size=1, max_size=20))
def test_fading_keeps_within_the_room(rows):
    depth, back, inside, outside = np.array(rows).T
    new_depth, new_back = faded(depth, back, inside, outside)
    assert (new_depth >= 0).all()
    assert (new_back >= 0).all()
    assert (new_depth <= depth + 1e-12).all()
    assert (new_back <= back + 1e-12).all()
    assert (new_depth / 2 + new_back <= inside + 1e-12).all()
    assert (new_depth / 2 <= outside + 1e-12).all()


# Waves


def test_wave_is_a_sine_about_the_contour():
    _, _, outline = printed(cylinder(radius=12, height=2, sides=720), 0.5, WAVE)
    loop = np.repeat(np.arange(len(outline.layer)), np.diff(outline.start))
    swing = np.hypot(*outline.points.T) - np.hypot(*outline.base.T)
    sign = layer_sign(outline.layer)[loop]
    assert swing == pytest.approx(sign * outline.wave * 0.375, abs=2e-3)
    assert np.abs(outline.wave).max() == pytest.approx(1.0)


def test_every_sample_is_a_point_of_the_waved_outline():
    _, samples, outline = printed(cylinder(radius=12, height=2), 0.5, WAVE)
    assert (outline.wave > 1 - 1e-9).sum() == len(samples.arc)


def test_polyline_stays_within_the_chord_tolerance_and_wastes_no_points():
    tolerance = 0.02
    chosen = PrintSettings(pattern="wave", chord_tolerance=tolerance)
    lines, samples, outline = printed(cylinder(radius=12, height=0.5, sides=720), 0.5, chosen)
    ring = shapely.linearrings(outline.points[outline.start[0] : outline.start[1]])
    local = np.linspace(0, lines.length[0], 20_000, endpoint=False)
    before, after, share = lines.locate(local)
    base = lines.points[before] + share[:, None] * (lines.points[after] - lines.points[before])
    true = base * (1 + (displacement_at(lines, samples, local) * 0.375 / np.hypot(*base.T)))[:, None]
    off = shapely.distance(ring, shapely.points(true)).max()
    assert 0.3 * tolerance < off <= tolerance
    waves = samples.start[1]
    assert 6 * waves < outline.start[1] < 14 * waves


def test_flat_layers_and_short_loops_carry_no_wave():
    chosen = PrintSettings(pattern="wave", flat_layers=3)
    _, _, outline = printed(joined(cylinder(radius=8, height=2), cylinder(radius=0.35, height=2, x=12)), 0.5, chosen)
    loop = np.repeat(np.arange(len(outline.layer)), np.diff(outline.start))
    assert (outline.depth[outline.layer[loop] < 3] == 0).all()
    small = outline.base[:, 0] > 8
    assert (outline.depth[small] < 0.3).all()
    assert outline.depth[(outline.layer[loop] >= 3) & ~small].max() == pytest.approx(0.75)


def test_waves_of_a_thin_wall_neither_cross_nor_touch():
    """Behind the two lines of a wall 1.2 mm thick 0.4 mm are left for both waves; 1.6 mm have room for full ones."""
    reached = []
    for thickness in (0.6, 1.0, 1.2, 1.6):
        _, _, outline = printed(box((-15, -thickness / 2, 0), (15, thickness / 2, 2)), 0.5, WAVE)
        for layer in range(len(outline.start) - 1):
            points = outline.points[outline.start[layer] : outline.start[layer + 1]]
            assert shapely.is_valid(shapely.Polygon(points)), (thickness, layer)
        reached.append(outline.depth[np.abs(outline.base[:, 0]) < 10].max())
    assert reached == pytest.approx([0.0, 0.2, 0.4, 0.75], abs=0.02)


def test_line_width_follows_a_thin_wall():
    lines = lines_of(box((-15, -0.3, 0), (15, 0.3, 1)))
    middle = np.abs(lines.points[:, 0]) < 10
    assert lines.width[middle] == pytest.approx(0.3, abs=0.01)
    assert np.abs(lines.points[middle, 1]) == pytest.approx(0.15, abs=0.01)


def test_tone_along_the_wall_is_averaged_over_a_wave():
    lines = lines_of(cylinder(radius=10, height=0.5))
    step = (np.arange(len(lines.points)) % 314 < 157).astype(float)
    smooth = average_along_wall(step, lines, 1.2)
    assert smooth.mean() == pytest.approx(step.mean())
    assert 4 <= np.flatnonzero((smooth > 0.01) & (smooth < 0.99)).size / 4 <= 8
