"""A Blender object becomes the job's input: geometry, units, pictures and colours."""

import bpy
import numpy as np
import pytest
from dualcolor.bridge.plate import plate_model
from dualcolor.core.errors import MeshError, TextureError
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.pipeline import steps
from dualcolor.core.progress import drained
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.scene import (
    add_box,
    add_material,
    add_mesh,
    add_uvs,
    extent,
    flat_image,
    fresh,
    model_of,
    volume,
)

GREY_LINEAR = 0.21404114  # sRGB 0.5, decoded


@pytest.mark.parametrize(
    ("system", "scale", "millimetres"),
    [("METRIC", 1.0, 1000.0), ("METRIC", 0.001, 1.0), ("IMPERIAL", 0.3048, 304.8), ("NONE", 1.0, 1.0)],
)
def test_scene_units_become_millimetres(system, scale, millimetres):
    fresh(millimetres=False)
    units = bpy.context.scene.unit_settings
    units.system, units.scale_length = system, scale
    box = add_box((0.5, 2, 3))
    np.testing.assert_allclose(extent(model_of(box)), np.array([0.5, 2, 3]) * millimetres, rtol=1e-6)


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


def test_no_colour_at_all_leaves_the_background():
    fresh()
    box = add_box()
    add_material(box, colour=(0.9, 0.1, 0.1, 1))
    model = model_of(box)
    assert model.textures == () and model.corner_tone is None and model.corner_uv is None
    assert (model.polygon_texture == -1).all()


def test_chosen_image_beats_the_material():
    fresh()
    box = add_box()
    add_uvs(box)
    add_material(box, flat_image((0, 0, 0, 1), "black"))
    model = model_of(box, image=flat_image((1, 1, 1, 1), "white"))
    assert len(model.textures) == 1 and model.textures[0].tone.min() == 1
    assert (model.polygon_texture == 0).all()


@pytest.mark.parametrize("shader", ["BSDF_PRINCIPLED", "ShaderNodeEmission", "ShaderNodeBsdfDiffuse"])
def test_image_of_the_material_is_found(shader):
    fresh()
    box = add_box()
    add_uvs(box)
    add_material(box, flat_image((0.5, 0.5, 0.5, 1)), shader=shader)
    model = model_of(box)
    np.testing.assert_allclose(model.textures[0].tone, GREY_LINEAR, atol=2e-3)


def test_image_is_found_behind_mix_shaders_and_colour_nodes():
    fresh()
    box = add_box()
    add_uvs(box)
    image = flat_image((1, 1, 1, 1))
    _, tree = add_material(box, image)
    factor = tree.nodes.new("ShaderNodeTexImage")
    factor.image = flat_image((0, 0, 0, 1), "mask")
    picture = next(node for node in tree.nodes if node.type == "TEX_IMAGE" and node.image == image)
    bright = tree.nodes.new("ShaderNodeBrightContrast")
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    tree.links.new(picture.outputs[0], bright.inputs["Color"])
    tree.links.new(bright.outputs[0], shader.inputs["Base Color"])
    mix, glossy = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBsdfGlossy")
    tree.links.new(factor.outputs["Color"], mix.inputs[0])
    tree.links.new(glossy.outputs[0], mix.inputs[1])
    tree.links.new(shader.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], tree.get_output_node("ALL").inputs["Surface"])
    assert model_of(box).textures[0].tone.min() == 1  # the picture, not the mask


@pytest.mark.parametrize("pictured", ["inside", "outside"])
@pytest.mark.parametrize("grouped", ["colour", "shader"])
def test_image_is_found_inside_groups_and_through_them(pictured, grouped):
    fresh()
    box = add_box()
    add_uvs(box)
    add_uvs(box, np.full(2, 0.25), "asked for")
    _, tree = add_material(box, colour=(1, 0, 0, 1))
    group = bpy.data.node_groups.new("group", "ShaderNodeTree")
    group.interface.new_socket("Unused", in_out="INPUT", socket_type="NodeSocketColor")
    group.interface.new_socket("Paint", in_out="INPUT", socket_type="NodeSocketColor")
    group.interface.new_socket("Unused", in_out="OUTPUT", socket_type="NodeSocketShader")
    kind = "NodeSocketShader" if grouped == "shader" else "NodeSocketColor"
    group.interface.new_socket("Out", in_out="OUTPUT", socket_type=kind)
    given, result = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    around = tree.nodes.new("ShaderNodeGroup")
    around.node_tree = group

    home = group if pictured == "inside" else tree
    picture, coordinates = home.nodes.new("ShaderNodeTexImage"), home.nodes.new("ShaderNodeUVMap")
    picture.image, coordinates.uv_map = flat_image((0.5, 0.5, 0.5, 1)), "asked for"
    home.links.new(coordinates.outputs[0], picture.inputs["Vector"])
    if pictured == "outside":
        tree.links.new(picture.outputs[0], around.inputs["Paint"])
    source = picture.outputs[0] if pictured == "inside" else given.outputs["Paint"]
    if grouped == "shader":
        shader = group.nodes.new("ShaderNodeBsdfDiffuse")
        group.links.new(source, shader.inputs["Color"])
        source, target = shader.outputs[0], tree.get_output_node("ALL").inputs["Surface"]
    else:
        target = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED").inputs["Base Color"]
    group.links.new(source, result.inputs["Out"])
    tree.links.new(around.outputs["Out"], target)
    model = model_of(box)
    np.testing.assert_allclose(model.textures[0].tone, GREY_LINEAR, atol=2e-3)
    assert (model.corner_uv == 0.25).all()


