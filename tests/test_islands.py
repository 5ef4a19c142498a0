"""Charts of a texture: which texels they cover and which faces they join."""

import numpy as np
import shapely
from dualcolor.core.texture.islands import components
from dualcolor.core.texture.labels import rasterised


def test_texels_are_labelled_where_their_centre_is_inside():
    rng = np.random.default_rng(8)
    uv = rng.uniform(0, 1, (40, 3, 2))
    columns, rows = np.meshgrid((np.arange(45) + 0.5) / 45, (np.arange(38) + 0.5) / 38)
    for triangle in uv:
        labels, _ = rasterised(triangle[None], np.zeros(1, np.int64), 38, 45)
        assert np.array_equal(labels == 0, shapely.contains_xy(shapely.Polygon(triangle), columns, rows))


def test_a_triangulated_square_leaves_no_texel_out_and_none_twice():
    rng = np.random.default_rng(9)
    points = np.concatenate([rng.integers(0, 33, (60, 2)) / 32, [[0, 0], [1, 0], [0, 1], [1, 1]]])
    parts = shapely.get_parts(shapely.delaunay_triangles(shapely.MultiPoint(points)))
    uv = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    labels = [rasterised(triangle[None], np.zeros(1, np.int64), 32, 32)[0] == 0 for triangle in uv]
    assert (np.sum(labels, axis=0) == 1).all()


def test_charts_beyond_the_picture_wrap_around():
    corners = np.array([[0.75, -0.25], [1.25, -0.25], [1.25, 0.5], [0.75, 0.5]])
    labels, _ = rasterised(corners[[[0, 1, 2], [0, 2, 3]]], np.zeros(2, np.int64), 16, 16)
    expected = np.zeros((16, 16), bool)
    expected[np.ix_([12, 13, 14, 15, *range(8)], [12, 13, 14, 15, 0, 1, 2, 3])] = True
    assert np.array_equal(labels == 0, expected)


def test_components_of_a_long_shuffled_chain():
    rng = np.random.default_rng(10)
    names = rng.permutation(30000)
    links = np.stack([names[:-1], names[1:]], axis=1)
    cut = np.arange(len(links)) % 100 != 99
    root = components(rng.permutation(links[cut]))
    assert len(np.unique(root)) == 300
    assert components(np.zeros((0, 3), np.int64)).shape == (0,)
