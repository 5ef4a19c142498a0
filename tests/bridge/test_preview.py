"""The preview holds the moves that go into the G-code, as ovals of the extruded area, in the model's place."""

import numpy as np
import pytest
from dualcolor.tests.sample_print import LAYERS, SIDE, STEP, square_print

bpy = pytest.importorskip("bpy")

from dualcolor.bridge.strands.preview import build_preview, is_print_shown, preview_of, show_print, source_of  # noqa: E402
from dualcolor.bridge.strands.strand_curves import read_strands  # noqa: E402
from dualcolor.bridge.units import mm_per_unit, use_millimeters  # noqa: E402
from dualcolor.core.paths import Feature  # noqa: E402
from dualcolor.core.strands.strands import strands  # noqa: E402
from dualcolor.tests.strand_volume import volume_mm3  # noqa: E402


@pytest.fixture
def cube(scene):
    """A block of the sample's size in a scene that counts in mm, turned and away from the origin."""
    use_millimeters(scene)
    bpy.ops.mesh.primitive_cube_add(size=1, location=(30, -20, 5))
    made = bpy.context.object
    made.scale = (SIDE, SIDE, LAYERS * STEP)
    bpy.context.view_layer.update()
    return made


def world_mm(shown, points):
    unit = mm_per_unit(bpy.context.scene)
    bpy.context.view_layer.update()
    matrix = np.array(shown.matrix_world)
    return (points @ matrix[:3, :3].T + matrix[:3, 3]) * unit


def test_one_object_a_filament_with_all_strands(scene):
    result = square_print()
    collection = build_preview(result)
    laid = strands(result.moves)
    assert collection.name == "Cube Dual-Color"
    assert [shown.name for shown in collection.objects] == ["Cube Black", "Cube White"]
    for tool, shown in enumerate(collection.objects):
        points, counts, _, labels = read_strands(shown)
        expected = laid.selected(laid.tool == tool)
        np.testing.assert_allclose(world_mm(shown, points), expected.points, atol=1e-4)
        np.testing.assert_array_equal(counts, np.diff(expected.start))
        np.testing.assert_array_equal(labels["layer"], expected.layer)
        np.testing.assert_array_equal(labels["feature"], expected.feature)
        assert {value.value for value in shown.data.attributes["curve_type"].data} == {1}
        assert shown.data.materials[0].name == ("Black ABS", "White ABS")[tool]


def test_the_black_filament_may_be_in_the_other_tool(scene):
    result = square_print()
    result.settings = result.settings.changed({"black_tool": 1})
    black = build_preview(result).objects["Cube Black"]
    assert set(read_strands(black)[3]["layer"] % 2) == {1}


@pytest.mark.parametrize("scale_length", [0.001, 1.0])
def test_ovals_have_the_extruded_area_in_any_unit(scene, scale_length):
    scene.unit_settings.system, scene.unit_settings.scale_length = "METRIC", scale_length
    result = square_print()
    # A first layer of another height and a line that widens along its way.
    result.moves.height[result.moves.layer == 0] *= 1.4
    result.moves.width[3:5] *= (1.1, 1.3)
    collection = build_preview(result)
    assert len(collection.objects) > 2
    volume = 0.0
    for shown in collection.objects:
        points, counts, radius, _ = read_strands(shown)
        lengths = np.linalg.norm(np.diff(world_mm(shown, points), axis=0), axis=1)
        radius_mm = radius * mm_per_unit(scene)
        areas = np.pi * radius_mm**2 * shown.scale.z
        lengths[np.cumsum(counts)[:-1] - 1] = 0
        volume += float((lengths * areas[1:]).sum())
    assert volume == pytest.approx(volume_mm3(strands(result.moves)).sum(), rel=1e-4)


