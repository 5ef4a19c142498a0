"""The shape of a Blender object becomes the job's input: units, transforms, modifiers, instances."""

import bpy
import numpy as np
import pytest
from dualcolor.bridge.input.plate import plate_model
from dualcolor.core.errors import MeshError
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.pipeline import steps
from dualcolor.core.progress import drained
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.scene import (
    add_box,
    add_mesh,
    add_uvs,
    extent,
    fresh,
    model_of,
    volume,
)


@pytest.mark.parametrize(
    ("system", "scale", "millimeters"),
    [("METRIC", 1.0, 1000.0), ("METRIC", 0.001, 1.0), ("IMPERIAL", 0.3048, 304.8), ("NONE", 1.0, 1.0)],
)
def test_scene_units_become_millimeters(system, scale, millimeters):
    fresh(millimeters=False)
    units = bpy.context.scene.unit_settings
    units.system, units.scale_length = system, scale
    box = add_box((0.5, 2, 3))
    np.testing.assert_allclose(extent(model_of(box)), np.array([0.5, 2, 3]) * millimeters, rtol=1e-6)


def test_world_transform_with_parent_is_applied():
    fresh()
    box, parent = add_box((10, 20, 30)), bpy.data.objects.new("parent", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.location, parent.scale = (100, 0, 0), (2, 2, 2)
    box.parent, box.rotation_euler = parent, (0, np.pi / 2, 0)
    bpy.context.view_layer.update()
    model = model_of(box)
    np.testing.assert_allclose(extent(model), [60, 40, 20], atol=1e-4)
    np.testing.assert_allclose(model.vertices.min(axis=0), [100, 0, -20], atol=1e-4)
    assert volume(model) == pytest.approx(8 * 6000, rel=1e-5)


@pytest.mark.parametrize("scale", [(-1, 1, 1), (1, 1, -2), (-1, -1, -1), (-1, -1, 1)])
def test_mirrored_objects_still_face_outward(scale):
    fresh()
    box = add_box((10, 10, 10))
    uv = np.random.default_rng(1).random((24, 2)).astype(np.float32)
    add_uvs(box, uv)
    before = model_of(box)
    box.scale = scale
    bpy.context.view_layer.update()
    model = model_of(box)
    assert volume(model) == pytest.approx(1000 * abs(np.prod(scale)), rel=1e-5)
    at = {(int(v), *np.round(uv, 5)) for v, uv in zip(before.corner_vertex, before.corner_uv, strict=True)}
    assert at == {(int(v), *np.round(uv, 5)) for v, uv in zip(model.corner_vertex, model.corner_uv, strict=True)}


def test_modifiers_and_shape_keys_are_evaluated():
    fresh()
    box = add_box((10, 10, 10))
    array = box.modifiers.new("Array", "ARRAY")
    array.count = 3
    box.shape_key_add(name="Basis")
    tall = box.shape_key_add(name="tall")
    for point in tall.data:
        point.co.z *= 2
    tall.value = 0.5
    bpy.context.view_layer.update()
    model = model_of(box)
    assert len(model.polygon_start) == 3 * 6 + 1
    np.testing.assert_allclose(extent(model), [30, 10, 15], atol=1e-5)


def test_instances_are_said_not_to_be_printed():
    fresh()
    box, other = add_box((10, 10, 10)), add_box((2, 2, 2), "other")
    assert model_of(box).notes == ()
    group = bpy.data.node_groups.new("cubes", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    given, result, on_points, cube, joined = (
        group.nodes.new(kind)
        for kind in ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeInstanceOnPoints", "GeometryNodeMeshCube",
                     "GeometryNodeJoinGeometry")
    )  # fmt: skip
    ends = [(given, on_points.inputs["Points"]), (cube, on_points.inputs["Instance"]), (joined, result.inputs[0])]
    for source, target in (*ends, (given, joined.inputs[0]), (on_points, joined.inputs[0])):
        group.links.new(source.outputs[0], target)
    box.modifiers.new("Cubes", "NODES").node_group = group
    bpy.context.view_layer.update()
    assert len(model_of(box).vertices) == 8
    depsgraph = bpy.context.evaluated_depsgraph_get()
    both = plate_model([box, other], depsgraph, PrintSettings(), [None, None])
    assert both.notes == ("instances on box are not printed: use Geometry Nodes' Realize Instances",)
    assert both.notes[0] in drained(steps(both, PrintSettings(arrange=True, infill_density=0))).report["warnings"]
    box.modifiers.clear()
    other.parent, box.instance_type = box, "FACES"
    assert model_of(box).notes == ("instances on box are not printed: use Object > Apply > Make Instances Real",)


def test_edit_mode_is_read_as_it_looks():
    fresh()
    box = add_box((10, 10, 10))
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.transform.resize(value=(2, 1, 1))
    model = model_of(box)
    bpy.ops.object.mode_set(mode="OBJECT")
    np.testing.assert_allclose(extent(model), [20, 10, 10], atol=1e-5)


def test_polygons_stay_polygons_and_carry_the_active_uvs():
    fresh()
    box = add_box()
    add_uvs(box, np.zeros(2), "other")
    layer = add_uvs(box, np.arange(48).reshape(24, 2) / 48, "chosen")
    layer.active = True
    model = model_of(box)
    assert np.diff(model.polygon_start).tolist() == [4] * 6
    np.testing.assert_allclose(model.corner_uv, np.arange(48).reshape(24, 2) / 48, atol=1e-7)


def test_objects_without_faces_are_refused():
    fresh()
    with pytest.raises(MeshError, match="thing has no faces"):
        model_of(add_mesh([[0, 0, 0], [1, 0, 0]], []))
    empty = bpy.data.objects.new("marker", None)
    bpy.context.scene.collection.objects.link(empty)
    with pytest.raises(MeshError, match="marker has no surface"):
        model_of(empty)


def test_coordinates_that_are_not_finite_are_refused():
    fresh()
    box = add_box((10, 10, 10))
    box.data.vertices[2].co.x = float("nan")
    box.data.update()
    with pytest.raises(MeshError, match="not finite"):
        triangulate(model_of(box), PrintSettings())


def test_curves_and_text_have_a_surface_too():
    fresh()
    bpy.ops.object.text_add()
    text = bpy.context.object
    text.data.extrude = 0.5
    assert len(model_of(text).polygon_start) > 10


def test_a_curve_without_width_is_told_what_gives_it_a_surface():
    fresh()
    bpy.ops.curve.primitive_bezier_circle_add()
    with pytest.raises(MeshError, match=r"has no faces: give the curve an Extrude or a Bevel"):
        model_of(bpy.context.object)


def test_parts_of_a_metaball_name_the_one_that_has_the_surface():
    fresh()
    for place in (0, 1):
        bpy.ops.object.metaball_add(location=(place, 0, 0))
    part, whole = bpy.context.object, bpy.data.objects["Mball"]
    bpy.context.view_layer.update()
    assert len(model_of(whole).polygon_start) > 10 and part != whole
    with pytest.raises(MeshError, match=r"Mball\.001 is a part of the metaball Mball: choose that one"):
        model_of(part)


@pytest.mark.parametrize("held", ["object", "collection"])
def test_what_is_disabled_in_viewports_is_refused_since_blender_leaves_it_out(held):
    fresh()
    obj, collection = add_box(), bpy.data.collections.new("Off")
    bpy.context.scene.collection.children.link(collection)
    collection.objects.link(obj)
    bpy.context.scene.collection.objects.unlink(obj)
    (obj if held == "object" else collection).hide_viewport = True
    bpy.context.view_layer.update()
    with pytest.raises(MeshError, match="disabled in viewports"):
        model_of(obj)
    bpy.context.view_layer.layer_collection.children["Off"].exclude = True
    with pytest.raises(MeshError, match="box is in an excluded collection: check the box"):
        model_of(obj)
    bpy.context.scene.collection.children.unlink(collection)
    with pytest.raises(MeshError, match="box is not in this scene"):
        model_of(obj)


def test_what_is_being_sculpted_is_refused_since_its_strokes_are_not_in_the_mesh_yet():
    fresh()
    obj = add_box()
    obj.modifiers.new("Detail", "MULTIRES")
    bpy.ops.object.multires_subdivide(modifier="Detail")
    bpy.ops.object.mode_set(mode="SCULPT")
    with pytest.raises(MeshError, match="Sculpt Mode"):
        model_of(obj)
    bpy.ops.object.mode_set(mode="OBJECT")
    assert len(model_of(obj).vertices) == 26
