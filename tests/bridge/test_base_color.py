"""What nodes make of a picture between its file and the surface is not printed, and that is said."""

import pytest

bpy = pytest.importorskip("bpy")

from dualcolor.bridge.input.base_color import base_color  # noqa: E402
from dualcolor.panels.paint import hints  # noqa: E402
from dualcolor.tests.scene import add_box, add_material, add_uvs, flat_image, model_of  # noqa: E402


def scaled(mapping):
    mapping.inputs["Scale"].default_value = (3, 3, 1)


def muted(node):
    node.mute = True


BEHIND = [
    ("Mapping", "UV", None, ()),
    ("Mapping", "UV", scaled, ("Mapping",)),
    ("Mapping", "Generated", None, ("Generated coordinates",)),
    ("VectorMath", "UV", None, ("Vector Math",)),
    ("VectorMath", "UV", muted, ()),
]
BEFORE = [
    ("ValToRGB", None, ("Color Ramp",)),
    ("Invert", None, ("Invert Color",)),
    ("Invert", muted, ()),
    ("RGBToBW", None, ()),
]


@pytest.fixture
def painted(registered):
    """A box, its material's node tree, image node and shader."""
    box = add_box((20, 20, 20))
    add_uvs(box)
    _, tree = add_material(box, flat_image((1, 1, 1, 1)))
    picture = next(node for node in tree.nodes if node.type == "TEX_IMAGE")
    return box, tree, picture, next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")


@pytest.mark.parametrize(("kind", "coordinates", "change", "titles"), BEHIND)
def test_coordinates_that_are_not_the_uv_map_are_told_of(painted, kind, coordinates, change, titles):
    box, tree, picture, _ = painted
    between, source = tree.nodes.new(f"ShaderNode{kind}"), tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(source.outputs[coordinates], between.inputs[0])
    tree.links.new(between.outputs[0], picture.inputs["Vector"])
    if change:
        change(between)
    assert base_color(box.data.materials[0]).ignored == titles


def test_projections_are_told_of(painted):
    box, _, picture, _ = painted
    picture.projection = "BOX"
    assert base_color(box.data.materials[0]).ignored == ("Box projection",)


@pytest.mark.parametrize(("kind", "change", "titles"), BEFORE)
def test_nodes_between_the_picture_and_the_shader_are_told_of(painted, kind, change, titles):
    box, tree, picture, shader = painted
    between = tree.nodes.new(f"ShaderNode{kind}")
    into = between.inputs["Color" if "Color" in between.inputs else 0]
    tree.links.new(picture.outputs["Color"], into)
    tree.links.new(between.outputs[0], shader.inputs["Base Color"])
    if change:
        change(between)
    found = base_color(box.data.materials[0])
    assert found.image == picture.image and found.ignored == titles
    notes = model_of(box).notes
    assert len(notes) == bool(titles) and all(titles[0] in note and "picture" in note for note in notes)
    assert any("prints as it is" in hint for hint in hints(box)) == bool(titles)


def test_a_chosen_picture_that_no_material_shows_prints_as_it_is(painted):
    box, tree, picture, shader = painted
    invert = tree.nodes.new("ShaderNodeInvert")
    tree.links.new(picture.outputs["Color"], invert.inputs["Color"])
    tree.links.new(invert.outputs[0], shader.inputs["Base Color"])
    assert model_of(box).notes
    assert not model_of(box, flat_image((0, 0, 0, 1), "other")).notes


def test_colors_made_by_nodes_alone_are_told_of(painted):
    box, tree, _, shader = painted
    checker = tree.nodes.new("ShaderNodeTexChecker")
    tree.links.new(checker.outputs["Color"], shader.inputs["Base Color"])
    model = model_of(box)
    assert not model.textures and "Checker Texture" in model.notes[0]
    box.data.materials[0] = None
    assert not model_of(box).notes
