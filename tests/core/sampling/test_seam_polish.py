"""The last polish of the optimized sampling: what counts as seen, what it compares, that it leaves fewer seams."""

from dataclasses import replace

import numpy as np
import pytest
from dualcolor.core.contours.contours import contours
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.sampling.optimized import LONGER_POLISH, POLISH, QUICK_POLISH, optimized_samples
from dualcolor.core.sampling.paper import paper_samples
from dualcolor.core.sampling.projected_grid import phase_grid
from dualcolor.core.sampling.projector import Projector
from dualcolor.core.sampling.quality import seam_errors
from dualcolor.core.sampling.samples import Samples
from dualcolor.core.sampling.seam_pairs import MovingSamples, pairs_between
from dualcolor.core.sampling.seam_polish import Stage, polished, sharpness
from dualcolor.core.sampling.spacing import bounded
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.slices import slices
from dualcolor.tests.solids import lathe

SETTINGS = PrintSettings(pattern="wave", wavelength=1.2)


@pytest.fixture(scope="module")
def vase():
    """A round wall that gets narrower by less than half, so that all waves can go on."""
    cut = slices(triangulate(lathe([[10, 0], [6, 15]]), SETTINGS), SETTINGS)
    return contours(cut.outlines, cut.loop_polygon, SETTINGS)


@pytest.mark.parametrize("doublings", [1, 2, 3])
def test_what_counts_as_seen_grows_as_it_should(doublings):
    error = np.linspace(0.01, 4.0, 400)
    stage, power, step = Stage(1, doublings, 0.6, 0.1, 0.1), 2.0**doublings, 1e-6

    def counted(value):
        return value**power / (value**power + 0.6**power)

    slope = (counted(error + step) - counted(error - step)) / (2 * step)
    np.testing.assert_allclose(sharpness(error, stage), slope, rtol=1e-5, atol=1e-7)


@pytest.mark.parametrize("apart", [0.5, 1.0, 4.0])
def test_places_and_their_images_lie_in_the_waves_that_they_are_said_to_lie_in(vase, apart):
    projector = Projector(vase, SETTINGS.projection_threshold)
    samples = optimized_samples(projector, SETTINGS)
    grid, waves = phase_grid(projector, SETTINGS.wavelength), MovingSamples(vase, samples)
    every, weight = np.ones(len(samples.arc), dtype=bool), np.full(len(vase.arc), 0.5)
    pairs = pairs_between(projector, grid, waves, np.arange(len(grid.arc)), every, weight, apart)
    assert (pairs.along >= -1e-5).all()
    assert (pairs.along <= waves.gap()[pairs.before] + 1e-5).all()
    loop = samples.loop[pairs.before]
    arc = vase.arc_start[loop] + np.mod(waves.place[pairs.before] + pairs.along, vase.length[loop])
    below, above = arc
    assert (np.diff(vase.layer[loop], axis=0) == 1).all()
    image, _ = projector.project(projector.at(below), vase.layer[loop[0]] + 1)
    np.testing.assert_allclose(projector.at(above), projector.at(image), atol=0.01)
    assert len(below) == pytest.approx(len(vase.arc) * (1 - 1 / len(vase.layer)) / apart, rel=0.02)
    assert pairs.importance.sum() == pytest.approx(0.5 * vase.length[:-1].sum(), rel=1e-3)


@pytest.mark.parametrize(("effort", "left"), [(QUICK_POLISH, 0.8), (POLISH, 0.7), (LONGER_POLISH, 0.25)])
def test_polish_mends_samples_that_were_disturbed_and_tells_how_much_is_left(vase, effort, left):
    projector, weight = Projector(vase, SETTINGS.projection_threshold), np.ones(len(vase.arc))
    even = optimized_samples(projector, SETTINGS)
    away = np.random.default_rng(1).normal(0.0, 0.15, len(even.arc))
    arc = np.clip(even.arc + away, vase.arc_start[even.loop], vase.arc_start[even.loop + 1] - 1e-6)
    before = Samples.on(vase, bounded(vase, arc, even.loop, SETTINGS.wavelength))
    after, seen = polished(
        projector, phase_grid(projector, SETTINGS.wavelength), before, weight, effort, SETTINGS.wavelength
    )
    least = SETTINGS.wavelength
    assert after.spacing(vase).min() >= least - 1e-6
    assert after.spacing(vase).max() < 2 * least
    salient = [seam_errors(samples, projector).shares(len(samples.arc))["salient"] for samples in (before, after)]
    assert salient[0] > 0.02
    assert salient[1] < left * salient[0]
    assert seen == pytest.approx(salient[1], rel=0.1)


def test_more_is_done_where_few_samples_are_near_seams(vase):
    projector, weight = Projector(vase, SETTINGS.projection_threshold), np.ones(len(vase.arc))
    samples, grid = paper_samples(projector, SETTINGS), phase_grid(projector, SETTINGS.wavelength)
    more = replace(QUICK_POLISH, apart=2.0, few=0, more=None)
    little = replace(QUICK_POLISH, few=0, more=more)

    def seen(effort):
        return polished(projector, grid, samples, weight, effort, SETTINGS.wavelength)[1]

    assert seen(replace(little, few=10**6)) == seen(more)
    assert seen(little) == seen(replace(little, more=None)) != seen(more)


def test_places_are_found_again_among_samples_that_have_moved(vase):
    projector = Projector(vase, SETTINGS.projection_threshold)
    samples = optimized_samples(projector, SETTINGS)
    grid, waves = phase_grid(projector, SETTINGS.wavelength), MovingSamples(vase, samples)
    every, weight = np.ones(len(samples.arc), dtype=bool), np.ones(len(vase.arc))
    pairs = pairs_between(projector, grid, waves, np.arange(len(grid.arc)), every, weight, 1.0)
    loop = samples.loop[pairs.before]
    place = np.mod(waves.place[pairs.before] + pairs.along, vase.length[loop])
    waves.place = waves.place + 0.7
    waves.relocate(pairs)
    share, steep = waves.shares(pairs)
    assert (share >= 0).all() and (share < 1).all()
    np.testing.assert_allclose(1 / steep, waves.gap()[pairs.before], rtol=1e-5)
    found = np.mod(waves.place[pairs.before] + share / steep, vase.length[loop])
    away = np.abs(found - place)
    assert np.minimum(away, vase.length[loop] - away).max() < 1e-4
