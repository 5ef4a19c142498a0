"""Painted contrast on slopes, and suggested orientations, of shapes for which both are known."""

import numpy as np
import pytest
from dualcolor.core.analysis.orientation import CANDIDATES, directions, suggested, upright
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.printability.slopes import face_contrast, slope_report, slope_warnings
from dualcolor.core.settings import PrintSettings
from dualcolor.core.texture.pyramid import build_pyramids
from dualcolor.tests.solids import box, lathe, surface

WAVE = PrintSettings(pattern="wave", offset_max=0.0, sampling="paper")


def plate(tones, turn=None, size=(40.0, 40.0, 4.0)):
    """A plate whose upper side is a grid of squares of `tones` (R, C); its other sides are gray."""
    rows, columns = tones.shape
    x, y = np.linspace(0, size[0], columns + 1), np.linspace(0, size[1], rows + 1)
    vertices, faces, tone = [], [], []
    for row in range(rows):
        for column in range(columns):
            first = len(vertices)
            for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
                vertices.append([x[column + u], y[row + v], size[2]])
            faces += [[first, first + 1, first + 2], [first, first + 2, first + 3]]
            tone += [tones[row, column]] * 6
    rest = box((0, 0, 0), size)
    corners = rest.corner_vertex.reshape(-1, 3)
    corners = corners[~(rest.vertices[corners][..., 2] == size[2]).all(axis=1)]
    faces = np.concatenate([faces, corners + len(vertices)])
    tone = np.concatenate([tone, np.full(corners.size, 0.5)])
    vertices = np.concatenate([vertices, rest.vertices])
    return surface(vertices if turn is None else vertices @ turn.T, faces, tone=tone)


def contrast_of(model, settings=WAVE):
    mesh = triangulate(model, settings)
    return mesh, face_contrast(mesh, build_pyramids(mesh, model.textures, 0.5, "trilinear"), settings)


def about_x(degrees):
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]])


@pytest.mark.parametrize(("degrees", "degraded", "gone"), [(10.0, 0, 1), (25.0, 1, 0), (35.0, 0, 0)])
def test_share_of_contrast_on_a_slanted_plate_is_exact(degrees, degraded, gone):
    """White above, gray elsewhere: with white share w of the area, half of all contrast is above."""
    _, paint = contrast_of(plate(np.ones((1, 1)), about_x(degrees)))
    above, area = 1600.0, 2 * 1600.0 + 4 * 160.0
    white = above / area
    assert paint.area.sum() == pytest.approx(area)
    assert paint.mean == pytest.approx(2 * white * (1 - white) * 0.5)
    report = slope_report(paint)
    below = (white * 0.5 * above) / (paint.mean * area)  # the gray underside is as flat
    sides = degrees > 60
    assert report["contrast_degraded"] == pytest.approx(degraded * (0.5 + below) + sides)
    assert report["contrast_gone"] == pytest.approx(gone * (0.5 + below))
    assert report["area_gone"] == pytest.approx(gone * 3200 / area)
    assert bool(slope_warnings(report)) == bool(gone)


def test_of_many_small_faces_some_stand_for_all():
    board, settings = np.random.default_rng(3).random((10, 10)), PrintSettings()
    for turn in (about_x(10.0), about_x(25.0), about_x(35.0)):
        _, coarse = contrast_of(plate(board, turn), settings)
        _, fine = contrast_of(plate(np.kron(board, np.ones((10, 10))), turn), settings)
        assert np.count_nonzero(fine.contrast) < len(fine.area) / 3 and len(fine.area) > 20_000
        assert fine.area.sum() == pytest.approx(coarse.area.sum())
        assert fine.mean == pytest.approx(coarse.mean, rel=0.01)
        assert slope_report(fine) == pytest.approx(slope_report(coarse), rel=0.01)


def test_nothing_painted_is_no_contrast():
    _, paint = contrast_of(box((0, 0, 0), (10, 10, 10)))
    assert paint.mean == 0 and slope_report(paint)["contrast_gone"] == 0.0


