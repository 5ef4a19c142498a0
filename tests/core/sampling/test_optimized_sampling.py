"""The optimized sampling: bounds on any solid, plans where the best is known, and fewer seams than the paper's."""

from dataclasses import replace
from functools import cache
from unittest.mock import patch

import numpy as np
import pytest
import shapely
from dualcolor.core.contours.contours import contours
from dualcolor.core.contours.places import long_enough
from dualcolor.core.job.wall_stages import pattern_samples
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.pattern.strand_edges import widened
from dualcolor.core.pattern.wave import modulated, waved
from dualcolor.core.sampling.coarse_to_fine import Level, Search
from dualcolor.core.sampling.curl import Curl
from dualcolor.core.sampling.optimized import optimized_samples
from dualcolor.core.sampling.paper import paper_samples
from dualcolor.core.sampling.projected_grid import phase_grid
from dualcolor.core.sampling.projector import Projector
from dualcolor.core.sampling.quality import seam_errors
from dualcolor.core.sampling.spacing import bounded, pushed
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.slices import slices
from dualcolor.tests.real_models import obj_model
from dualcolor.tests.robustness.strategies import examples
from dualcolor.tests.solids import box, cylinder, joined, lathe
from hypothesis import given
from hypothesis import strategies as st

PAPER = {"pattern": "wave_offset", "wave_depth_max": 0.75, "wave_depth_min": 0.375, "offset_max": 0.3}
DEFAULT = PrintSettings(**PAPER)
# The models that both samplings are compared on, and their heights, mm.
CORPUS = {
    "nc/gargoyle.obj": 102,
    "nc/kitten.obj": 54,
    "spot/spot.obj": 60,
    "bob/bob_tri.obj": 60,
    "koala_low_resolution.obj": 60,
    "nc/armadillo.obj": 80,
    "cat-low-resolution.obj": 60,
    "gutenberg/Gutenberg.obj": 80,
}


def lines_of(model, settings=DEFAULT):
    cut = slices(triangulate(model, settings), settings)
    return contours(cut.outlines, cut.loop_polygon, settings)


def both(lines, settings=DEFAULT, visibility=None):
    projector = Projector(lines, settings.projection_threshold)
    plain, best = paper_samples(projector, settings), optimized_samples(projector, settings, visibility)
    return plain, best, projector


@pytest.fixture(scope="module")
def sampled(data):
    """Contours of a model of the corpus, its samples by the paper, the optimized ones, and the projector; made once."""

    @cache
    def of(name):
        lines = lines_of(obj_model(data / "meshes" / name, CORPUS[name]))
        return lines, *both(lines)

    return of


def assert_bounds(lines, samples, settings=DEFAULT):
    gap = samples.spacing(lines)
    assert (gap >= settings.wavelength - 1e-6).all()
    assert (gap < 2 * settings.wavelength).all()
    assert ((np.diff(samples.start) > 0) == long_enough(lines.length, settings.wavelength)).all()
    assert (np.diff(samples.arc) > 0).all()
    assert (np.searchsorted(lines.arc_start, samples.arc, side="right") - 1 == samples.loop).all()


def random_solid(seed):
    """A few lathed solids and boxes that stand apart, lie within one another or meet."""
    rng = np.random.default_rng(seed)
    parts = []
    for _ in range(rng.integers(1, 4)):
        x, y = rng.uniform(-8, 8, 2)
        if rng.random() < 0.7:
            radius = np.clip(rng.uniform(1, 7) + np.cumsum(rng.normal(0, 1.0, 7)), 0.3, 15)
            height = rng.uniform(0, 1) + np.arange(7) * rng.uniform(0.2, 0.7)
            parts.append(lathe(np.column_stack([radius, height]), sides=24, x=x, y=y))
        else:
            size = rng.uniform(0.5, 8, 3)
            low = np.array([x, y, rng.uniform(0, 1)])
            parts.append(box(low, low + size * [1, 1, 0.5]))
    return joined(*parts)


