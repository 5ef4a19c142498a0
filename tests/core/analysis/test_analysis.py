"""The analysis on shapes whose seams and tracelines are known, and its pictures."""

from dataclasses import replace

import numpy as np
import pytest
from dualcolor.core.analysis.analysis import NO_SEAMS, analyze, faded_share
from dualcolor.core.analysis.figures import heatmap, slope_colors, slope_picture, traceline_picture
from dualcolor.core.analysis.picture import CLAY, Stroke, dots, draw
from dualcolor.core.analysis.surface_curves import (
    BIRTH_COLOR,
    DEGRADED_COLOR,
    GONE_COLOR,
    HEAT_COLORS,
    HEAT_STOPS,
    heat_class,
    heat_colors,
    heat_curves,
    stretches,
    trace_curves,
)
from dualcolor.core.analysis.tracelines import tracelines
from dualcolor.core.contours.places import places
from dualcolor.core.errors import PrintError
from dualcolor.core.mesh.surface_points import points_on_faces
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.printability.slopes import from_flat_deg
from dualcolor.core.sampling.projector import Projector
from dualcolor.core.sampling.quality import SeamErrors
from dualcolor.core.sampling.samples import Samples
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.solids import box, cylinder, lathe

WAVE = PrintSettings(pattern="wave", offset_max=0.0, sampling="paper")
FRONT = (0.0, 0.0)


@pytest.fixture(scope="module")
def tube():
    return analyze(cylinder(radius=10, height=5), WAVE)


@pytest.fixture(scope="module")
def funnel():
    """45° steep, wider at the top."""
    return analyze(lathe([[5, 0], [10, 5]]), WAVE)


def test_a_cylinder_has_no_error_and_straight_tracelines(tube):
    pattern = tube.report["pattern"]
    assert pattern["error_free"] == 1.0 and pattern["discarded_probes"] == 0
    assert pattern["histogram"]["counts"][0] == pattern["probes"] > 0
    traced = tube.traced
    assert not traced.birth.any() and not traced.death.any()
    assert (np.diff(traced.start) == len(tube.layers)).all()
    curves = trace_curves(tube.lines, tube.layers.plane, tube.samples, traced)
    ways = curves.points.reshape(-1, len(tube.layers), 3)
    assert np.abs(ways[:, :, :2] - ways[:, :1, :2]).max() < 0.02
    assert np.hypot(*ways[..., :2].T) == pytest.approx(10.05, abs=0.02)
    assert (ways[0, :, 2] == tube.layers.plane).all()


def test_births_and_deaths_make_up_for_what_a_funnel_gains(funnel):
    count = np.bincount(funnel.lines.layer[funnel.samples.loop])
    report = funnel.report["tracelines"]
    assert report["births"] - report["deaths"] == count[-1] - count[0] > 10
    assert report["tracelines"] == count[0] + report["births"]
    upside_down = analyze(lathe([[10, 0], [5, 5]]), WAVE).report["tracelines"]
    assert upside_down["deaths"] > 10 and upside_down["longest_layers"] == len(funnel.layers)


def test_tracelines_hold_each_sample_once_and_climb_layer_by_layer(funnel):
    traced = funnel.traced
    assert np.array_equal(np.sort(traced.sample), np.arange(len(funnel.samples.arc)))
    layer = funnel.lines.layer[funnel.samples.loop[traced.sample]]
    inside = np.ones(len(layer) - 1, dtype=bool)
    inside[traced.start[1:-1] - 1] = False
    assert (np.diff(layer)[inside] == 1).all()


def test_lines_go_on_over_less_than_half_a_wavelength(tube):
    """One sample a layer, all above each other but for one step to the side."""
    lines, half = tube.lines, len(tube.layers) // 2
    for step, count in ((0.4, 1), (0.7, 2)):
        along = 20 + step * WAVE.wavelength * (np.arange(len(tube.layers)) >= half)
        samples = Samples.on(lines, lines.arc_start[:-1] + along)
        projector = Projector(lines, WAVE.projection_threshold)
        found = tracelines(samples, projector, WAVE.wavelength)
        assert len(found.start) - 1 == count
        assert found.birth.sum() == found.death.sum() == count - 1


