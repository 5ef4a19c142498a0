"""The paint of a Blender object becomes the job's input: pictures of materials, UV maps, color attributes."""

import bpy
import numpy as np
import pytest
from dualcolor.core.errors import TextureError
from dualcolor.tests.scene import (
    add_box,
    add_material,
    add_uvs,
    flat_image,
    fresh,
    give_by_nodes,
    model_of,
)

GRAY_LINEAR = 0.21404114  # sRGB 0.5, decoded


def test_no_color_at_all_leaves_the_background():
    fresh()
    box = add_box()
    add_material(box, color=(0.9, 0.1, 0.1, 1))
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


def test_the_material_that_geometry_nodes_give_beats_the_slots():
    fresh()
    box = add_box()
    add_uvs(box)
    given, _ = add_material(box, flat_image((1, 1, 1, 1), "white"))
    box.data.materials.clear()
    add_material(box, flat_image((0, 0, 0, 1), "black"))
    give_by_nodes(box, given)
    model = model_of(box)
    assert len(model.textures) == 1 and model.textures[0].tone.min() == 1


@pytest.mark.parametrize("shader", ["BSDF_PRINCIPLED", "ShaderNodeEmission", "ShaderNodeBsdfDiffuse"])
def test_image_of_the_material_is_found(shader):
    fresh()
    box = add_box()
    add_uvs(box)
    add_material(box, flat_image((0.5, 0.5, 0.5, 1)), shader=shader)
    model = model_of(box)
    np.testing.assert_allclose(model.textures[0].tone, GRAY_LINEAR, atol=2e-3)


def test_image_is_found_behind_mix_shaders_and_color_nodes():
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
@pytest.mark.parametrize("grouped", ["color", "shader"])
def test_image_is_found_inside_groups_and_through_them(pictured, grouped):
    fresh()
    box = add_box()
    add_uvs(box)
    add_uvs(box, np.full(2, 0.25), "asked for")
    _, tree = add_material(box, color=(1, 0, 0, 1))
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
    np.testing.assert_allclose(model.textures[0].tone, GRAY_LINEAR, atol=2e-3)
    assert (model.corner_uv == 0.25).all()


def test_each_material_has_its_own_picture_or_color():
    fresh()
    box = add_box()
    add_uvs(box)
    shared = flat_image((1, 1, 1, 1), "shared")
    add_material(box, flat_image((0, 0, 0, 1), "unused"))
    add_material(box, shared)
    add_material(box, color=(0.25, 0.25, 0.25, 1))
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
def test_color_attributes_are_linear_and_blend_by_alpha(kind, domain):
    fresh()
    box = add_box()
    attribute = box.data.color_attributes.new("paint", kind, domain)
    colors = np.zeros((len(attribute.data), 4), dtype=np.float32)
    colors[:, :3], colors[:, 3] = 0.5, 1.0
    colors[0] = (1, 1, 1, 0)
    attribute.data.foreach_set("color_srgb", colors.ravel())
    box.data.color_attributes.active_color = attribute
    tone = model_of(box, background_tone=0.75).corner_tone
    bare = model_of(box).corner_vertex == 0 if domain == "POINT" else np.arange(24) == 0
    np.testing.assert_allclose(tone[bare], 0.75, atol=1e-6)
    np.testing.assert_allclose(tone[~bare], GRAY_LINEAR, atol=3e-3)


def test_image_beats_the_color_attribute():
    fresh()
    box = add_box()
    add_uvs(box)
    attribute = box.data.color_attributes.new("paint", "FLOAT_COLOR", "CORNER")
    box.data.color_attributes.active_color = attribute
    add_material(box, flat_image((1, 1, 1, 1)))
    assert model_of(box).corner_tone is None


def test_colors_that_are_no_numbers_count_as_unpainted():
    fresh()
    box = add_box()
    attribute = box.data.color_attributes.new("paint", "FLOAT_COLOR", "POINT")
    colors = np.ones((8, 4), dtype=np.float32)
    colors[3] = np.nan
    attribute.data.foreach_set("color", colors.ravel())
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