@given(st.integers(0, 2**32 - 1), st.floats(0.8, 3.0))
@examples(50)
def test_spacing_is_bounded_on_random_solids(seed, wavelength):
    """The bounds do not depend on how good the plan is: a rough one, which is quick, puts them to a harder test."""
    chosen = PrintSettings(wavelength=wavelength, **PAPER)
    lines = lines_of(random_solid(seed), chosen)
    rough, quick = Search((Level(4, 6, 30),), 20), Search((Level(6, 1, 30),), 20)
    for enough in (0.0, 1.0):
        with patch.multiple("dualcolor.core.sampling.optimized", SEARCH=rough, QUICK_SEARCH=quick, QUICK_ENOUGH=enough):
            for samples in both(lines, chosen)[:2]:
                assert_bounds(lines, samples, chosen)


@given(st.lists(st.floats(0.01, 0.99), min_size=1, max_size=40))
@examples(60)
def test_any_samples_are_brought_within_the_bounds(shares):
    lines = lines_of(cylinder(radius=5, height=0.25))
    arc = np.sort(np.array(shares)) * lines.length[0]
    bound = bounded(lines, arc, np.zeros(len(arc), dtype=np.int64), DEFAULT.wavelength)
    gap = np.diff(np.append(bound, bound[0] + lines.length[0]))
    assert ((gap >= 1.2 - 1e-6) & (gap < 2.4)).all()
    fits = 1.201 < lines.length[0] / len(arc) < 2.399
    assert not fits or len(bound) == len(arc)


@given(st.lists(st.tuples(st.integers(2, 25), st.floats(1.01, 1.99)), min_size=1, max_size=5), st.integers(0, 2**31))
@examples(100)
def test_samples_of_any_number_that_fits_are_pushed_within_the_bounds_at_once(contours_, seed):
    """Each contour by itself; what is within them already stays."""
    rng = np.random.default_rng(seed)
    count = np.array([number for number, _ in contours_])
    length = count * np.array([mean for _, mean in contours_])
    start = np.append(0, np.cumsum(count))
    loop = np.repeat(np.arange(len(count)), count)
    local = np.concatenate(
        [np.sort(rng.uniform(0, around, number)) for number, around in zip(count, length, strict=True)]
    )
    moved = pushed(local, loop, start, length, 1.0)
    for number, around in enumerate(length):
        own = moved[start[number] : start[number + 1]]
        gap = np.diff(np.append(own, own[0] + around))
        assert (gap >= 1 - 1e-9).all() and (gap < 2).all()
    assert np.allclose(pushed(moved, loop, start, length, 1.0), moved, atol=1e-6)


def test_a_cylinder_has_no_seam_and_the_usual_spacing():
    lines = lines_of(cylinder(radius=10, height=10))
    _, best, projector = both(lines)
    assert len(set(np.diff(best.start))) == 1
    assert best.spacing(lines).mean() == pytest.approx(1.2 * 2**0.5, rel=0.02)
    errors = seam_errors(best, projector)
    assert np.nanmax(errors.error) < 1e-4


def test_a_cone_that_narrows_less_than_twofold_keeps_all_its_waves():
    lines = lines_of(lathe([[10, 0], [6, 30]]))
    plain, best, projector = both(lines)
    assert len(set(np.diff(best.start))) == 1
    assert len(set(np.diff(plain.start))) > 3
    assert seam_errors(best, projector).shares(1)["salient"] == 0


@pytest.mark.parametrize("profile", [[[10, 0], [4, 30]], [[4, 0], [10, 30]]], ids=["narrows", "widens"])
def test_a_cone_that_changes_more_has_few_more_births_or_deaths_than_it_must(profile):
    lines = lines_of(lathe(profile))
    plain, best, _ = both(lines)
    most, fewest = np.floor(lines.length.min() / 1.2), np.floor(lines.length.max() / 2.4) + 1
    changes = np.abs(np.diff(np.diff(best.start))).sum()
    assert fewest - most <= changes <= fewest - most + 2
    assert changes <= 0.6 * np.abs(np.diff(np.diff(plain.start))).sum()


