"""Several objects printed together, in Blender and on the command line."""

import json

import bpy
import dualcolor
import numpy as np
import pytest
from dualcolor import cli
from dualcolor.bridge.input.marker_file import open_marker
from dualcolor.bridge.input.mesh_input import surface_model
from dualcolor.bridge.input.model_file import open_model, open_models
from dualcolor.bridge.input.plate import objects_to_print, plate_model
from dualcolor.bridge.properties import report_of
from dualcolor.bridge.strands.preview import companions_of, preview_of
from dualcolor.bridge.strands.strand_curves import read_strands
from dualcolor.core.errors import PrintError
from dualcolor.core.model import SupportMark
from dualcolor.core.paths import Feature
from dualcolor.core.settings import PrintSettings
from dualcolor.tests.scene import add_box, add_material, add_uvs, extent, flat_image, fresh, model_of
from mathutils import Matrix

FAST = ["--set", "layer_height=0.5", "--set", "first_layer_height=0.5"]


@pytest.fixture
def blocks(scene):
    """The active `first`, the selected `second` 20 mm beside it, and an unselected `third`; with the add-on."""
    dualcolor.register()
    fresh()
    made = [add_box((10, 10, 3), name) for name in ("first", "second", "third")]
    for obj, x, selected in zip(made, (100, 130, 160), (True, True, False), strict=True):
        obj.location.x = x
        obj.select_set(selected)
    bpy.context.view_layer.objects.active = made[0]
    bpy.context.view_layer.update()
    yield made
    dualcolor.unregister()


def test_texts_and_thick_curves_are_printed_too_but_no_paths(blocks):
    first, second, _ = blocks
    bpy.ops.object.text_add(location=(100, 30, 0))
    bpy.context.object.data.extrude = 2.0
    bpy.ops.curve.primitive_bezier_circle_add(radius=5, location=(130, 30, 2))
    ring = bpy.context.object
    bpy.ops.object.metaball_add(radius=5, location=(100, 60, 5))
    bpy.ops.object.metaball_add(radius=5, location=(104, 60, 5))
    bpy.context.view_layer.update()
    for obj in (first, second, ring, *(bpy.data.objects[name] for name in ("Text", "Mball"))):
        obj.select_set(True)
    bpy.context.view_layer.objects.active = first
    printed = ["first", "Mball", "Text", "second"]
    assert [obj.name for obj in objects_to_print(bpy.context)] == printed
    ring.data.bevel_depth = 1.5
    assert [obj.name for obj in objects_to_print(bpy.context)] == ["first", ring.name, *printed[1:]]
    first.dualcolor.arrange = True
    assert bpy.ops.dualcolor.generate() == {"FINISHED"}
    assert {row["name"] for row in report_of(first.dualcolor)["objects"]} == {ring.name, *printed}


def walls_mm(collection):
    """Points of the outer walls in the world."""
    found = []
    for shown in collection.objects:
        points, counts, _, labels = read_strands(shown)
        world = points * np.array(shown.scale) + np.array(shown.location)
        found.append(world[np.repeat(labels["feature"] == Feature.OUTER_WALL, counts)])
    return np.concatenate(found)


@pytest.mark.parametrize("arrange", [False, True])
def test_the_active_object_is_printed_with_the_other_selected_ones(blocks, arrange):
    first, second, _ = blocks
    first.dualcolor.arrange = arrange
    assert bpy.ops.dualcolor.generate() == {"FINISHED"}
    report = report_of(first.dualcolor)
    assert report["name"] == "first" and [row["name"] for row in report["objects"]] == ["first", "second"]
    assert not report_of(second.dualcolor)
    bpy.context.view_layer.update()
    wall = walls_mm(preview_of(first))
    inside = (np.abs(wall[:, :2] - (105, 5)) < 5.5).all(axis=1)
    assert inside.sum() > 100, "the strands of the active object stand where it stands"
    there = (np.abs(wall[:, :2] - (135, 5)) < 5.5).all(axis=1)
    assert (there.sum() > 100) != arrange
    assert arrange or (inside | there).all()
    assert [obj.display_type for obj in blocks] == ["BOUNDS", "BOUNDS", "TEXTURED"]
    first.dualcolor.show_print = False
    assert not second.hide_render and second.display_type == "TEXTURED"


