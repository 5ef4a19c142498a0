"""The pattern against the paper: sampling, phases, tone to shape, tessellation, filtering, fading, seam error."""

import numpy as np
import pytest
import shapely
from dualcolor.core.mesh import triangulate
from dualcolor.core.pattern.along_loops import filtered, gaussian
from dualcolor.core.pattern.contours import contours, long_enough
from dualcolor.core.pattern.grid import PointGrid, nearest
from dualcolor.core.pattern.modulation import faded, layer_sign, shape, supported, wave_reach
from dualcolor.core.pattern.quality import phase_at, seam_errors
from dualcolor.core.pattern.sampling import Projector, sample
from dualcolor.core.pattern.wave import average_along_wall, modulated, waved
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.slices import slices
from dualcolor.tests.solids import box, cylinder, joined, lathe
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

WAVE_OFFSET = PrintSettings(pattern="wave_offset", offset_max=0.3, max_unsupported=0.7)
WAVE = PrintSettings(pattern="wave")


def lines_of(model, settings=WAVE_OFFSET):
    cut = slices(triangulate(model, settings), settings)
    return contours(cut.outlines, cut.loop_polygon, settings)


def sampled(lines, settings=WAVE_OFFSET):
    projector = Projector(lines, settings.projection_threshold)
    return sample(lines, projector, settings), projector


def printed(model, tone, settings=WAVE_OFFSET):
    lines = lines_of(model, settings)
    samples, _ = sampled(lines, settings)
    tones = np.full(len(lines.points), tone)
    depth, set_back = modulated(lines, tones, np.zeros(len(tones)), settings)
    return lines, samples, waved(lines, samples, tones, depth, set_back, settings)


def spacing_is_bounded(lines, samples, settings=WAVE_OFFSET):
    gap = samples.spacing(lines)
    assert (gap >= settings.wavelength - 1e-6).all()
    assert (gap < 2 * settings.wavelength).all()
    usable = long_enough(lines.length, settings)
    assert ((np.diff(samples.start) > 0) == usable).all()
    return True


# Contours


def test_contour_lies_half_a_line_inside_the_surface():
    lines = lines_of(cylinder(radius=10, sides=720))
    radius = np.hypot(*lines.points.T)
    # A circle of radius r filtered with a Gaussian of 0.3 mm shrinks by sigma²/(2r) = 4.5 µm.
    assert radius == pytest.approx(9.8 - 0.0045, abs=0.003)
    assert np.hypot(*(lines.normal - lines.points / radius[:, None]).T).max() < 0.01


def test_contour_points_carry_their_own_place_on_the_surface():
    from dualcolor.tests.solids import picture

    lines = lines_of(cylinder(radius=10, sides=360, textures=[picture(np.zeros((2, 2)))]))
    turn = np.exp(2j * np.pi * lines.carried[:, 0])
    at = (lines.points @ [1, 1j]) / np.hypot(*lines.points.T)
    assert np.abs(turn - at).max() < 0.002


def test_detail_finer_than_the_wave_is_filtered_and_the_shape_stays():
    turn = np.linspace(0, 2 * np.pi, 2000, endpoint=False)
    start = np.array([0, 2000])
    ripple = np.stack([np.cos(turn), np.sin(turn)]) * (10 + 0.2 * np.cos(105 * turn))
    kernel = gaussian(0.3 / (2 * np.pi * 10 / 2000))
    radius = np.hypot(*filtered(ripple, start, kernel))
    assert np.ptp(radius) / 0.4 < 0.02  # ripples of 0.6 mm, half the wavelength
    assert radius.mean() == pytest.approx(10, abs=0.01)


def test_filter_wraps_around_each_loop_and_keeps_the_mean():
    values = np.arange(10.0)
    start = np.array([0, 4, 10])
    smooth = filtered(values, start, np.array([0.25, 0.5, 0.25]))
    assert smooth[0] == pytest.approx(0.25 * 3 + 0.5 * 0 + 0.25 * 1)
    assert smooth[9] == pytest.approx(0.25 * 8 + 0.5 * 9 + 0.25 * 4)
    assert smooth[:4].mean() == pytest.approx(values[:4].mean())


def test_places_are_found_again_on_every_loop():
    lines = lines_of(joined(cylinder(radius=5, height=2), cylinder(radius=3, height=2, x=20)))
    rng = np.random.default_rng(1)
    arc = rng.uniform(0, lines.arc_start[-1], 500)
    before, after, share = lines.locate(arc)
    assert (lines.loop[before] == lines.loop[after]).all()
    assert (lines.loop[before] == np.searchsorted(lines.arc_start, arc, side="right") - 1).all()
    assert ((share >= 0) & (share <= 1)).all()


# Neighbour search