def test_curl_of_waves_that_follow_the_projection_is_none():
    """On a solid whose contours are alike, each stretch has as many waves as what lies above it."""
    lines = lines_of(cylinder(radius=6, height=3))
    grid = phase_grid(Projector(lines, 0.6), DEFAULT.wavelength)
    curl = Curl(grid.coarser(4))
    coarse = grid.coarser(4)
    assert curl.whole.sum() == (np.diff(coarse.start)[:-1]).sum()
    many = len(coarse.arc)
    born, back = np.empty(many, dtype=np.float32), np.empty((2, many), dtype=np.float32)
    curl(coarse.length.astype(np.float32), np.zeros(many, dtype=np.float32), born)
    assert np.abs(curl.whole * born).max() < 1e-3
    waves, slide, price = np.random.default_rng(0).normal(size=(3, many)).astype(np.float32)
    price *= curl.whole
    curl(waves, slide, born)
    curl.transposed(price, back)
    assert born @ price == pytest.approx(back[0] @ waves + back[1] @ slide, rel=1e-4)


def test_nodes_are_linked_to_what_lies_above_them():
    lines = lines_of(lathe([[10, 0], [7, 4]]))
    projector = Projector(lines, 0.6)
    grid = phase_grid(projector, DEFAULT.wavelength)
    node = np.flatnonzero(grid.linked)
    here, above = projector.at(grid.arc[node]), projector.at(grid.above[node])
    low, high = projector.at(grid.arc[grid.low[node]]), projector.at(grid.arc[grid.ahead[grid.low[node]]])
    assert np.hypot(*(here - above).T).max() < 0.25
    between = low + grid.share[node, None] * (high - low)
    assert np.hypot(*(between - above).T).max() < 0.02
    assert (lines.layer[grid.loop[grid.low[node]]] == lines.layer[grid.loop[node]] + 1).all()


def test_where_the_next_layer_is_far_away_the_surface_is_torn():
    lines = lines_of(lathe([[10, 0], [10, 2], [6, 2], [6, 4]]))
    grid = phase_grid(Projector(lines, 0.6), DEFAULT.wavelength)
    layer = lines.layer[grid.loop]
    assert set(layer[np.isnan(grid.step)]) == {7, 15}


def test_same_input_same_samples():
    model = joined(lathe([[8, 0], [3, 5], [9, 12]]), box((5, 5, 0), (14, 14, 6)))
    lines = lines_of(model)
    first, again = both(lines)[1], both(lines)[1]
    assert first.arc.tobytes() == again.arc.tobytes()


def test_nothing_long_enough_gives_no_samples():
    lines = lines_of(cylinder(radius=0.3, height=2))
    assert len(both(lines)[1].arc) == 0


@pytest.mark.parametrize("name", ["nc/kitten.obj", "spot/spot.obj"])
def test_real_models_have_fewer_seams_than_by_the_paper(sampled, name):
    lines, plain, best, projector = sampled(name)
    assert_bounds(lines, best)
    before, after = (seam_errors(some, projector).shares(len(some.arc)) for some in (plain, best))
    assert after["salient"] < 0.6 * before["salient"]
    assert after["error_free"] + after["imperceptible"] > 0.99
    assert best.spacing(lines).mean() == pytest.approx(1.2 * 2**0.5, abs=0.03)


def test_a_tip_sharper_than_the_line_does_not_fold():
    """A wedge of 20 degrees: a line half a width inside its flanks would run over the tip and back."""
    wedge = lathe([[10, 0], [10, 2]], sides=3)
    wedge = replace(wedge, vertices=wedge.vertices * [1.0, 0.17, 1.0])
    for lines in (lines_of(wedge), lines_of(replace(wedge, vertices=wedge.vertices * [1.0, 0.5, 1.0]))):
        rings = shapely.linearrings(lines.points, indices=lines.loop)
        assert shapely.is_simple(rings).all()


