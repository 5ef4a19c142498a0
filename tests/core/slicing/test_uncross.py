"""Loops that cross are taken apart at the crossings: nothing else about them changes."""

import numpy as np
import pytest
import shapely
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.ragged import starts
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing import slices as slicing
from dualcolor.core.slicing.outlines import Outlines
from dualcolor.core.slicing.uncross import uncrossed
from dualcolor.core.slicing.union import winding_number
from dualcolor.tests.solids import box, joined, lathe


def loops(*shapes, layer=None):
    """Loops whose segments carry the line that they lie on: their own number and how far along it they are."""
    points = np.concatenate([np.asarray(shape, dtype=float) for shape in shapes])
    count = np.array([len(shape) for shape in shapes])
    carried = np.zeros((len(points), 2, 3))
    carried[:, 1, 0] = 1
    layer = np.zeros(len(shapes), dtype=np.int64) if layer is None else np.asarray(layer)
    return Outlines(points, starts(count), layer, np.arange(len(points)), carried)


def random_loops(seed):
    rng = np.random.default_rng(seed)
    return loops(*(rng.uniform(0, 10, (n, 2)) for n in rng.integers(3, 30, 6)), layer=[0, 0, 1, 1, 1, 4])


def crossings(lines):
    """How many pairs of segments of a layer cross, by GEOS."""
    segments = shapely.linestrings(np.stack([lines.points, lines.ends], axis=1))
    one, other = shapely.STRtree(segments).query(segments, predicate="crosses")
    layer = lines.layer[lines.loop]
    met = shapely.get_coordinates(shapely.intersection(segments[one], segments[other]))
    ends = np.stack([end[side] for end in (lines.points, lines.ends) for side in (one, other)])
    away = np.linalg.norm(ends - met, axis=2).min(axis=0)
    return int(((layer[one] == layer[other]) & (away > 1e-9)).sum())


@pytest.mark.parametrize("seed", range(5))
def test_winding_numbers_stay_and_no_crossing_is_left(seed):
    before = random_loops(seed)
    after, _ = uncrossed(before)
    assert crossings(before) > 20 and crossings(after) == 0
    probe = np.random.default_rng(seed).uniform(0, 10, (2000, 2))
    for layer in (0, 1, 4):
        one, other = (lines.selected(lines.layer == layer) for lines in (before, after))
        assert np.array_equal(*(winding_number(probe, lines.points, lines.ends) for lines in (one, other)))
    assert after.signed_area.sum() == pytest.approx(before.signed_area.sum())


@pytest.mark.parametrize("seed", range(5))
def test_pieces_know_where_they_are_on_the_segment_they_are_of(seed):
    before = random_loops(seed)
    after, _ = uncrossed(before)
    begin, end = before.points[after.face], before.ends[after.face]
    for side, point in enumerate((after.points, after.ends)):
        share = after.carried[:, side, :1]
        assert point == pytest.approx(begin + share * (end - begin), abs=1e-9)
    assert (after.carried[:, 1, 0] > after.carried[:, 0, 0]).all()
    length = np.bincount(after.face, after.carried[:, 1, 0] - after.carried[:, 0, 0])
    assert length == pytest.approx(np.ones(len(before.points)))


def test_a_figure_of_eight_becomes_two_loops():
    eight, _ = uncrossed(loops([[0, 0], [4, 4], [4, 0], [0, 4]]))
    assert sorted(eight.signed_area) == pytest.approx([-4, 4])
    assert (eight.count == 3).all()


def test_loops_that_touch_or_lie_on_one_another_or_in_other_layers_stay_as_they_are():
    square = np.array([[0, 0], [4, 0], [4, 4], [0, 4]])
    beside, touching, elsewhere = (square + np.array(shift) for shift in ((4, 0), (8, 4), (1, 1)))
    lines = loops(square, square, beside, touching, elsewhere, layer=[0, 0, 0, 0, 1])
    after, meeting = uncrossed(lines)
    assert after is lines and meeting.tolist() == [0]
    assert uncrossed(lines.selected(np.zeros(5, dtype=bool)))[0].points.shape == (0, 2)


def test_too_many_near_segments_are_left_to_others():
    rng = np.random.default_rng(1)
    many = loops(rng.uniform(0, 10, (2000, 2)))
    assert uncrossed(many)[0] is many


def test_shells_that_cross_are_united_without_geos(monkeypatch):
    monkeypatch.setattr(slicing, "united", None)
    settings = PrintSettings(center_on_bed=False)
    turned = lathe([[6.1, 0], [6.1, 4]], sides=7, y=0.7)
    model = joined(box((0, 0, 0), (10, 10, 4)), box((5.5, 5, 0), (15, 16, 4)), turned, box((1, 1, 0), (2, 2, 4)))
    result = slicing.slices(triangulate(model, settings), settings)
    parts = [shapely.box(0, 0, 10, 10), shapely.box(5.5, 5, 15, 16), shapely.Polygon(turned.vertices[:7, :2])]
    assert result.united_layers == len(result.layers)
    assert shapely.area(result.regions) == pytest.approx(shapely.union_all(parts).area)
    assert shapely.is_valid(result.regions).all()
