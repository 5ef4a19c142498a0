"""What nodes make of a material is printed once it is baked; nothing but the picture and a UV map is left behind."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from dualcolor.bridge.paint.material_bake import material_bake_steps  # noqa: E402
from dualcolor.core.errors import MeshError  # noqa: E402
from dualcolor.core.progress import drained  # noqa: E402
from dualcolor.core.texture.decode import linear_from_srgb  # noqa: E402
from dualcolor.tests.scene import add_box, add_material, add_mesh, add_uvs, flat_image, give_by_nodes, model_of  # noqa: E402

KINDS = ("scenes", "worlds", "objects", "meshes", "materials", "images", "node_groups")
GRAY = (0.2, 0.2, 0.2, 1.0)
SQUARE = [(0, 0, 0), (20, 0, 0), (20, 20, 0), (0, 20, 0)]
pytestmark = pytest.mark.usefixtures("registered")


def counts():
    return {kind: len(getattr(bpy.data, kind)) for kind in KINDS}


def baked(obj, background=0.5):
    """The light (H, W, 3) of the picture, and the note beside it."""
    image, note = drained(material_bake_steps(obj, 0.25, background, "replicator_2x"))
    pixels = np.array(image.pixels[:]).reshape(*image.size, 4)
    return linear_from_srgb(pixels[..., :3]), note


def middle(light):
    side = len(light)
    return light[side // 2, side // 2]


@pytest.fixture
def square():
    """A square of 20 mm that fills its UV map."""
    obj = add_mesh(SQUARE, [(0, 1, 2, 3)])
    add_uvs(obj)
    return obj


def linked(tree, kind, into, outlet=0):
    node = tree.nodes.new(f"ShaderNode{kind}")
    tree.links.new(node.outputs[outlet], into)
    return node


def principled(tree):
    return next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")


def test_nodes_between_the_picture_and_the_shader_are_baked(square):
    _, tree = add_material(square, flat_image((1, 1, 1, 1)))
    picture = next(node for node in tree.nodes if node.type == "TEX_IMAGE")
    invert = linked(tree, "Invert", principled(tree).inputs["Base Color"])
    tree.links.new(picture.outputs["Color"], invert.inputs["Color"])
    before = counts()
    light, note = baked(square)
    assert counts() == before | {"images": before["images"] + 1} and not note
    assert light.max() < 0.01
    assert len(square.data.uv_layers) == 1


def test_colors_made_by_nodes_alone_lie_where_they_are_seen(square):
    """The red of a position's share of the box around it, left to right, as Generated coordinates have it."""
    _, tree = add_material(square)
    linked(tree, "TexCoord", principled(tree).inputs["Base Color"])
    light, _ = baked(square)
    share = (np.arange(len(light)) + 0.5) / len(light)
    np.testing.assert_allclose(light[:, :, 0], np.broadcast_to(share, light.shape[:2]), atol=0.02)
    np.testing.assert_allclose(light[:, :, 1], np.broadcast_to(share[:, None], light.shape[:2]), atol=0.02)


def test_shape_keys_and_modifiers_do_not_move_generated_colors(square):
    expected_tree = add_material(square)[1]
    linked(expected_tree, "TexCoord", principled(expected_tree).inputs["Base Color"])
    expected, _ = baked(square)
    square.shape_key_add(name="Basis")
    key = square.shape_key_add(name="long")
    key.data[1].co.x = key.data[2].co.x = 60.0
    key.value = 1.0
    light, _ = baked(square)
    side = min(len(light), len(expected))
    np.testing.assert_allclose(
        light[:: len(light) // side, :: len(light) // side],
        expected[:: len(expected) // side, :: len(expected) // side],
        atol=0.02,
    )


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("Metallic", 1.0, 0.2),
        ("Alpha", 0.0, 0.7),
        ("Alpha", 0.5, 0.45),
        ("Emission Strength", 0.5, 0.6),
        ("Emission Strength", 9.0, 1.0),
    ],
)
def test_a_shader_shows_its_color_whatever_light_does_to_it(square, name, value, expected):
    _, tree = add_material(square, color=GRAY)
    shader = principled(tree)
    shader.inputs["Emission Color"].default_value = (0.8, 0.8, 0.8, 1.0)
    shader.inputs[name].default_value = value
    light, _ = baked(square, background=0.7)
    np.testing.assert_allclose(middle(light), expected, atol=0.01)


def test_shaders_are_mixed_inside_groups_too(square):
    """Half emission, half what a group makes: transparent by a quarter, diffuse otherwise."""
    _, tree = add_material(square)
    group = bpy.data.node_groups.new("inner", "ShaderNodeTree")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    inner = linked(group, "MixShader", group.nodes.new("NodeGroupOutput").inputs[0])
    inner.inputs[0].default_value = 0.75
    linked(group, "BsdfTransparent", inner.inputs[1])
    linked(group, "BsdfDiffuse", inner.inputs[2]).inputs["Color"].default_value = GRAY
    mix = linked(tree, "MixShader", tree.get_output_node("ALL").inputs["Surface"])
    shining = linked(tree, "Emission", mix.inputs[1])
    shining.inputs["Color"].default_value, shining.inputs["Strength"].default_value = (1, 1, 1, 1), 0.5
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    tree.links.new(node.outputs[0], mix.inputs[2])
    before = counts()
    light, _ = baked(square, background=1.0)
    assert counts() == before | {"images": before["images"] + 1}
    np.testing.assert_allclose(middle(light), 0.5 * 0.5 + 0.5 * (0.25 * 1.0 + 0.75 * 0.2), atol=0.01)