def crossing(outlines):
    """The layers on which waved outlines cross themselves or one another, at zero tolerance."""
    count = np.diff(outlines.start)
    loop = np.repeat(np.arange(len(count)), count)
    # A speck of two points is a stroke, not a ring.
    ring = np.repeat(count > 2, count)
    _, number = np.unique(loop[ring], return_inverse=True)
    rings = shapely.linearrings(outlines.points[ring], indices=number)
    closed, number = shapely.get_coordinates(rings, return_index=True)
    together = shapely.multilinestrings(shapely.linestrings(closed, indices=number), indices=outlines.layer[count > 2])
    return np.unique(outlines.layer[count > 2])[~shapely.is_simple(together)].tolist()


@pytest.mark.parametrize("name", CORPUS)
def test_spacing_is_bounded_and_no_waved_outline_crosses_itself_or_another(sampled, name):
    """With both samplings, where both colors stand alike and where one is set back by all that it can be."""
    lines, plain, best, _ = sampled(name)
    assert_bounds(lines, best)
    unhindered = DEFAULT.changed({"max_unsupported": 1.0})
    for samples, tone in ((plain, 0.5), (best, 0.5), (plain, 0.0), (best, 1.0)):
        tones = np.full(len(lines.arc), tone)
        shaped = modulated(lines, tones, np.zeros(len(tones)), unhindered)
        assert crossing(waved(lines, samples, tones, *shaped, DEFAULT)) == [], (samples is best, tone)


@pytest.mark.parametrize("name", ["cat-low-resolution.obj", "nc/kitten.obj", "spot/spot.obj"])
def test_no_line_that_is_set_back_crosses_itself_or_another(data, name):
    """The default pattern: all of a color set back, or half of it in pieces of 1.4 mm."""
    settings = PrintSettings(max_unsupported=1.0)
    lines = lines_of(obj_model(data / "meshes" / name, CORPUS[name]), settings)
    none = pattern_samples(Projector(lines, 0.6), settings)
    for black in (0.0, 1.0, 0.5):
        pieces = np.random.default_rng(1).random(len(lines.arc) // 7 + 1) < black
        tones = np.where(np.repeat(pieces, 7)[: len(lines.arc)], 0.0, 1.0)
        depth, set_back = modulated(lines, tones, np.zeros(len(tones)), settings)
        assert set_back.max() == settings.offset_max
        set_back = widened(lines, tones, set_back, settings)
        assert crossing(waved(lines, none, tones, depth, set_back, settings)) == [], black


def test_seams_go_where_they_matter_less(sampled):
    """With the front alone visible, the seams there are fewer than without, and than a quarter of the paper's."""
    lines, plain, anywhere, projector = sampled("nc/kitten.obj")
    visibility = np.clip(0.5 - lines.normal[:, 1], 0, 1)
    aimed = optimized_samples(projector, DEFAULT, visibility)

    def seen(samples):
        errors = seam_errors(samples, projector)
        kept = ~errors.discarded
        weight = visibility[np.searchsorted(lines.arc, errors.arc[kept], side="right") - 1]
        return weight[errors.error[kept] >= 0.5].sum() / weight.sum()

    assert seen(aimed) < min(0.25 * seen(plain), 0.5 * seen(anywhere))
    assert_bounds(lines, aimed)


def test_images_on_the_layer_above_are_the_nearest_places_there():
    lines = lines_of(lathe([[10, 0], [4, 30]]))
    projector = Projector(lines, 0.6)
    arc = lines.arc[::5] + 0.01
    layer = lines.layer[projector.loop[::5]]
    image, (nearest, distance) = (
        projector.above(projector.at(arc), layer),
        projector.project(projector.at(arc), layer + 1),
    )
    top = layer == lines.layer.max()
    assert np.isnan(image[top]).all() and np.isfinite(distance[~top]).all()
    np.testing.assert_allclose(projector.at(image[~top]), projector.at(nearest[~top]), atol=1e-3)