def test_the_print_stands_where_its_source_stands(cube):
    collection = build_preview(square_print(), cube)
    shown = collection.objects[0]
    points, counts, _, labels = read_strands(shown)
    wall = world_mm(shown, points)[np.repeat(labels["feature"] == Feature.OUTER_WALL, counts)]
    middle = (wall.min(axis=0) + wall.max(axis=0)) / 2
    np.testing.assert_allclose(middle[:2], (30, -20), atol=1e-3)
    assert wall[:, 2].min() == pytest.approx(5 - LAYERS * STEP / 2 + STEP / 2, abs=1e-3)


def test_a_second_preview_replaces_the_first_and_nothing_else(cube):
    first = build_preview(square_print(), cube)
    keepsake = bpy.data.objects.new("Keepsake", None)
    first.objects.link(keepsake)
    cube.name = "Block"
    second = build_preview(square_print(), cube)
    assert second == first and second.name == "Block Dual-Color"
    assert sorted(held.name for held in second.objects) == ["Block Black", "Block White", "Keepsake"]
    assert len(bpy.data.hair_curves) == 2
    assert len(bpy.data.materials) == 2


def test_two_objects_have_a_preview_each(cube):
    twin = cube.copy()
    bpy.context.scene.collection.objects.link(twin)
    assert build_preview(square_print(), cube) != build_preview(square_print(), twin)
    assert len(bpy.data.hair_curves) == 4


def test_the_view_goes_back_and_forth(cube):
    cube.display_type = "SOLID"
    build_preview(square_print(), cube)
    build_preview(square_print(), cube)
    assert is_print_shown(cube) and cube.display_type == "BOUNDS" and cube.hide_render
    show_print(cube, False)
    assert not is_print_shown(cube) and cube.display_type == "SOLID" and not cube.hide_render
    assert preview_of(cube).hide_render


@pytest.mark.parametrize("hidden", ["exclude", "hide_viewport"])
def test_strands_whose_collection_was_hidden_in_the_outliner_are_seen_again(cube, hidden):
    """By its eye or its tick: otherwise nothing but bounds would be left of the object."""
    outer = bpy.data.collections.new("Outer")
    bpy.context.scene.collection.children.link(outer)
    collection = build_preview(square_print(), cube)
    bpy.context.scene.collection.children.unlink(collection)
    outer.children.link(collection)
    for layer in (
        bpy.context.view_layer.layer_collection.children["Outer"],
        bpy.context.view_layer.layer_collection.children["Outer"].children[collection.name],
    ):
        setattr(layer, hidden, True)
        assert not any(strand.visible_get() for strand in collection.objects)
        build_preview(square_print(), cube)
        assert all(strand.visible_get() for strand in collection.objects)
        setattr(layer, hidden, True)
        show_print(cube, False)
        show_print(cube, True)
        bpy.context.view_layer.update()
        assert all(strand.visible_get() for strand in collection.objects)


def test_strands_are_drawn_as_wide_as_they_are_until_the_user_wants_lines(cube):
    render = bpy.context.scene.render
    build_preview(square_print(), cube)
    assert render.hair_type == "STRIP"
    render.hair_type = "STRAND"
    build_preview(square_print(), cube)
    assert render.hair_type == "STRAND"


def test_strands_lead_back_to_their_source(cube):
    collection = build_preview(square_print(), cube)
    assert source_of(collection.objects[0]) == cube
    assert source_of(cube) == cube
    assert source_of(None) is None


def test_an_object_of_two_scenes_has_its_strands_in_both(cube):
    """It is drawn as its bounds in both."""
    other = bpy.data.scenes.new("Other")
    other.collection.objects.link(cube)
    collection = build_preview(square_print(), cube)
    assert all(collection.name in each.collection.children for each in bpy.data.scenes)
    build_preview(square_print(), cube)
    assert [len(each.collection.children) for each in bpy.data.scenes] == [1, 1]


def test_a_print_that_is_read_from_its_file_leaves_the_strands_of_its_object(cube):
    cube.name = square_print().name
    made = build_preview(square_print(), cube)
    strands_before = list(made.objects)
    read = build_preview(square_print())
    assert read != made and list(made.objects) == strands_before
    assert preview_of(cube) == made and source_of(read.objects[0]) == read.objects[0]
    assert build_preview(square_print()) == read
