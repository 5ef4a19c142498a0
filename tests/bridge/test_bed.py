"""How large an object is on the bed, what does not fit, and Scale to Height."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from dualcolor.bridge.bed import bed_origin_mm, bounds_mm, reach_lines, volume_lines, what_does_not_fit  # noqa: E402
from dualcolor.core.settings.printer import printer_profile  # noqa: E402
from dualcolor.operators.size import DUALCOLOR_OT_scale_to_height  # noqa: E402
from dualcolor.tests.scene import add_box  # noqa: E402

PRINTER = printer_profile("replicator_2x")
pytestmark = pytest.mark.usefixtures("registered")


def test_bounds_are_in_the_world_and_in_mm():
    box = add_box((10, 20, 30))
    box.location, box.rotation_euler = (5, 0, 0), (0, 0, math.radians(45))
    bpy.context.view_layer.update()
    low, high = bounds_mm([box])
    assert high - low == pytest.approx([30 / math.sqrt(2)] * 2 + [30], abs=1e-4)
    bpy.context.scene.unit_settings.scale_length = 1.0
    assert bounds_mm([box])[1, 2] == pytest.approx(30_000)


def test_a_turned_ball_is_no_larger_than_it_is():
    bpy.ops.mesh.primitive_uv_sphere_add(radius=10, rotation=(0.5, 0.6, 0.7), segments=64, ring_count=32)
    assert np.ptp(bounds_mm([bpy.context.object]), axis=0) == pytest.approx([20] * 3, abs=0.1)


@pytest.mark.parametrize(
    ("low", "high", "centered", "said"),
    [
        ((0, 0, 0), (210, 146, 150), True, ""),
        ((0, 0, 0), (210, 146, 150), False, "beyond the reach"),
        ((-105, -73, 0), (105, 73, 150), False, ""),
        ((500, 0, 9), (712, 10, 160), True, "X by 2.0 mm, Z by 1.0 mm"),
        ((0, 0, -1), (9, 9, 9), False, "beyond the reach"),
    ],
)
def test_what_does_not_fit_is_said(low, high, centered, said):
    sentence = what_does_not_fit(np.array([low, high], dtype=float), PRINTER, centered)
    assert said in sentence and bool(said) == bool(sentence)


def test_the_bed_lies_under_the_middle_of_what_is_moved_there():
    bounds = np.array([[10.0, 20, 5], [30, 60, 50]])
    assert bed_origin_mm(bounds, True).tolist() == [20, 40, 5]
    assert bed_origin_mm(bounds, False).tolist() == [0, 0, 0]


def test_lines_are_the_printers():
    box = volume_lines(PRINTER)
    assert box.min(axis=0).tolist() == list(PRINTER.reach_min) and box.max(axis=0).tolist() == list(PRINTER.reach_max)
    lengths = np.linalg.norm(box[1::2] - box[::2], axis=1)
    assert sorted(lengths.tolist()) == [146] * 4 + [150] * 4 + [210] * 4
    assert [reach_lines(PRINTER, tool)[:, 0].max() for tool in (0, 1)] == [123, 117]


@pytest.mark.parametrize(("height", "proposed"), [(80, 80), (150, 150), (200, 60), (3, 60)])
def test_scale_to_height_proposes_a_usual_height_for_what_has_none(height, proposed):
    asked = SimpleNamespace(invoke_props_dialog=lambda _: {"RUNNING_MODAL"})
    context = SimpleNamespace(object=add_box((10, 10, height)), scene=bpy.context.scene, window_manager=asked)
    operator = SimpleNamespace()
    assert DUALCOLOR_OT_scale_to_height.invoke(operator, context, None) == {"RUNNING_MODAL"}
    assert operator.height == pytest.approx(proposed) and not operator.scene_in_mm


def test_scale_to_height_in_meters_and_in_mm():
    bpy.context.scene.unit_settings.scale_length = 1.0
    box = add_box((1, 2, 4))
    box.rotation_euler.x = math.radians(90)
    bpy.context.view_layer.update()
    assert bpy.ops.dualcolor.scale_to_height(height=50.0) == {"FINISHED"}
    assert np.ptp(bounds_mm([box]), axis=0) == pytest.approx([25, 100, 50], rel=1e-4)
    assert bpy.ops.dualcolor.scale_to_height(height=20.0, scene_in_mm=True) == {"FINISHED"}
    assert box.dimensions[1] == pytest.approx(20, rel=1e-4)


def test_a_flat_object_cannot_be_scaled_to_a_height():
    bpy.ops.mesh.primitive_plane_add(size=10)
    with pytest.raises(RuntimeError, match="flat"):
        bpy.ops.dualcolor.scale_to_height(height=20.0)


@pytest.mark.parametrize("parented", [False, True])
def test_parts_of_one_thing_are_scaled_together(parented):
    lid, chest = add_box((10, 10, 4), "lid"), add_box((10, 10, 2), "chest")
    lid.location = (5, 0, 2)
    lid.parent = chest if parented else None
    lid.select_set(True)
    bpy.context.view_layer.update()
    assert bpy.ops.dualcolor.scale_to_height(height=60.0, together=True) == {"FINISHED"}
    assert bounds_mm([chest, lid]) == pytest.approx(np.array([[0, 0, 0], [150, 100, 60]]), rel=1e-4)
    assert bounds_mm([chest])[1] == pytest.approx([100, 100, 20], rel=1e-4)
    bpy.ops.dualcolor.scale_to_height(height=10.0)
    assert bounds_mm([lid])[1] == pytest.approx([75, 50, 30] if parented else [150, 100, 60], rel=1e-4)
