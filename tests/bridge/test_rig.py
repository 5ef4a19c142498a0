"""Objects that an armature or another object shapes are scaled and turned with it."""

from types import SimpleNamespace

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from dualcolor.bridge.analysis.orientations import keep_orientations, turn  # noqa: E402
from dualcolor.bridge.bed import bounds_mm, scale_to_height  # noqa: E402
from dualcolor.bridge.input.mesh_input import evaluated_mesh, world_vertices  # noqa: E402
from dualcolor.bridge.node_inputs import set_input  # noqa: E402
from dualcolor.bridge.rig import movers  # noqa: E402
from dualcolor.core.analysis.orientation import Orientation  # noqa: E402
from dualcolor.operators.size import DUALCOLOR_OT_scale_to_height  # noqa: E402
from dualcolor.tests.scene import add_box  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


def rigged(child: bool):
    """A tall box whose upper half a bone bends by 40°, and its armature."""
    bpy.context.scene.unit_settings.scale_length = 0.001
    bpy.ops.mesh.primitive_cube_add(size=1, location=(3, 0, 10))
    box = bpy.context.object
    box.scale = 4, 4, 20
    bpy.ops.object.transform_apply()
    bpy.ops.object.armature_add(location=(3, 0, 10))
    rig = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    rig.data.edit_bones[0].tail = (0, 0, 10)
    bpy.ops.object.mode_set(mode="OBJECT")
    group = box.vertex_groups.new(name=rig.data.bones[0].name)
    group.add([vertex.index for vertex in box.data.vertices if vertex.co.z > 0], 1.0, "REPLACE")
    box.modifiers.new("Armature", "ARMATURE").object = rig
    rig.pose.bones[0].rotation_mode = "XYZ"
    rig.pose.bones[0].rotation_euler.x = np.radians(40)
    if child:
        box.parent = rig
        box.matrix_parent_inverse = rig.matrix_world.inverted()
    bpy.context.view_layer.update()
    return box, rig


def shape_of(obj):
    """(V, V) distances between the vertices as they are seen."""
    graph = bpy.context.evaluated_depsgraph_get()
    with evaluated_mesh(obj, graph) as mesh:
        points = world_vertices(mesh, obj.evaluated_get(graph), 1.0)
    return np.linalg.norm(points[:, None] - points, axis=2)


def test_what_the_inputs_of_nodes_name_is_scaled_too_but_no_camera():
    box, camera = add_box((4, 4, 20)), bpy.data.cameras.new("Eye")
    others = [bpy.data.objects.new("Cutter", None), bpy.data.objects.new("Eye", camera)]
    group = bpy.data.node_groups.new("Cut", "GeometryNodeTree")
    modifier = box.modifiers.new("Cut", "NODES")
    modifier.node_group = group
    for kind in ("Geometry", "Object", "Object"):
        group.interface.new_socket(kind, in_out="INPUT", socket_type=f"NodeSocket{kind}")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    group.links.new(group.nodes.new("NodeGroupInput").outputs[0], group.nodes.new("NodeGroupOutput").inputs[0])
    for other, item in zip(others, [item for item in group.interface.items_tree if item.name == "Object"], strict=True):
        bpy.context.collection.objects.link(other)
        set_input(modifier, item.identifier, other)
    others[0].location.z = 10
    bpy.context.view_layer.update()
    assert movers(box) == [box, others[0]]
    scale_to_height([box], 40.0)
    assert others[0].matrix_world.translation.z == pytest.approx(20)


@pytest.mark.parametrize("child", [True, False])
def test_a_posed_mesh_keeps_its_shape_when_it_is_scaled(child):
    box, rig = rigged(child)
    before = shape_of(box)
    assert movers(box) == ([rig] if child else [box, rig])
    factor = scale_to_height([box], 50.0)
    assert np.ptp(bounds_mm([box]), axis=0)[2] == pytest.approx(50, rel=1e-4)
    assert shape_of(box) == pytest.approx(before * factor, rel=1e-4)


@pytest.mark.parametrize("child", [True, False])
def test_a_posed_mesh_keeps_its_shape_when_it_is_turned(child):
    box, _ = rigged(child)
    before, low = shape_of(box), bounds_mm([box])[0, 2]
    keep_orientations(box, [Orientation((1.0, 0.0, 0.0), 1.0, 0.0, 4.0, 1.0, 1.0, 1.0)])
    assert turn(box, 0) == pytest.approx(90)
    assert shape_of(box) == pytest.approx(before, rel=1e-4)
    assert np.ptp(bounds_mm([box]), axis=0)[2] == pytest.approx(4, rel=1e-3)
    assert bounds_mm([box])[0, 2] == pytest.approx(low, abs=1e-3)


def test_what_an_uneven_parent_shears_keeps_its_shape_when_it_is_turned():
    bpy.context.scene.unit_settings.scale_length = 0.001
    parent, box = bpy.data.objects.new("parent", None), add_box((4, 6, 20))
    bpy.context.scene.collection.objects.link(parent)
    box.parent, box.rotation_euler = parent, (0.5, 0.3, 0)
    parent.scale, parent.rotation_euler = (1, 3, 1), (0, 0, 1)
    bpy.context.view_layer.update()
    before, low = shape_of(box), bounds_mm([box])[0, 2]
    for up in np.eye(3).tolist():
        keep_orientations(box, [Orientation(tuple(up), 1.0, 0.0, 4.0, 1.0, 1.0, 1.0)])
        turn(box, 0)
        assert shape_of(box) == pytest.approx(before, rel=1e-4)
        assert bounds_mm([box])[0, 2] == pytest.approx(low, abs=1e-3)


def test_a_size_that_something_else_sets_is_told_of():
    bpy.context.scene.unit_settings.scale_length = 0.001
    bpy.ops.mesh.primitive_cube_add(size=20)
    bpy.context.object.constraints.new("LIMIT_SCALE").use_max_z = True
    bpy.context.object.constraints[0].max_z = 1.0
    told = []
    operator = SimpleNamespace(
        height=50.0, together=False, scene_in_mm=False, report=lambda kind, text: told.append((*kind, text))
    )
    assert DUALCOLOR_OT_scale_to_height.execute(operator, bpy.context) == {"FINISHED"}
    assert told == [("WARNING", "Cube is 20.0 mm high: a constraint, driver or keyframe sets its size")]


def test_an_object_of_its_own_moves_alone():
    bpy.ops.object.empty_add()
    parent = bpy.context.object
    bpy.ops.mesh.primitive_cube_add()
    box = bpy.context.object
    box.parent = parent
    assert movers(box) == [box]
