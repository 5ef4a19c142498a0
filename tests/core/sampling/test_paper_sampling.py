"""The paper's own sampling against the paper: projection, spacing, seam error."""

import numpy as np
import pytest
from dualcolor.core.contours.places import long_enough
from dualcolor.core.sampling.projector import Projector
from dualcolor.core.sampling.quality import seam_errors
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.pattern_stages import WAVE_OFFSET, lines_of, sampled
from dualcolor.tests.robustness.strategies import examples
from dualcolor.tests.solids import box, cylinder, joined, lathe
from hypothesis import given
from hypothesis import strategies as st


def spacing_is_bounded(lines, samples, settings=WAVE_OFFSET):
    gap = samples.spacing(lines)
    assert (gap >= settings.wavelength - 1e-6).all()
    assert (gap < 2 * settings.wavelength).all()
    usable = long_enough(lines.length, settings.wavelength)
    assert ((np.diff(samples.start) > 0) == usable).all()
    return True


# Projection


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
@examples(20)
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


# Seam error


def test_a_cylinder_has_no_seam():
    lines = lines_of(cylinder(radius=10, height=5))
    samples, projector = sampled(lines)
    errors = seam_errors(samples, projector)
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
    error = seam_errors(turned, projector).error
    assert error.mean() == pytest.approx(1.0, abs=0.02)
    assert error.max() == pytest.approx(2.0, abs=0.02)


def test_probes_with_nothing_above_are_counted_as_discarded():
    lines = lines_of(lathe([[10, 0], [10, 2], [6, 2], [6, 4]]))
    samples, projector = sampled(lines)
    errors = seam_errors(samples, projector)
    per_layer = np.bincount(lines.layer[np.searchsorted(lines.arc_start, errors.arc, side="right") - 1])
    assert errors.discarded.sum() == per_layer[7]


@pytest.mark.parametrize(("name", "height", "salient"), [("nc/gargoyle.obj", 102, 0.02), ("nc/kitten.obj", 54, 0.02)])
def test_real_models_keep_the_bounds_of_the_paper(data, name, height, salient):
    """Section 6.4: two percent of the surface with salient seams."""
    from dualcolor.tests.real_models import obj_model

    lines = lines_of(obj_model(data / "meshes" / name, height))
    samples, projector = sampled(lines)
    assert spacing_is_bounded(lines, samples)
    shares = seam_errors(samples, projector).shares(len(samples.arc))
    assert 0 < shares["salient"] <= salient
    assert shares["error_free"] > 0.79
    assert shares["discarded"] < 0.05
