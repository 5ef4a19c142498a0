"""The grid of every few layers: what is kept, where the others lead to, and the phase that they get."""

import numpy as np
import pytest
from dualcolor.core.contours.contours import contours
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.ragged import sums
from dualcolor.core.sampling.fewer_layers import fewer_layers
from dualcolor.core.sampling.phase import Phase
from dualcolor.core.sampling.projected_grid import phase_grid
from dualcolor.core.sampling.projector import Projector
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.slices import slices
from dualcolor.tests.solids import box, joined, lathe

SETTINGS = PrintSettings(pattern="wave", wavelength=1.2)


def grids(model, layers=4):
    cut = slices(triangulate(model, SETTINGS), SETTINGS)
    lines = contours(cut.outlines, cut.loop_polygon, SETTINGS)
    grid = phase_grid(Projector(lines, SETTINGS.projection_threshold), SETTINGS.wavelength, 12)
    return lines, grid, fewer_layers(grid, layers, 2.4)


def test_nodes_between_the_layers_that_are_kept_lead_straight_up_to_them():
    lines, grid, layers = grids(lathe([[10, 0], [8, 10]]))
    assert set(lines.layer[layers.few.loop]) == {3, 7, 11, 15, 19, 23, 27, 31, 35, 39}
    projector = Projector(lines, SETTINGS.projection_threshold)
    node = np.flatnonzero(~layers.kept)
    here, there = (projector.at(arc[node]) for arc in (grid.arc, layers.place))
    assert np.abs(np.arctan2(*here.T) - np.arctan2(*there.T)).max() < 0.01
    few = layers.few
    assert (few.span[few.linked] == 4).all()
    # A cone's contours get shorter upwards: the longest that leads to one is that three layers below it.
    first = few.loop[few.start[:-1][np.diff(few.start) > 0]]
    np.testing.assert_allclose(sums(few.longest, few.start)[first], lines.length[first - 3], rtol=0.015)
    np.testing.assert_allclose(few.shortest, few.length, rtol=0.01)


def test_sliding_is_shared_evenly_by_the_layers_between():
    lines, grid, layers = grids(lathe([[10, 0], [10, 10]]))
    few = layers.few
    turns = np.zeros(len(lines.layer), dtype=np.int64)
    turns[np.unique(few.loop)] = 36
    place = (few.arc - lines.arc_start[few.loop]) / lines.length[few.loop]
    phase = Phase(36 * place + 0.2 * ((lines.layer[few.loop] + 1) // 4), turns)
    slide = (phase.at(few.low, few.share, few) - phase.value)[few.linked]
    slide = np.mod(slide + 0.5, 1) - 0.5
    assert np.ptp(slide) < 0.01 < slide.mean() < 0.4
    whole = layers.everywhere(phase)
    assert (whole.turns == 36).all()
    node = np.flatnonzero(grid.linked)
    link = whole.at(grid.low[node], grid.share[node], grid) - whole.value[node]
    link -= np.rint(link)
    above_first = lines.layer[grid.loop[node]] > 3
    np.testing.assert_allclose(link[above_first], slide.mean() / 4, atol=0.005)


@pytest.mark.parametrize(
    ("model", "kept"),
    [
        (lathe([[10, 0], [10, 4.5], [5, 5], [5, 10]]), {17, 18}),
        (joined(box((0, 0, 0), (10, 10, 10)), box((20, 0, 0), (30, 10, 4.5))), {17}),
    ],
    ids=["shelf", "top"],
)
def test_contours_that_do_not_lead_up_are_kept(model, kept):
    lines, _, layers = grids(model)
    regular = (lines.layer.max() - lines.layer) % 4 == 0
    assert kept & set(lines.layer[np.setdiff1d(layers.few.loop, np.flatnonzero(regular))])
    assert not np.isnan(layers.place[~layers.kept]).any()