def test_what_begins_on_nothing_is_no_birth():
    """A mushroom: the rim of its hat hangs in the air, so its lines begin there, but none is born."""
    found = analyze(lathe([[4, 0], [4, 3], [10, 3], [10, 6]]), WAVE)
    report = found.report["tracelines"]
    count = np.bincount(found.lines.layer[found.samples.loop])
    assert report["births"] == report["deaths"] == 0
    assert report["tracelines"] == count[0] + count[-1]
    assert found.report["pattern"]["discarded_probes"] > 0


def test_classes_and_colors_of_errors():
    assert heat_class(np.array([0.0, 0.049, 0.05, 1.4, 1.5, 3.0, 4.0])).tolist() == [-1, -1, 0, 1, 1, 2, 3]
    assert heat_colors(np.array(HEAT_STOPS)) == pytest.approx(np.array(HEAT_COLORS))


def test_seams_are_where_tracelines_begin(funnel):
    seams, discarded = heat_curves(funnel.lines, funnel.layers.plane, funnel.errors)
    assert len(discarded.points) == 0 and len(seams[-1].points) > 0
    lines, plane = funnel.lines, funnel.layers.plane
    born = funnel.lines.layer[funnel.samples.loop[funnel.traced.birth]]
    heights = np.unique(seams[-1].points[:, 2])
    assert np.isin(heights, np.concatenate([plane[born], plane[born - 1]])).all()
    unseen = SeamErrors(funnel.errors.arc, np.full(len(funnel.errors.arc), np.nan))
    seams, discarded = heat_curves(lines, plane, unseen)
    assert not any(len(curves.points) for curves in seams) and len(discarded.points) > 0


def test_curves_cover_what_is_shown_and_nothing_else(tube):
    lines, plane = tube.lines, tube.layers.plane
    arc, _ = places(lines, 0.25)
    whole = stretches(lines, plane, arc, np.ones(len(arc), dtype=bool), np.zeros(len(arc)))
    assert len(whole.start) - 1 == len(lines.layer)
    length = np.linalg.norm(np.diff(whole.points, axis=0), axis=1)
    length[whole.start[1:-1] - 1] = 0
    assert length.sum() == pytest.approx(2 * np.pi * 10.05 * len(plane), rel=2e-3)
    shown = np.arange(len(arc)) % 10 < 3
    some = stretches(lines, plane, arc, shown, np.arange(len(arc)))
    assert np.array_equal(np.unique(some.value), np.flatnonzero(shown))
    assert np.diff(some.start).max() == 4


def test_offset_says_that_it_has_no_seams():
    found = analyze(cylinder(height=2), PrintSettings())
    assert found.errors is None and found.traced is None and found.warnings == [NO_SEAMS]
    assert found.report["pattern"] is None and found.report["orientations"]
    with pytest.raises(PrintError, match="no waves"):
        heatmap(found, FRONT)
    assert slope_picture(found, FRONT, 100).shape[2] == 3


def test_waves_fade_where_walls_are_thin_only():
    thick, thin = (
        analyze(box((0, 0, 0), (20, depth, 3)), WAVE).report["faded"]["share"] for depth in (20.0, 1.0)
    )  # fmt: skip
    # Around its corners the block has less room too.
    assert thick < 0.04 and thin > 0.9


def test_flat_layers_are_not_faded(tube):
    settings = WAVE.changed({"flat_layers": 5})
    faded = faded_share(tube.lines, np.full(len(tube.lines.arc), 0.5), np.zeros(len(tube.lines.arc)), settings)
    assert not faded.any()


def test_places_on_faces_stand_for_all_of_their_area():
    corners = np.array([[[0, 0, 0], [30, 0, 0], [0, 20, 0]], [[0, 0, 0], [100, 0, 0], [100, 0.2, 0]]], dtype=float)
    on = points_on_faces(corners, 0.5)
    assert np.bincount(on.face, on.weight) == pytest.approx(1.0)
    assert on.share.min() > 0 and on.share.sum(axis=1) == pytest.approx(1.0)
    middle = np.stack([np.bincount(on.face, on.weight * on.share[:, corner]) for corner in range(3)], axis=1)
    assert middle == pytest.approx(1 / 3, abs=1e-3)
    assert np.bincount(on.face)[1] < 300