def test_each_material_has_its_own_picture_or_colour():
    fresh()
    box = add_box()
    add_uvs(box)
    shared = flat_image((1, 1, 1, 1), "shared")
    add_material(box, flat_image((0, 0, 0, 1), "unused"))
    add_material(box, shared)
    add_material(box, colour=(0.25, 0.25, 0.25, 1))
    add_material(box, flat_image((0, 0, 0, 1), "black"))
    add_material(box, shared)
    box.data.polygons.foreach_set("material_index", [1, 2, 3, 4, 1, 1])
    box.data.color_attributes.active_color = box.data.color_attributes.new("leftover", "FLOAT_COLOR", "CORNER")
    model = model_of(box)
    assert [image.tone.max() for image in model.textures] == [1, 0]
    assert model.polygon_texture.tolist() == [0, -1, 1, 0, 0, 0]
    plain = np.repeat(np.arange(6), 4) == 1
    np.testing.assert_allclose(model.corner_tone[plain], 0.25, atol=1e-6)
    assert np.isnan(model.corner_tone[~plain]).all()


def test_a_picture_lies_as_it_is_seen_whichever_uv_map_is_active():
    fresh()
    box = add_box()
    add_uvs(box, np.full(2, 0.25), "rendered").active_render = True
    add_uvs(box, np.full(2, 0.75), "active").active = True
    shown, other = flat_image((0.5, 0.5, 0.5, 1), "shown"), flat_image((0.5, 0.5, 0.5, 1), "other")
    add_material(box, shown)
    assert (model_of(box).corner_uv == 0.25).all()
    assert (model_of(box, image=shown).corner_uv == 0.25).all()
    assert (model_of(box, image=other).corner_uv == 0.75).all(), "seen nowhere; strokes go by the active one"


def test_a_picture_can_ask_for_its_own_uv_map():
    fresh()
    box = add_box()
    add_uvs(box, np.array([0.25, 0.75]), "old")
    _, tree = add_material(box, flat_image((1, 1, 1, 1)))
    node = tree.nodes.new("ShaderNodeUVMap")
    node.uv_map = "old"
    picture = next(each for each in tree.nodes if each.type == "TEX_IMAGE")
    tree.links.new(node.outputs[0], picture.inputs["Vector"])
    add_uvs(box, np.array([0.5, 0.5]), "new").active = True
    np.testing.assert_allclose(model_of(box).corner_uv, np.tile([0.25, 0.75], (24, 1)), atol=1e-6)
    chosen = model_of(box, image=flat_image((0, 0, 0, 1), "chosen"))
    np.testing.assert_allclose(chosen.corner_uv, np.tile([0.5, 0.5], (24, 1)), atol=1e-6)


@pytest.mark.parametrize("kind", ["FLOAT_COLOR", "BYTE_COLOR"])
@pytest.mark.parametrize("domain", ["POINT", "CORNER"])
def test_colour_attributes_are_linear_and_blend_by_alpha(kind, domain):
    fresh()
    box = add_box()
    attribute = box.data.color_attributes.new("paint", kind, domain)
    colours = np.zeros((len(attribute.data), 4), dtype=np.float32)
    colours[:, :3], colours[:, 3] = 0.5, 1.0
    colours[0] = (1, 1, 1, 0)
    attribute.data.foreach_set("color_srgb", colours.ravel())
    box.data.color_attributes.active_color = attribute
    tone = model_of(box, background_tone=0.75).corner_tone
    bare = model_of(box).corner_vertex == 0 if domain == "POINT" else np.arange(24) == 0
    np.testing.assert_allclose(tone[bare], 0.75, atol=1e-6)
    np.testing.assert_allclose(tone[~bare], GREY_LINEAR, atol=3e-3)


def test_image_beats_the_colour_attribute():
    fresh()
    box = add_box()
    add_uvs(box)
    attribute = box.data.color_attributes.new("paint", "FLOAT_COLOR", "CORNER")
    box.data.color_attributes.active_color = attribute
    add_material(box, flat_image((1, 1, 1, 1)))
    assert model_of(box).corner_tone is None


def test_colours_that_are_no_numbers_count_as_unpainted():
    fresh()
    box = add_box()
    attribute = box.data.color_attributes.new("paint", "FLOAT_COLOR", "POINT")
    colours = np.ones((8, 4), dtype=np.float32)
    colours[3] = np.nan
    attribute.data.foreach_set("color", colours.ravel())
    box.data.color_attributes.active_color = attribute
    model = model_of(box, background_tone=0.25)
    np.testing.assert_allclose(model.corner_tone, np.where(model.corner_vertex == 3, 0.25, 1.0))


def test_no_uvs_for_a_picture_is_said():
    fresh()
    box = add_box()
    with pytest.raises(TextureError, match=r"box has no UV map for the image picture.*unwrap"):
        model_of(box, image=flat_image((1, 1, 1, 1)))
    add_material(box, flat_image((1, 1, 1, 1), "own"))
    with pytest.raises(TextureError, match="box has no UV map for the image own"):
        model_of(box)


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
