"""Vertex colors are printed as the material shows them; attributes of other kinds are not, and the panel says so."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from dualcolor.panels.paint import hints  # noqa: E402
from dualcolor.tests.scene import add_box, add_material, model_of  # noqa: E402

COLOR_ATTRIBUTE, ATTRIBUTE = ("VertexColor", "layer_name"), ("Attribute", "attribute_name")


@pytest.fixture
def box(registered):
    """A box with the active color attribute Dark, Light, which is the one to render, and a number Mask."""
    made = add_box((20, 20, 20))
    for name, tone in (("Dark", 0.2), ("Light", 0.7)):
        layer = made.data.color_attributes.new(name, "FLOAT_COLOR", "POINT")
        layer.data.foreach_set("color", np.tile(np.float32([tone, tone, tone, 1.0]), 8))
    made.data.color_attributes.active_color = made.data.color_attributes["Dark"]
    made.data.color_attributes.render_color_index = 1
    made.data.attributes.new("Mask", "FLOAT", "POINT")
    return made


def show(box, kind, name):
    """Have the box show an attribute; the tree and the node."""
    _, tree = add_material(box)
    node = tree.nodes.new(f"ShaderNode{kind[0]}")
    setattr(node, kind[1], name)
    shader = next(each for each in tree.nodes if each.type == "BSDF_PRINCIPLED")
    tree.links.new(node.outputs["Color"], shader.inputs["Base Color"])
    return tree, node


@pytest.mark.parametrize(
    ("kind", "name", "printed", "tone"),
    [
        (None, "", "Dark", 0.2),
        (COLOR_ATTRIBUTE, "", "Light", 0.7),
        (COLOR_ATTRIBUTE, "Light", "Light", 0.7),
        (COLOR_ATTRIBUTE, "Dark", "Dark", 0.2),
        (ATTRIBUTE, "Light", "Light", 0.7),
    ],
)
def test_the_attribute_that_is_seen_is_printed_and_named(box, kind, name, printed, tone):
    if kind:
        show(box, kind, name)
    model = model_of(box)
    np.testing.assert_allclose(model.corner_tone, tone, atol=1e-6)
    assert model.notes == ()
    assert hints(box)[-1] == f"No image: prints the color attribute {printed} (Vertex Paint)"


@pytest.mark.parametrize("name", ["Mask", "Renamed"])
def test_what_is_no_color_attribute_is_told_of(box, name):
    show(box, ATTRIBUTE, name)
    (note,) = model_of(box).notes
    assert note.startswith(f"the attribute {name} of the material is no color attribute") and "Bake Material" in note
    assert note in hints(box)


def test_attributes_of_the_object_are_told_of(box):
    _, node = show(box, ATTRIBUTE, "color")
    node.attribute_type = "OBJECT"
    assert "is made by Attribute" in model_of(box).notes[0]


def test_nodes_that_change_an_unnamed_attribute_are_told_of(box):
    tree, node = show(box, COLOR_ATTRIBUTE, "")
    link = node.outputs["Color"].links[0]
    invert, into = tree.nodes.new("ShaderNodeInvert"), link.to_socket
    tree.links.new(node.outputs["Color"], invert.inputs["Color"])
    tree.links.new(invert.outputs["Color"], into)
    assert model_of(box).notes[0].startswith("the material changes the color attribute Light by Invert")


def test_attributes_that_modifiers_make_are_known_to_the_panel(box):
    group = bpy.data.node_groups.new("Store", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    given, store, result = (
        group.nodes.new(kind) for kind in ("NodeGroupInput", "GeometryNodeStoreNamedAttribute", "NodeGroupOutput")
    )
    store.data_type = "FLOAT_COLOR"
    store.inputs["Name"].default_value = "Made"
    group.links.new(given.outputs[0], store.inputs["Geometry"])
    group.links.new(store.outputs[0], result.inputs[0])
    box.modifiers.new("Store", "NODES").node_group = group
    show(box, COLOR_ATTRIBUTE, "Made")
    assert model_of(box).notes == ()
    assert hints(box)[-1] == "No image: prints the color attribute Made (Vertex Paint)"
