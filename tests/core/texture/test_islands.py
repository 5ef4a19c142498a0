"""Charts of a texture: which texels they cover and which faces they join."""

import numpy as np
import shapely
from dualcolor.core.texture import labels as labels_module
from dualcolor.core.texture.islands import uv_areas
from dualcolor.core.texture.labels import rasterized


def labeled(uv, island, height, width, place=None):
    """Where no `place` is given no triangles meet."""
    place = np.arange(3 * len(uv)).reshape(-1, 3) if place is None else place
    return rasterized(uv, uv_areas(uv), island, height, width, place)


def test_texels_are_labeled_where_their_center_is_inside():
    rng = np.random.default_rng(8)
    uv = rng.uniform(0, 1, (40, 3, 2))
    columns, rows = np.meshgrid((np.arange(45) + 0.5) / 45, (np.arange(38) + 0.5) / 38)
    for triangle in uv:
        labels, _ = labeled(triangle[None], np.zeros(1, np.int64), 38, 45)
        assert np.array_equal(labels == 0, shapely.contains_xy(shapely.Polygon(triangle), columns, rows))


def test_a_triangulated_square_leaves_no_texel_out_and_none_twice():
    rng = np.random.default_rng(9)
    points = np.concatenate([rng.integers(0, 33, (60, 2)) / 32, [[0, 0], [1, 0], [0, 1], [1, 1]]])
    parts = shapely.get_parts(shapely.delaunay_triangles(shapely.MultiPoint(points)))
    uv = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    labels = [labeled(triangle[None], np.zeros(1, np.int64), 32, 32)[0] == 0 for triangle in uv]
    assert (np.sum(labels, axis=0) == 1).all()


def test_charts_beyond_the_picture_wrap_around():
    corners = np.array([[0.75, -0.25], [1.25, -0.25], [1.25, 0.5], [0.75, 0.5]])
    labels, _ = labeled(corners[[[0, 1, 2], [0, 2, 3]]], np.zeros(2, np.int64), 16, 16)
    expected = np.zeros((16, 16), bool)
    expected[np.ix_([12, 13, 14, 15, *range(8)], [12, 13, 14, 15, 0, 1, 2, 3])] = True
    assert np.array_equal(labels == 0, expected)


def folded_sheet(rng, count=300):
    """Triangles (T, 3, 2) of a sheet crumpled in the plane, and the points (T, 3) that they share."""
    flat = rng.uniform(0, 1, (count, 2))
    parts = shapely.get_parts(shapely.delaunay_triangles(shapely.MultiPoint(flat)))
    corners = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    place = np.argmax((corners[:, :, None] == flat).all(axis=3), axis=2)
    return rng.normal(flat, 0.05)[place], place


def test_triangles_that_are_known_to_meet_give_the_same_labels():
    rng = np.random.default_rng(11)
    uv, place = folded_sheet(rng)
    mirrored = np.linalg.det(uv[:, 1:] - uv[:, :1]) < 0
    assert 0.05 < mirrored.mean() < 0.95
    for shift in (0.0, 0.4, -3.3):
        alone, _ = labeled(uv + shift, np.zeros(len(uv), np.int64), 210, 190)
        meeting, _ = labeled(uv + shift, np.zeros(len(uv), np.int64), 210, 190, place)
        assert np.array_equal(alone, meeting) and (alone == 0).mean() > 0.5


def rectangle(u0, v0, u1, v1):
    corners = np.array([[u0, v0], [u1, v0], [u1, v1], [u0, v1]])
    return corners[[[0, 1, 2], [0, 2, 3]]]


def test_islands_become_one_where_they_share_more_than_a_rounded_border():
    charts = [(0.0, 0.0, 0.5, 0.5), (0.48, 0.0, 0.9, 0.5), (0.6, 0.1, 0.7, 0.2), (0.0, 0.6, 0.3, 0.9)]
    charts += [(1.1, 0.7, 1.6, 0.8)]  # the same texels as the one before, next door
    uv, island = np.concatenate([rectangle(*chart) for chart in charts]), np.repeat(np.arange(5), 2)
    labels, after = labeled(uv, island, 100, 100)
    assert len(set(after[:2]) | set(after[2:6])) == 2 and len(set(after)) == 3
    assert after[2] == after[4] and after[6] == after[8] and (after[::2] == after[1::2]).all()
    assert set(labels[:50, :48].ravel()) == {after[0]} and set(labels[:50, 50:90].ravel()) == {after[2]}
    assert set(labels[60:90, :30].ravel()) == {after[6]} == set(labels[70:80, 30:60].ravel())
    assert np.count_nonzero(labels != -1) == 50 * 90 + 30 * 30 + 10 * 30


def test_charts_far_out_are_where_they_would_be_near(monkeypatch):
    uv = np.concatenate([rectangle(0.125, 0.25, 0.5, 0.75), rectangle(0.5, 0.25, 0.75, 0.5)])
    island = np.repeat([0, 1], 2)
    near, _ = labeled(uv, island, 32, 32)
    far = uv + np.repeat([[[-524288.0, 524288.0]], [[524288.0, -524288.0]]], 2, axis=0)
    assert np.array_equal(labeled(far, island, 32, 32)[0], near)
    monkeypatch.setattr(labels_module, "_MOST_KEYS", 1)
    assert np.array_equal(labeled(far, island, 32, 32)[0], near)


def test_a_face_without_an_area_at_the_border_of_a_chart_changes_nothing():
    corners = np.array([[0.1, 0.1], [0.9, 0.1], [0.9, 0.7], [0.1, 0.7], [0.9, 0.4]])
    place = np.array([[0, 1, 2], [0, 2, 3], [1, 4, 2]])
    alone, _ = labeled(corners[place[:2]], np.zeros(2, np.int64), 32, 32, place[:2])
    beside, _ = labeled(corners[place], np.zeros(3, np.int64), 32, 32, place)
    assert np.array_equal(alone, beside)
    assert (alone == 0).sum() == 26 * 19
