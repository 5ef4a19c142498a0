"""What would go wrong is found where it was put in, and mended as far as possible."""

from types import SimpleNamespace

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

import bmesh  # noqa: E402
from dualcolor.bridge.analysis.model_check import MEANINGS, TITLES, Findings, check_steps  # noqa: E402
from dualcolor.bridge.properties import findings_of  # noqa: E402
from dualcolor.core.progress import drained  # noqa: E402
from dualcolor.operators.check_model import DUALCOLOR_OT_select_finding  # noqa: E402
from dualcolor.tests.scene import CUBE, CUBE_FACES, add_box, add_mesh  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


def found_on(obj, least_wall_mm=0.8) -> Findings:
    return drained(check_steps(obj, least_wall_mm))


def test_a_box_is_sound():
    assert not any(found_on(add_box((10, 10, 10))).counts().values())


def test_findings_have_titles_that_fit_beside_their_button_and_are_explained():
    kinds = found_on(add_box()).counts().keys()
    assert kinds == TITLES.keys() == MEANINGS.keys()
    assert max(map(len, TITLES.values())) <= 18  # a longer one hides its number
    asked = DUALCOLOR_OT_select_finding.description
    assert all(MEANINGS[kind] in asked(None, SimpleNamespace(kind=kind)) for kind in kinds)


def test_a_missing_face_leaves_four_open_edges():
    box = add_mesh(CUBE * 10, CUBE_FACES[:-1])
    assert len(found_on(box).open_edges) == 4


@pytest.mark.parametrize("turned", [[2], [0, 5]])
def test_faces_turned_round_are_found(turned):
    faces = [face[::-1] if index in turned else face for index, face in enumerate(CUBE_FACES)]
    assert found_on(add_mesh(CUBE * 10, faces)).flipped_faces == turned


def test_a_box_inside_out_is_flipped_all_over():
    assert found_on(add_mesh(CUBE * 10, [face[::-1] for face in CUBE_FACES])).flipped_faces == list(range(6))


def test_two_boxes_through_each_other_cross():
    corners = np.concatenate([CUBE * 10, CUBE * 10 + [5, 4, 3]])
    faces = [*CUBE_FACES, *(tuple(corner + 8 for corner in face) for face in CUBE_FACES)]
    crossing = found_on(add_mesh(corners, faces)).crossing_faces
    assert len(crossing) == 6 and {face < 6 for face in crossing} == {True, False}


def test_a_plate_is_a_thin_wall_by_its_thickness():
    plate = add_box((10, 10, 0.7))
    assert len(found_on(plate, 0.8).thin_faces) == 2
    assert not found_on(plate, 0.6).thin_faces


@pytest.mark.parametrize("turn", [(90, 0, 0), (0, 90, 0), (180, 0, 0), (50, 20, 130)])
@pytest.mark.parametrize("scale", [(1, 1, 1), (-1, 1, 1), (2, -3, 0.5), (-1, -1, -1)])
def test_what_is_found_does_not_depend_on_how_an_object_is_turned_and_mirrored(turn, scale):
    plate = add_box((10, 10, 0.7 / abs(scale[2])))
    turned = add_mesh(CUBE * 10, [face[::-1] if index == 3 else face for index, face in enumerate(CUBE_FACES)])
    for obj in (plate, turned):
        obj.rotation_euler, obj.scale = np.radians(turn), scale
    bpy.context.view_layer.update()
    found = found_on(plate, 0.8)
    assert len(found.thin_faces) == 2 and not found.flipped_faces and not found_on(plate, 0.6).thin_faces
    assert found_on(turned).flipped_faces == [3]


def test_two_cubes_on_one_edge_branch_there():
    corners = np.concatenate([CUBE * 10, CUBE * 10 + [10, 10, 0]])
    faces = [*CUBE_FACES, *(tuple(corner + 8 for corner in face) for face in CUBE_FACES)]
    touching = add_mesh(corners, faces)
    bpy.ops.dualcolor.repair_model()
    assert len(found_on(touching).branching_edges) == 1


def test_check_is_kept_with_the_object_and_findings_can_be_selected():
    box = add_mesh(CUBE * 10, CUBE_FACES[:-1])
    bpy.ops.dualcolor.check_model()
    assert findings_of(box.dualcolor)["open_edges"] == 4
    bpy.ops.dualcolor.select_finding(kind="open_edges")
    assert box.mode == "EDIT"
    work = bmesh.from_edit_mesh(box.data)
    assert sum(edge.select for edge in work.edges) == 4
    bpy.ops.object.mode_set(mode="OBJECT")


def test_repair_makes_a_soup_of_a_box_printable():
    corners = np.concatenate([CUBE[list(face)] for face in CUBE_FACES[:-1]]) * 10
    faces = [tuple(range(4 * index, 4 * index + 4))[:: 1 if index % 2 else -1] for index in range(5)]
    box = add_mesh(corners, faces)
    assert len(found_on(box).open_edges) == 20
    assert bpy.ops.dualcolor.repair_model() == {"FINISHED"}
    assert not any(found_on(box).counts().values())
    assert len(box.data.vertices) == 8 and len(box.data.polygons) == 6
