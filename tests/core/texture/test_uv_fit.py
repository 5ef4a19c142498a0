"""A UV map can hold a picture of a surface if it lies in the unit square, nowhere twice, and leaves no face out."""

import numpy as np
import pytest
from dualcolor.core.texture import uv_fit
from dualcolor.core.texture.uv_fit import is_one_to_one

CHARTS = 400  # small squares in rows, with gaps as wide as a tenth of them


def charts():
    """(2 N, 3, 2) triangles of N squares that lie beside one another."""
    side = int(CHARTS**0.5)
    row, column = np.divmod(np.arange(CHARTS), side)
    low = np.stack([column, row], axis=1) / side
    corners = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]]) * (0.9 / side)
    return (low[:, None, None] + corners).reshape(-1, 3, 2)


@pytest.fixture
def area():
    return np.ones(2 * CHARTS)


def test_charts_beside_one_another_are_one_to_one(area):
    assert is_one_to_one(charts(), area)
    assert is_one_to_one(charts()[:, ::-1], area)


def test_mirrored_halves_are_not(area):
    uv = charts()
    uv[CHARTS:] = uv[:CHARTS, ::-1]
    assert not is_one_to_one(uv, area)


@pytest.mark.parametrize("shift", [(0.5, 0), (0, -0.5), (1, 0)])
def test_charts_beyond_the_picture_are_not(area, shift):
    assert not is_one_to_one(charts() + shift, area)


def test_faces_without_room_are_not_unless_they_are_tiny(area):
    uv = charts()
    uv[:40] = 0.0
    assert not is_one_to_one(uv, area)
    area[:40] = 1e-3
    assert is_one_to_one(uv, area)


def test_a_map_without_any_area_is_not(area):
    assert not is_one_to_one(np.zeros_like(charts()), area)


def test_faces_that_all_fill_the_picture_are_told_by_their_area(monkeypatch):
    """As after Blender's Reset; points on 2000 such faces would take gigabytes."""
    monkeypatch.setattr(uv_fit, "points_on_faces", lambda *_: pytest.fail("not needed"))
    full = np.tile([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]], (1000, 1, 1))
    assert not uv_fit.is_one_to_one(full, np.ones(2000))
