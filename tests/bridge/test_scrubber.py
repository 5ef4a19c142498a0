"""Hiding strands by layer and feature changes what is seen and nothing that is stored."""

import numpy as np
import pytest
from dualcolor.tests.sample_print import LAYERS, square_print

bpy = pytest.importorskip("bpy")

import dualcolor  # noqa: E402
from dualcolor.bridge.strands.preview import build_preview  # noqa: E402
from dualcolor.bridge.strands.scrubber import KINDS, last_layer, moves_shown, strands_in  # noqa: E402
from dualcolor.bridge.strands.strand_colors import LEGENDS, legend_of  # noqa: E402
from dualcolor.bridge.strands.strand_curves import read_strands  # noqa: E402
from dualcolor.core.paths import Feature  # noqa: E402


@pytest.fixture
def preview(scene):
    dualcolor.register()
    yield build_preview(square_print())
    dualcolor.unregister()


def visible(collection):
    """(layer, feature) of all strands that are seen."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    found = set()
    for held in collection.objects:
        data = held.evaluated_get(depsgraph).data
        columns = []
        for label in ("layer", "feature"):
            values = np.zeros(len(data.curves), dtype=np.int32)
            if label in data.attributes:
                data.attributes[label].data.foreach_get("value", values)
            columns.append(values.tolist())
        found |= set(zip(*columns, strict=True))
    return found


def test_all_is_visible_at_first_without_any_modifier(preview):
    assert last_layer(preview) == LAYERS - 1
    assert visible(preview) == {(n, f) for n in range(LAYERS) for f in (Feature.OUTER_WALL, Feature.TOWER)}
    assert not any(len(held.modifiers) for held in preview.objects)


def test_a_range_of_layers(preview):
    preview.dualcolor_view.layer_from, preview.dualcolor_view.layer_to = 2, 4
    assert {layer for layer, _ in visible(preview)} == {2, 3, 4}
    assert sum(len(read_strands(held)[1]) for held in preview.objects) == 2 * LAYERS
    preview.dualcolor_view.layer_from, preview.dualcolor_view.layer_to = 0, LAYERS - 1
    assert {layer for layer, _ in visible(preview)} == set(range(LAYERS))


def test_kinds_of_features(preview):
    preview.dualcolor_view.show_tower = False
    assert {feature for _, feature in visible(preview)} == {Feature.OUTER_WALL}
    preview.dualcolor_view.show_tower, preview.dualcolor_view.show_walls = True, False
    assert {feature for _, feature in visible(preview)} == {Feature.TOWER}


def test_every_feature_that_is_laid_down_has_a_kind():
    assert sorted(feature for of in KINDS.values() for feature in of) == [f for f in Feature if f > Feature.RETRACT]


def test_new_strands_keep_the_hidden_kinds_and_show_all_layers(preview):
    preview.dualcolor_view.layer_to, preview.dualcolor_view.show_tower = 3, False
    build_preview(square_print())
    assert visible(preview) == {(n, Feature.OUTER_WALL) for n in range(LAYERS)}
    assert len(bpy.data.node_groups) == 1


def test_nodes_that_were_deleted_are_made_again_and_a_group_of_that_name_is_left_alone(preview):
    own = bpy.data.node_groups.new("Shown Strands", "GeometryNodeTree")
    preview.dualcolor_view.layer_to = 3
    bpy.data.node_groups.remove(next(held for held in bpy.data.node_groups if held != own))
    preview.dualcolor_view.layer_to = 2
    assert {layer for layer, _ in visible(preview)} == {0, 1, 2}
    assert not own.nodes and len(bpy.data.node_groups) == 2


def test_colors_of_features_and_back(preview):
    before = [held.data.materials[0] for held in preview.objects]
    preview.dualcolor_view.color_by = "FEATURE"
    assert {held.material_slots[0].material.name for held in preview.objects} == {"Strands by Feature"}
    assert [held.data.materials[0] for held in preview.objects] == before
    preview.dualcolor_view.color_by = "FILAMENT"
    assert [held.material_slots[0].material for held in preview.objects] == before


def points_of_layer(collection, layer):
    """How many points of a layer are seen."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    total = 0
    for held in collection.objects:
        data = held.evaluated_get(depsgraph).data
        if not len(data.curves):
            continue
        layers, start = np.zeros(len(data.curves), dtype=np.int32), np.zeros(len(data.curves) + 1, dtype=np.int32)
        data.attributes["layer"].data.foreach_get("value", layers)
        data.curve_offset_data.foreach_get("value", start)
        total += int(np.diff(start)[layers == layer].sum())
    return total


def test_the_last_layer_move_by_move(preview):
    view = preview.dualcolor_view
    view.layer_to = 3
    assert moves_shown(preview) == (5, 5)
    whole, below = points_of_layer(preview, 3), points_of_layer(preview, 2)
    seen = []
    for share in (100.0, 80.0, 60.0, 20.0):
        view.moves = share
        assert points_of_layer(preview, 2) == below
        seen.append(points_of_layer(preview, 3))
    assert seen[0] == whole and seen == sorted(seen, reverse=True) and len(set(seen)) == 4
    view.moves = 0.0
    assert points_of_layer(preview, 3) == 0
    view.moves = 100.0
    assert points_of_layer(preview, 3) == whole


def test_new_strands_show_all_moves(preview):
    preview.dualcolor_view.moves = 20.0
    build_preview(square_print())
    assert preview.dualcolor_view.moves == 100.0


@pytest.mark.parametrize("color_by", LEGENDS)
def test_every_color_has_a_legend_and_an_attribute(preview, color_by):
    preview.dualcolor_view.color_by = color_by
    for held in preview.objects:
        material = held.material_slots[0].material
        (label,) = [node for node in material.node_tree.nodes if node.type == "ATTRIBUTE"]
        assert label.attribute_name in held.data.attributes
        (ramp,) = [node for node in material.node_tree.nodes if node.type == "VALTORGB"]
        colors = [tuple(stop.color)[:3] for stop in ramp.color_ramp.elements]
        np.testing.assert_allclose(colors, [color for _, color in LEGENDS[color_by].entries], atol=1e-6)
    assert 2 <= len(legend_of(color_by)) <= len(LEGENDS[color_by].entries)


@pytest.mark.parametrize("color_by", ["FEATURE", "TOOL"])
def test_each_number_has_the_color_that_its_legend_says(preview, color_by):
    """The middle of a number's band in the ramp, which begins half a number before the first."""
    preview.dualcolor_view.color_by = color_by
    nodes = strands_in(preview)[0].material_slots[0].material.node_tree.nodes
    scale = next(node for node in nodes if node.type == "MAP_RANGE").inputs
    ramp = next(node for node in nodes if node.type == "VALTORGB").color_ramp
    low, high = scale["From Min"].default_value, scale["From Max"].default_value
    for number, (_, color) in enumerate(LEGENDS[color_by].entries):
        for value in (number - 0.4, number, number + 0.4):
            np.testing.assert_allclose(ramp.evaluate((value - low) / (high - low))[:3], color, atol=1e-6)