@given(st.integers(0, 2**32 - 1))
@hypothesis_settings(max_examples=30, deadline=None)
def test_grid_finds_the_nearest_point_of_the_layer(seed):
    rng = np.random.default_rng(seed)
    points, layer = rng.uniform(0, 5, (200, 2)), rng.integers(0, 3, 200)
    query, wanted = rng.uniform(-1, 6, (50, 2)), rng.integers(0, 3, 50)
    found, group = PointGrid(points, layer, 0.7).candidates(query, wanted)
    away = np.hypot(*(points[found] - np.repeat(query, np.diff(group), axis=0)).T)
    where, filled = nearest(away, group)
    for q in range(50):
        distance = np.where(layer == wanted[q], np.hypot(*(points - query[q]).T), np.inf)
        if distance.min() < 0.7:
            assert filled[q]
            assert away[where[q]] == pytest.approx(distance.min())
        assert (layer[found[group[q] : group[q + 1]]] == wanted[q]).all()


def test_projection_is_perpendicular_and_respects_the_threshold():
    lines = lines_of(cylinder(radius=10, height=1, sides=360))
    projector = Projector(lines, 0.6)
    angle = np.linspace(0, 6.28, 50)
    for offset, reached in ((0.0, True), (0.55, True), (-0.55, True), (0.7, False)):
        query = (lines.points[0, 0] / 1.0 + offset) * np.column_stack([np.cos(angle), np.sin(angle)])
        arc, distance = projector.project(query, np.full(50, 2))
        assert np.isfinite(distance).all() == reached
        if reached:
            before, after, share = lines.locate(arc)
            spot = lines.points[before] + share[:, None] * (lines.points[after] - lines.points[before])
            assert np.hypot(*(spot - query).T) == pytest.approx(distance, abs=1e-6)
            assert distance == pytest.approx(abs(offset), abs=0.01)
            assert (lines.layer[lines.loop[before]] == 2).all()


# Sampling


def test_cylinder_keeps_its_samples_and_their_places():
    """Paper, section 3.2: on an extruded shape the pattern is perfectly regular."""
    lines = lines_of(cylinder(radius=10, height=10))
    samples, _ = sampled(lines)
    count = np.diff(samples.start)
    assert (count == int(lines.length[0] / 1.2)).all()
    assert samples.spacing(lines) == pytest.approx(lines.length[0] / count[0], abs=1e-4)
    # Loops start anywhere; in the plane each sample stands above the one of the layer below.
    before, after, share = lines.locate(samples.arc)
    spot = lines.points[before] + share[:, None] * (lines.points[after] - lines.points[before])
    turn = np.exp(1j * count[0] * np.arctan2(spot[:, 1], spot[:, 0]))
    assert np.abs(turn - turn[0]).max() < 1e-2


@pytest.mark.parametrize(
    "profile",
    [[[10, 0], [2, 12]], [[2, 0], [10, 12]], [[8, 0], [3, 5], [9, 12]], [[1, 0], [1, 5]]],
    ids=["cone", "funnel", "waist", "pin"],
)
def test_spacing_stays_between_one_and_two_wavelengths(profile):
    lines = lines_of(lathe(profile))
    samples, _ = sampled(lines)
    assert spacing_is_bounded(lines, samples)


def test_loops_that_appear_split_and_merge():
    """A bridge between two towers, then three separate ones: every loop of every layer is sampled."""
    model = joined(
        box((-20, -5, 0), (-10, 5, 12)),
        box((10, -5, 0), (20, 5, 12)),
        box((-20, -5, 4), (20, 5, 6)),
        box((-3, -3, 5), (3, 3, 12)),
        box((-18, -3, 1), (-12, 3, 3), inward=True),
    )
    lines = lines_of(model)
    samples, _ = sampled(lines)
    assert set(np.bincount(lines.layer)) >= {1, 2, 3}
    assert spacing_is_bounded(lines, samples)


@given(st.integers(0, 2**32 - 1), st.floats(0.6, 3.0))
@hypothesis_settings(max_examples=20, deadline=None)
def test_spacing_bound_on_random_solids(seed, wavelength):
    rng = np.random.default_rng(seed)
    radius = 6 + np.cumsum(rng.normal(0, 0.8, 12))
    model = lathe(np.column_stack([np.clip(radius, 0.6, 30), np.arange(12) * 0.7]), sides=40)
    chosen = PrintSettings(wavelength=wavelength)
    lines = lines_of(model, chosen)
    samples, _ = sampled(lines, chosen)
    assert spacing_is_bounded(lines, samples, chosen)