def test_each_material_is_baked_where_it_is_and_none_shows_the_background():
    obj = add_mesh(
        [*SQUARE, (40, 0, 0), (40, 20, 0), (60, 0, 0), (60, 20, 0)], [(0, 1, 2, 3), (1, 4, 5, 2), (4, 6, 7, 5)]
    )
    uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) / (3, 1)
    add_uvs(obj, np.concatenate([uv + np.array([third / 3, 0]) for third in range(3)]))
    add_material(obj, color=GRAY)
    add_material(obj, color=(0.8, 0.8, 0.8, 1.0), shader="ShaderNodeEmission")
    obj.data.materials.append(None)
    obj.data.polygons.foreach_set("material_index", np.arange(3))
    light, _ = baked(obj, background=0.4)
    row = light[len(light) // 2, np.array([1, 3, 5]) * len(light) // 6, 0]
    np.testing.assert_allclose(row, [0.2, 0.8, 0.4], atol=0.01)


def test_a_mesh_without_room_for_every_face_gets_a_uv_map_and_its_pictures_stay_where_they_are():
    """A box each of whose faces shows the whole picture: black below, white above the middle."""
    box = add_box((20, 20, 20))
    add_uvs(box)
    image = flat_image((0, 0, 0, 1), size=64)
    pixels = np.array(image.pixels[:]).reshape(64, 64, 4)
    pixels[32:, :, :3] = 1.0
    image.pixels.foreach_set(pixels.astype(np.float32).ravel())
    add_material(box, image)
    light, note = baked(box)
    assert [layer.name for layer in box.data.uv_layers] == ["UVMap", "Dual-Color"] and not note
    assert box.data.uv_layers.active.name == "Dual-Color" and box.data.uv_layers["UVMap"].active_render
    uv = np.array([tuple(place.vector) for place in box.data.uv_layers["Dual-Color"].uv]).reshape(6, 4, 2)
    assert uv.min() >= 0 and uv.max() <= 1
    side = len(light)
    for corners in uv:
        low, high = corners[:2].mean(axis=0), corners[2:].mean(axis=0)
        for share, expected in ((0.25, 0.0), (0.75, 1.0)):
            column, row = ((low + share * (high - low)) * side).astype(int)
            assert light[row, column, 0] == pytest.approx(expected, abs=0.02)


def test_materials_that_geometry_nodes_give_are_baked(square):
    add_material(square, color=GRAY)
    given = bpy.data.materials.new("given")
    give_by_nodes(square, given)
    before = counts()
    light, _ = baked(square)
    assert counts() == before | {"images": before["images"] + 1}
    np.testing.assert_allclose(middle(light), 0.8, atol=0.01)  # Blender's own gray


def test_what_modifiers_repeat_is_told_of(square):
    add_material(square, color=GRAY)
    square.modifiers.new("Array", "ARRAY").count = 2
    assert "repeat" in baked(square)[1]


@pytest.mark.parametrize("look", ["is_holdout", "is_shadow_catcher", "hide_render"])
def test_how_an_object_takes_part_in_renders_does_not_matter(square, look):
    add_material(square, color=GRAY)
    setattr(square, look, True)
    assert middle(baked(square)[0]) == pytest.approx(GRAY[:3], abs=0.01)


def test_stopped_in_between_nothing_is_left():
    box = add_box((20, 20, 20))
    add_material(box, color=GRAY)
    before = counts()
    job = material_bake_steps(box, 0.25, 0.5, "replicator_2x")
    for _ in range(2):
        next(job)
    job.close()
    assert counts() == before and not box.data.uv_layers


def test_a_mesh_full_of_uv_maps_is_refused(square):
    add_material(square, color=GRAY)
    square.data.uv_layers[0].uv[0].vector = (7, 7)
    for _ in range(7):
        square.data.uv_layers.new()
    before = counts()
    with pytest.raises(MeshError, match=f"{square.name} has no room"):
        baked(square)
    assert counts() == before


def test_the_button_prints_what_is_seen(square):
    assert not bpy.ops.dualcolor.bake_material.poll()
    _, tree = add_material(square)
    linked(tree, "TexNoise", principled(tree).inputs["Base Color"], outlet="Color")
    assert model_of(square).notes
    assert bpy.ops.dualcolor.bake_material() == {"FINISHED"}
    image = square.dualcolor.image
    assert image and image.packed_file
    model = model_of(square, image)
    assert model.textures and not model.notes
    assert np.ptp(np.array(image.pixels[:]).reshape(-1, 4)[:, 0]) > 0.2