def test_strands_stand_for_the_whole_plate(blocks, tmp_path):
    bpy.ops.dualcolor.generate()
    for obj in bpy.context.view_layer.objects:
        obj.select_set(False)
    bpy.context.view_layer.objects.active = preview_of(blocks[0]).objects[0]
    assert objects_to_print(bpy.context) == blocks[:2]
    bpy.ops.dualcolor.export_gcode(filepath=str(tmp_path / "plate.gcode"))
    bpy.context.view_layer.objects.active = blocks[0]
    bpy.ops.dualcolor.generate()
    assert companions_of(blocks[0]) == [] and blocks[1].display_type == "TEXTURED"


def test_an_object_of_two_plates_comes_back_as_it_was(blocks):
    first, second, _ = blocks
    bpy.ops.dualcolor.generate()
    bpy.context.view_layer.objects.active = second
    bpy.ops.dualcolor.generate()
    assert not preview_of(second).hide_viewport and preview_of(first).hide_viewport
    second.dualcolor.show_print = False
    assert [obj.display_type for obj in (first, second)] == ["TEXTURED", "TEXTURED"]


def test_each_object_has_its_own_picture(blocks):
    first, second, _ = blocks
    for obj, gray in ((first, 0.0), (second, 1.0)):
        add_uvs(obj)
        add_material(obj, flat_image((gray, gray, gray, 1), obj.name))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    white = flat_image((1, 1, 1, 1), "white")
    model = plate_model([first, second], depsgraph, PrintSettings(), [None, None])
    assert [image.tone.max() for image in model.textures] == [0, 1]
    chosen = plate_model([first, second], depsgraph, PrintSettings(), [white, None])
    assert [image.tone.max() for image in chosen.textures] == [1, 1]
    alone = plate_model([second], depsgraph, PrintSettings(), [None])
    assert alone.name == "second" and alone.polygon_object is None
    np.testing.assert_array_equal(alone.vertices, surface_model(second, depsgraph, PrintSettings()).vertices)


def box_file(folder, name, size, suffix=".stl"):
    fresh()
    add_box(size, name).select_set(True)
    path = folder / f"{name}{suffix}"
    if suffix == ".stl":
        bpy.ops.wm.stl_export(filepath=str(path), export_selected_objects=True)
    else:
        bpy.ops.export_scene.gltf(filepath=str(path))
    return path


def test_files_are_imported_side_by_side_at_a_millimeter_a_unit(tmp_path):
    paths = [box_file(tmp_path, "one", (10, 20, 5)), box_file(tmp_path, "two", (4, 6, 8), ".glb")]
    alone = [extent(model_of(open_model(path))) for path in paths]
    first, second = open_models([*paths, paths[0]])[:2]
    assert bpy.context.view_layer.objects.active == first and second.select_get()
    np.testing.assert_allclose([extent(model_of(first)), extent(model_of(second))], alone, rtol=1e-5)
    assert [obj.name for obj in open_models(paths)] == ["one", "two"]
    scaled = open_models(paths, height_mm=30)
    np.testing.assert_allclose([extent(model_of(obj))[2] for obj in scaled], 30, rtol=1e-5)


def test_objects_of_a_blend_keep_their_distances_when_scaled(tmp_path):
    fresh()
    add_box((10, 10, 10), "low")
    add_box((10, 10, 10), "high").location = (20, 0, 10)
    path = tmp_path / "pair.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    models = [model_of(obj) for obj in open_models([path], ["low", "high"], height_mm=40)]
    assert [model.vertices[:, 2].max() for model in models] == pytest.approx([20, 40])
    assert models[1].vertices[:, 0].min() == pytest.approx(40)
    with pytest.raises(PrintError, match="cannot be opened beside other files"):
        open_models([path, path])
    stl = box_file(tmp_path, "one", (10, 20, 5))
    with pytest.raises(PrintError, match="--object chooses from a single file"):
        open_models([stl, stl], ["one"])