def test_relaxation_evens_the_spacing_out():
    model = lathe([[10, 0], [7, 3], [7, 20]])
    rough, calm = PrintSettings(relaxation=0.0), PrintSettings(relaxation=0.3)
    spread = []
    for chosen in (rough, calm):
        lines = lines_of(model, chosen)
        samples, _ = sampled(lines, chosen)
        spread.append(samples.spacing(lines)[-20:].std())
    assert spread[1] < spread[0] / 3


# Tone to shape


def test_sign_flips_after_every_pair_of_layers():
    assert layer_sign(np.arange(8)).tolist() == [1, -1, -1, 1, 1, -1, -1, 1]


@pytest.mark.parametrize("pattern", ["wave", "wave_offset", "offset"])
@pytest.mark.parametrize("tone", [0.0, 1.0])
def test_the_attenuated_colour_stands_behind_the_other(pattern, tone):
    chosen = PrintSettings(pattern=pattern, offset_max=0.3, max_unsupported=0.7)
    _, _, outline = printed(cylinder(radius=12, height=4), tone, chosen)
    loop = np.repeat(np.arange(len(outline.layer)), np.diff(outline.start))
    is_black = outline.layer[loop] % 2 == 0
    outermost = np.hypot(*outline.points.T)
    black, white = outermost[is_black].max(), outermost[~is_black].max()
    depth, back = (0.375 / 2 if pattern != "offset" else 0.0), (0.3 if pattern != "wave" else 0.0)
    assert (white - black if tone == 1.0 else black - white) == pytest.approx(depth + back, abs=0.01)


def test_at_half_both_colours_have_their_full_depth():
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
    assert swing == pytest.approx(sign * outline.phase * 0.375, abs=2e-3)
    assert np.abs(outline.phase).max() == pytest.approx(1.0)


def test_every_sample_is_a_point_of_the_waved_outline():
    _, samples, outline = printed(cylinder(radius=12, height=2), 0.5, WAVE)
    assert (outline.phase > 1 - 1e-9).sum() == len(samples.arc)


def test_polyline_stays_within_the_chord_tolerance_and_wastes_no_points():
    tolerance = 0.02
    chosen = PrintSettings(pattern="wave", chord_tolerance=tolerance)
    lines, samples, outline = printed(cylinder(radius=12, height=0.5, sides=720), 0.5, chosen)
    ring = shapely.linearrings(outline.points[outline.start[0] : outline.start[1]])
    local = np.linspace(0, lines.length[0], 20_000, endpoint=False)
    before, after, share = lines.locate(local)
    base = lines.points[before] + share[:, None] * (lines.points[after] - lines.points[before])
    true = base * (1 + (phase_at(lines, samples, local) * 0.375 / np.hypot(*base.T)))[:, None]
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


# Seam error


def test_a_cylinder_has_no_seam():
    lines = lines_of(cylinder(radius=10, height=5))
    samples, projector = sampled(lines)
    errors = seam_errors(lines, samples, projector)
    assert np.nanmax(errors.error) < 1e-6
    assert not errors.discarded.any()
    assert errors.shares(1)["error_free"] == 1.0


def test_a_turned_layer_shows_the_error_of_its_turn():
    """Moving the samples of one layer by a quarter wave gives the mean of (cos a − cos(a + 90°))², which is 1."""
    lines = lines_of(cylinder(radius=10, height=0.5))
    samples, projector = sampled(lines)
    arc = samples.arc.copy()
    upper = samples.loop == 1
    arc[upper] += samples.spacing(lines)[upper] / 4
    turned = type(samples)(arc, samples.loop, samples.start)
    error = seam_errors(lines, turned, projector).error
    assert error.mean() == pytest.approx(1.0, abs=0.02)
    assert error.max() == pytest.approx(2.0, abs=0.02)


def test_probes_with_nothing_above_are_counted_as_discarded():
    lines = lines_of(lathe([[10, 0], [10, 2], [6, 2], [6, 4]]))
    samples, projector = sampled(lines)
    errors = seam_errors(lines, samples, projector)
    per_layer = np.bincount(lines.layer[np.searchsorted(lines.arc_start, errors.arc, side="right") - 1])
    assert errors.discarded.sum() == per_layer[7]


@pytest.mark.parametrize(("name", "height", "salient"), [("nc/gargoyle.obj", 102, 0.02), ("nc/kitten.obj", 54, 0.02)])
def test_real_models_keep_the_bounds_of_the_paper(data, name, height, salient):
    """Section 6.4: two percent of the surface with salient seams."""
    from dualcolor.tests.real_models import obj_model

    lines = lines_of(obj_model(data / "meshes" / name, height))
    samples, projector = sampled(lines)
    assert spacing_is_bounded(lines, samples)
    shares = seam_errors(lines, samples, projector).shares(len(samples.arc))
    assert 0 < shares["salient"] <= salient
    assert shares["error_free"] > 0.79
    assert shares["discarded"] < 0.05