def test_a_painted_plate_that_lies_is_put_upright():
    checks = np.indices((4, 4)).sum(axis=0) % 2.0
    found = suggested(*contrast_of(plate(checks)), WAVE)
    assert abs(found[0].up[2]) < 0.1 and found[0].contrast > 0.99
    assert found[0].height_mm == pytest.approx(40.0)
    (lying,) = [one for one in found if one.up == (0.0, 0.0, 1.0)]
    assert lying.contrast < 0.05 and lying.height_mm == pytest.approx(4.0)
    standing = suggested(*contrast_of(plate(checks, about_x(90.0))), WAVE)
    assert standing[0].up == (0.0, 0.0, 1.0)


@pytest.mark.parametrize(("degrees", "shown"), [(15.0, 0.0), (22.5, 0.25), (25.0, 0.5), (29.0, 0.9), (40.0, 1.0)])
def test_between_20_and_30_degrees_from_flat_contrast_shows_in_part(degrees, shown):
    checks = np.indices((4, 4)).sum(axis=0) % 2.0
    found = suggested(*contrast_of(plate(checks, about_x(degrees))), WAVE)
    (present,) = [one for one in found if one.up == (0.0, 0.0, 1.0)]
    assert present.contrast == pytest.approx(shown, abs=1e-6)


def test_what_is_painted_evenly_lies_on_its_largest_face():
    found = suggested(*contrast_of(box((0, 0, 0), (40, 4, 40))), WAVE)
    assert np.abs(found[0].up[1]) == pytest.approx(1.0)
    assert found[0].support_mm2 == 0 and found[0].bed_mm2 == pytest.approx(1600.0)


def test_overhangs_count_as_support():
    """A mushroom needs support below the rim of its hat; upside down it needs none."""
    mesh, paint = contrast_of(lathe([[4, 0], [4, 20], [15, 20], [15, 25]], sides=192))
    found = {one.up: one for one in suggested(mesh, paint, WAVE)}
    rim = np.pi * (15**2 - 4**2)
    assert found[(0.0, 0.0, 1.0)].support_mm2 == pytest.approx(rim, rel=1e-3)
    best = suggested(mesh, paint, WAVE)[0]
    assert best.up[2] == pytest.approx(-1.0) and best.support_mm2 == 0.0


def test_orientations_that_do_not_fit_are_left_out():
    """A block shows the picture on its top if it is put on one of four sides; on two of them it may be too high."""
    for length, ways in ((140.0, 4), (155.0, 2)):
        block = plate(np.indices((4, 4)).sum(axis=0) % 2.0, size=(length, 80.0, 80.0))
        found = [one for one in suggested(*contrast_of(block), WAVE) if one.contrast > 0.9 and one.bed_mm2]
        assert len(found) == ways and all(one.height_mm <= WAVE.printer_profile.reach_max[2] for one in found)


def test_the_present_orientation_is_among_the_few_suggested_however_bad_it_is():
    found = suggested(*contrast_of(plate(np.indices((4, 4)).sum(axis=0) % 2.0, about_x(17.0))), WAVE)
    assert len(found) == CANDIDATES == len({one.up for one in found})
    assert found[-1].up == (0.0, 0.0, 1.0)
    score = [one.score for one in found]
    assert score == sorted(score, reverse=True)


def test_directions_differ_and_turn_upright():
    ups = directions(*contrast_of(plate(np.zeros((2, 2)), about_x(17.0))))
    assert (ups[0] == [0, 0, 1]).all() and len(ups) > 26
    assert np.linalg.norm(ups, axis=1) == pytest.approx(1.0)
    assert (np.triu(ups @ ups.T, 1) < np.cos(np.radians(4.9))).all()
    for up in ups:
        turn = upright(up)
        assert turn @ up == pytest.approx([0, 0, 1], abs=1e-9)
        assert turn @ turn.T == pytest.approx(np.eye(3), abs=1e-9) and np.linalg.det(turn) == pytest.approx(1.0)
