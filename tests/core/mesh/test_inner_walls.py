"""Walls inside a solid and fins on its outside do not keep it from being printed whole."""

from dataclasses import replace

import numpy as np
import pytest
from dualcolor.core.mesh.inner_walls import inner_walls
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.model import SurfaceModel
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.slices import slices

SETTINGS = PrintSettings()
HALVES = [[0, 0, 0], [10, 0, 0], [20, 0, 0], [0, 8, 0], [10, 8, 0], [20, 8, 0]]
HALVES = np.array(HALVES + [[x, y, 10] for x, y, _ in HALVES], dtype=float)
AROUND = [
    [0, 3, 4, 1], [1, 4, 5, 2], [6, 7, 10, 9], [7, 8, 11, 10], [0, 1, 7, 6], [1, 2, 8, 7], [2, 5, 11, 8],
    [5, 4, 10, 11], [4, 3, 9, 10], [3, 0, 6, 9],
]  # fmt: skip
WALL = [1, 4, 10, 7]


def model(faces, vertices=HALVES):
    corners = np.concatenate(faces)
    start = np.concatenate([[0], np.cumsum([len(face) for face in faces])])
    return SurfaceModel(vertices, start, corners, None, None, np.full(len(faces), -1), (), "halves")


def area(faces, vertices=HALVES):
    found = slices(triangulate(model(faces, vertices), SETTINGS), SETTINGS)
    assert not len(found.open_layers)
    return [region.area for region in found.regions]


@pytest.mark.parametrize("wall", [WALL, WALL[::-1]])
@pytest.mark.parametrize("first", [False, True])
def test_two_halves_that_share_a_wall_are_printed_whole(wall, first):
    """As a Mirror modifier leaves them: one of the two faces at which they meet."""
    faces = [wall, *AROUND] if first else [*AROUND, wall]
    assert area(faces) == pytest.approx([160.0] * 40)


def test_a_fin_is_left_out_and_the_solid_is_printed():
    outside = np.array([[10, -6, 0], [10, -6, 10]], dtype=float)
    fin = [1, 7, 13, 12]
    for faces in ([fin, *AROUND], [*AROUND, fin], [*AROUND, fin[::-1]]):
        assert area(faces, np.concatenate([HALVES, outside])) == pytest.approx([160.0] * 40)


def test_what_is_closed_or_merely_open_keeps_its_faces():
    for faces in (AROUND, AROUND[1:], [*AROUND, WALL, WALL[::-1]]):
        assert not len(inner_walls(triangulate(model(faces), SETTINGS)))


def test_a_wall_stays_where_the_solid_is_open_beside_it():
    """Half a box closed by it is printed rather than nothing."""
    left = [face for face in AROUND if not {2, 5, 8, 11} & set(face)]
    mesh = triangulate(model([*left, WALL]), SETTINGS)
    assert not len(inner_walls(mesh))
    assert area([*left, WALL]) == pytest.approx([80.0] * 40)


def test_faces_are_named_as_they_stand_in_the_mesh():
    mesh = triangulate(model([*AROUND[:4], WALL, *AROUND[4:]]), SETTINGS)
    assert inner_walls(mesh).tolist() == [8, 9]
    turned = replace(mesh, faces=np.roll(mesh.faces, 1, axis=1))
    assert inner_walls(turned).tolist() == [8, 9]
