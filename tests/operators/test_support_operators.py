"""Marking faces for supports in Edit Mode, and volumes from collections."""

import bpy

# isort: split
import bmesh  # found only once bpy is there
import dualcolor
import numpy as np
import pytest
from dualcolor.bridge.input.plate import objects_to_print, plate_model
from dualcolor.bridge.properties import report_of
from dualcolor.bridge.results import digest_of
from dualcolor.core.model import SupportMark
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.scene import add_box, fresh, model_of

DOWN = 4  # the face of a box that looks down


@pytest.fixture
def table(scene):
    """The active object: a plate 10 mm above its foot, as one mesh; with the add-on."""
    dualcolor.register()
    fresh()
    foot, plate = add_box((6, 6, 11), "foot"), add_box((30, 6, 3), "plate")
    plate.location = (-12, 0, 10)
    bpy.context.view_layer.update()
    with bpy.context.temp_override(active_object=plate, selected_editable_objects=[plate, foot]):
        bpy.ops.object.join()
    bpy.context.view_layer.objects.active = plate
    plate.select_set(True)
    yield plate
    dualcolor.unregister()


def edit(obj, faces):
    bpy.ops.object.mode_set(mode="EDIT")
    edited = bmesh.from_edit_mesh(obj.data)
    edited.faces.ensure_lookup_table()
    for face in edited.faces:
        face.select_set(face.index in faces)
    bmesh.update_edit_mesh(obj.data)


def selected(obj):
    return [face.index for face in bmesh.from_edit_mesh(obj.data).faces if face.select]


def support_time(obj):
    obj.dualcolor.support_enable = True
    bpy.ops.dualcolor.generate()
    return report_of(obj.dualcolor)["time_s"]["features"].get("support", 0.0)


def test_outside_edit_mode_there_is_nothing_to_mark(table):
    assert not bpy.ops.dualcolor.mark_support.poll() and not bpy.ops.dualcolor.select_support.poll()
    with pytest.raises(RuntimeError, match="Select faces in Edit Mode first"):
        bpy.ops.dualcolor.mark_support(mark="BLOCKER")


def test_marks_come_and_go(table):
    edit(table, {DOWN, 0})
    assert bpy.ops.dualcolor.mark_support(mark="BLOCKER") == {"FINISHED"}
    edit(table, {0})
    assert bpy.ops.dualcolor.mark_support(mark="ENFORCER") == {"FINISHED"}
    assert model_of(table).polygon_support.tolist() == [1, 0, 0, 0, -1, 0, *[0] * 6]
    bpy.ops.dualcolor.select_support(mark="BLOCKER")
    assert selected(table) == [DOWN]
    edit(table, set(range(12)))
    bpy.ops.dualcolor.mark_support(mark="NONE")
    assert model_of(table).polygon_support is None
    edit(table, set())
    assert bpy.ops.dualcolor.mark_support(mark="BLOCKER") == {"CANCELLED"}


def test_marks_go_through_modifiers(table):
    edit(table, {DOWN})
    bpy.ops.dualcolor.mark_support(mark="BLOCKER")
    bpy.ops.object.mode_set(mode="OBJECT")
    modifier = table.modifiers.new("finer", "SUBSURF")
    modifier.subdivision_type, modifier.levels = "SIMPLE", 1
    assert model_of(table).polygon_support.tolist().count(-1) == 4


def test_a_blocked_underside_needs_no_support(table):
    assert support_time(table) > 10
    edit(table, {DOWN})
    bpy.ops.dualcolor.mark_support(mark="BLOCKER")
    bpy.ops.object.mode_set(mode="OBJECT")
    assert support_time(table) == 0


def test_volumes_in_a_collection_block_and_are_not_printed(table):
    usual = support_time(table)
    blocker = add_box((12, 6, 4), "no support here")
    blocker.location = (-12, 0, 8)
    held = bpy.data.collections.new("Blockers")
    held.objects.link(blocker)
    table.dualcolor.support_blockers = held
    bpy.context.view_layer.objects.active = table
    blocker.select_set(True)
    bpy.context.view_layer.update()
    assert objects_to_print(bpy.context) == [table]
    assert 0.2 * usual < support_time(table) < 0.8 * usual
    assert len(report_of(table.dualcolor)["objects"]) == 1


def test_volumes_stand_in_the_world_in_mm(table):
    marker = add_box((1, 2, 3), "marker")
    marker.location, marker.scale = (5, 0, 0), (2, 2, 2)
    bpy.context.view_layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    made = [
        plate_model([table], depsgraph, PrintSettings(), [None], [(marker, mark)])
        for mark in (SupportMark.ENFORCER, SupportMark.BLOCKER)
    ]
    low, high = made[0].volumes[0].vertices.min(axis=0), made[0].volumes[0].vertices.max(axis=0)
    np.testing.assert_allclose([low, high], [[5, 0, 0], [7, 4, 6]], atol=1e-6)
    assert made[0].volumes[0].name == "marker"
    assert digest_of(made[0], PrintSettings()) != digest_of(made[1], PrintSettings())
