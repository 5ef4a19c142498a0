"""What is too fine for an eye at its distance goes, in linear light; nothing else changes."""

from pathlib import Path

import numpy as np
import pytest
from dualcolor.core.pictures.viewing import contact_sheet, encoded, resolution_mm, seen_from, view_files
from dualcolor.core.texture.decode import linear_from_srgb


def gray(values):
    return np.repeat(np.asarray(values, dtype=np.uint8)[..., None], 3, axis=2)


def test_an_eye_resolves_an_arc_minute():
    assert resolution_mm(300.0) == pytest.approx(0.0873, abs=1e-4)
    assert resolution_mm(2000.0) == pytest.approx(0.582, abs=1e-3)


def test_encoding_undoes_decoding():
    codes = np.arange(256)
    assert (encoded(linear_from_srgb(codes / 255.0)) == codes).all()


def test_fine_stripes_become_the_mean_of_their_light():
    stripes = np.tile([0, 255], (40, 20))
    seen = seen_from(gray(stripes), 0.1, 2000.0)
    middle = linear_from_srgb(seen[:, 10:-10].astype(float) / 255)
    np.testing.assert_allclose(middle, 0.5, atol=0.01)  # the mean of the codes would be 0.21


def test_an_even_picture_stays_even_up_to_its_edges():
    assert (seen_from(gray(np.full((12, 9), 77)), 0.05, 2000.0) == 77).all()


def test_what_is_coarse_stays():
    picture = gray(np.repeat([[20, 200]], 10, axis=0).repeat(40, axis=1))
    seen = seen_from(picture, 1.0, 300.0)
    assert np.abs(seen.astype(int) - picture)[:, :38].max() == 0


def test_an_edge_is_as_wide_as_a_gaussian_of_that_half_width():
    light = linear_from_srgb(seen_from(gray(np.repeat([[0, 255]], 4, axis=0).repeat(60, axis=1)), 0.05, 700.0) / 255.0)
    rise = np.diff(light[0, :, 0])
    sigma = np.sqrt((rise * (np.arange(len(rise)) - 59.0) ** 2).sum() / rise.sum()) * 0.05
    assert sigma * 2.3548 == pytest.approx(resolution_mm(700.0), rel=0.03)


def test_a_sheet_holds_all_pictures_unchanged():
    rows = [[gray(np.full((30, 40), 10 * row + column)) for column in range(3)] for row in range(2)]
    sheet = contact_sheet(rows, ["a", "b", "c"])
    for row in range(2):
        for column in range(3):
            assert (sheet == 10 * row + column).all(axis=2).sum() >= 30 * 40


@pytest.mark.parametrize("width", [120, 200, 900])
def test_titles_of_a_sheet_are_no_wider_than_its_pictures(width):
    rows = [[gray(np.full((30, width), 255))] * 2]
    head = contact_sheet(rows, ["predicted print from 300 mm (hand)", ""])[:30]
    inked = np.flatnonzero((head < 200).any(axis=(0, 2)))
    assert len(inked) > 50 and inked.max() <= 12 + width


def test_files_are_named_by_their_view():
    path = Path("out/cow.png")
    assert view_files(path, []) == {"three-quarter": path}
    assert view_files(path, ["front", "turntable"]) == {
        "front": Path("out/cow_front.png"),
        "turntable": Path("out/cow_turntable.gif"),
    }