def test_the_command_line_prints_a_plate(tmp_path, capfd):
    one, two = box_file(tmp_path, "one", (10, 20, 5)), box_file(tmp_path, "two", (8, 8, 8))
    outputs = ["--gcode", str(tmp_path / "p.gcode"), "--report", str(tmp_path / "p.json")]
    assert cli.main(["print", str(one), str(two), str(one), "--arrange", *FAST, *outputs]) == 0
    report = json.loads((tmp_path / "p.json").read_text())
    assert [row["name"] for row in report["objects"]] == ["one", "two", "one.001"]
    assert not any("run into each other" in warning for warning in report["warnings"])
    assert "plate of 3 objects" in capfd.readouterr().out
    assert cli.main(["print", str(one), str(two), *FAST, *outputs]) == 0
    assert any(
        "one and two run into each other" in warning
        for warning in json.loads((tmp_path / "p.json").read_text())["warnings"]
    )


@pytest.mark.parametrize("turn", [0, 180])
@pytest.mark.parametrize("suffix", [".stl", ".blend"])
def test_a_marker_goes_with_its_model(tmp_path, suffix, turn):
    """A table of 14 mm, scaled to 28 mm and turned, whose left half is blocked by a box of its own file or scene."""
    fresh()
    table = add_box((30, 6, 4), "table")
    table.data.transform(Matrix.Translation((0, 0, 10)))
    foot, marker = add_box((6, 6, 10.5), "foot"), add_box((15, 6, 8), "marker")
    foot.location.x, marker.location.z = 12, 8
    bpy.context.view_layer.update()
    with bpy.context.temp_override(active_object=table, selected_editable_objects=[table, foot]):
        bpy.ops.object.join()
    path, names = tmp_path / f"table{suffix}", "marker"
    if suffix == ".blend":
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
    else:
        for obj in (table, marker):
            bpy.ops.object.select_all(action="DESELECT")
            obj.select_set(True)
            bpy.ops.wm.stl_export(filepath=str(tmp_path / f"{obj.name}.stl"), export_selected_objects=True)
        names = str(tmp_path / "marker.stl")
    obj = open_models([path], ["table"] if suffix == ".blend" else [], height_mm=28, rotate_deg=(0, 0, turn))[0]
    held = open_marker(names, obj, rotate_deg=(0, 0, turn))
    assert held.hide_render and bpy.context.view_layer.objects.active == obj
    depsgraph = bpy.context.evaluated_depsgraph_get()
    model = plate_model([obj], depsgraph, PrintSettings(), [None], [(held, SupportMark.BLOCKER)])
    low, high = model.volumes[0].vertices.min(axis=0), model.volumes[0].vertices.max(axis=0)
    expected = [[-30, -12, 16], [0, 0, 32]] if turn else [[0, 0, 16], [30, 12, 32]]
    np.testing.assert_allclose([low, high], expected, atol=1e-4)
    with pytest.raises(PrintError, match="no file nothing and no object"):
        open_marker("nothing", obj)


def test_the_command_line_takes_markers(tmp_path, capfd):
    tall, wide = box_file(tmp_path, "tall", (10, 10, 6)), box_file(tmp_path, "wide", (9, 9, 9))
    outputs = ["--gcode", str(tmp_path / "p.gcode"), "--report", str(tmp_path / "p.json")]
    assert cli.main(["print", str(tall), "--support-blocker", str(wide), *FAST, *outputs]) == 0
    report = json.loads((tmp_path / "p.json").read_text())
    assert len(report["objects"]) == 1
    assert any("do nothing while support_enable is off" in warning for warning in report["warnings"])


def test_a_companion_that_was_deleted_does_no_harm(blocks):
    bpy.ops.dualcolor.generate()
    bpy.data.objects.remove(blocks[1])
    assert companions_of(blocks[0]) == []
    blocks[0].dualcolor.show_print = False
    assert bpy.ops.dualcolor.generate() == {"FINISHED"}