def test_pictures_hide_what_lies_behind():
    mesh = triangulate(box((0, 0, 0), (10, 10, 10)), WAVE)
    low, high = mesh.bounds
    middle = (low + high) / 2
    plain = draw(mesh, [], FRONT, 100)
    front, back = ([[middle[0], y, middle[2]]] for y in (low[1], high[1]))
    behind = draw(mesh, [Stroke(dots(np.array(back)), (1.0, 0.0, 0.0), 4.0)], FRONT, 100)
    before = draw(mesh, [Stroke(dots(np.array(front)), (1.0, 0.0, 0.0), 4.0)], FRONT, 100)
    assert np.array_equal(behind, plain)
    assert before[before.shape[0] // 2, before.shape[1] // 2].tolist() == [255, 0, 0]
    assert np.array_equal(draw(mesh, [Stroke(dots(np.array(back)), (1.0, 0.0, 0.0), 4.0)], (180.0, 0.0), 100), before)
    assert plain[0, 0].tolist() == [255, 255, 255] and plain[50, 50].max() < 250


def test_clay_is_brightest_where_it_faces_the_light():
    ball = lathe([[0.01, 0], [7, 3], [10, 10], [7, 17], [0.01, 20]])
    shown = draw(triangulate(ball, WAVE), [], FRONT, 200)
    row, column = np.indices(shown.shape[:2]) - 100
    inside = row**2 + column**2 < 60**2
    light = shown[inside] / np.array(CLAY) / 255
    assert light.max() < 1.01 and np.ptp(light, axis=1).max() < 0.02  # one color, in more or less light
    assert light[row[inside] < -30].mean() > light[row[inside] > 30].mean() + 0.1  # from above
    assert light[column[inside] < -30].mean() > light[column[inside] > 30].mean() + 0.1  # from the left


def test_faces_have_the_color_of_what_their_slope_shows():
    height = 10 * np.tan(np.radians([60, 25, 15]))
    found = analyze(lathe([[32, 0], [22, height[0]], [12, height[:2].sum()], [2, height.sum()]]), WAVE)
    rise = from_flat_deg(found.mesh)
    for degrees, color in ((60, CLAY), (25, DEGRADED_COLOR), (15, GONE_COLOR)):
        own = np.abs(rise - degrees) < 1
        assert own.sum() > 10 and (slope_colors(found)[own] == color).all()


@pytest.mark.parametrize("pixels", [120, 400])
def test_every_color_of_the_legend_is_below_the_picture(pixels):
    legend = [((value, 0.0, 1.0 - value), "a word or two") for value in np.linspace(0, 1, 6).tolist()]
    mesh = triangulate(box((0, 0, 0), (10, 10, 10)), WAVE)
    plain, shown = (draw(mesh, [], FRONT, pixels, legend=each) for each in ([], legend))
    height = len(plain)
    assert np.array_equal(shown[:height], plain)
    for color, _ in legend:
        row, column = np.nonzero((shown[height:] == [round(255 * value) for value in color]).all(axis=2))
        assert len(row) > 100 and np.ptp(row) < 15 and np.ptp(column) < 15  # one patch of each


def test_pictures_show_seams_and_births(funnel):
    seams, traced = (picture(funnel, (0.0, 8.0), 300) for picture in (heatmap, traceline_picture))
    for picture, color in ((seams, HEAT_COLORS[-1]), (traced, BIRTH_COLOR)):
        near = np.abs(picture[:-60].astype(float) - 255 * np.array(color)).max(axis=2) < 20
        assert near.sum() > 5
    assert np.array_equal(seams, heatmap(funnel, (0.0, 8.0), 300))
    straight = replace(funnel, errors=None, traced=None)
    for picture in (heatmap, traceline_picture):
        with pytest.raises(PrintError, match="no waves"):
            picture(straight, (0.0, 8.0), 300)
