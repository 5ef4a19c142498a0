"""The user's actions, run as scripts run them, and the traces that the extension leaves."""

from types import SimpleNamespace

import pytest

bpy = pytest.importorskip("bpy")

import dualcolor  # noqa: E402
from dualcolor.bridge import results  # noqa: E402
from dualcolor.bridge.properties import report_of  # noqa: E402
from dualcolor.bridge.strands.preview import preview_of  # noqa: E402
from dualcolor.bridge.strands.strand_curves import read_strands  # noqa: E402
from dualcolor.bridge.units import use_millimeters  # noqa: E402
from dualcolor.panels.paint import hints  # noqa: E402
from dualcolor.panels.printing import export_texts  # noqa: E402
from dualcolor.panels.results import duration, figures  # noqa: E402
from dualcolor.panels.rows import wrapped  # noqa: E402
from dualcolor.panels.sidebar import what_is_printed  # noqa: E402
from dualcolor.tests.scene import add_box, datablocks  # noqa: E402


def traces() -> set[str]:
    """Everything of the extension's that Blender knows of."""
    names = {name for name in dir(bpy.types) if "DUALCOLOR" in name.upper()}
    names |= {f"ops.dualcolor.{name}" for name in dir(bpy.ops.dualcolor)}
    names |= {"Object.dualcolor"} if hasattr(bpy.types.Object, "dualcolor") else set()
    names_of_menus = ("TOPBAR_MT_file_export", "TOPBAR_MT_file_import", "VIEW3D_MT_add", "VIEW3D_MT_object")
    names_of_menus += ("VIEW3D_MT_editor_menus", "VIEW3D_MT_edit_mesh_faces")
    menus = [getattr(bpy.types, name) for name in (*names_of_menus, "IMAGE_MT_image")]
    entries = [entry for menu in menus for entry in menu._dyn_ui_initialize()]
    entries += [*bpy.app.handlers.load_pre, *bpy.app.handlers.load_post, *bpy.app.handlers.depsgraph_update_post]
    entries += [*bpy.app.handlers.undo_post, *bpy.app.handlers.redo_post]
    return names | {str(entry) for entry in entries if entry.__module__.startswith("dualcolor")}


@pytest.fixture
def registered(scene):
    dualcolor.register()
    yield scene
    dualcolor.unregister()


def test_painting_modes_have_the_menu_beside_view(registered):
    """There is no menu Object in them, and F3 finds what is in menus."""
    entries = {entry.__name__: entry for entry in bpy.types.VIEW3D_MT_editor_menus._dyn_ui_initialize()}
    drawn = []
    menu = SimpleNamespace(layout=SimpleNamespace(menu=drawn.append))
    for mode in ("OBJECT", "PAINT_TEXTURE", "EDIT_MESH", "PAINT_VERTEX"):
        entries["draw_paint_entry"](menu, SimpleNamespace(mode=mode))
    assert drawn == ["DUALCOLOR_MT_object"] * 2


@pytest.fixture
def block(registered):
    """The active object: a 12 mm block, 3 mm high."""
    use_millimeters(registered)
    bpy.ops.mesh.primitive_cube_add(size=12, location=(40, 30, 20))
    made = bpy.context.object
    made.scale.z = 0.25
    bpy.context.view_layer.update()
    return made


def test_registering_twice_leaves_no_trace_after_unregistering():
    before = traces()
    for _ in range(2):
        dualcolor.register()
        assert traces() - before
        dualcolor.unregister()
        assert traces() == before


def test_without_a_mesh_nothing_can_be_pressed(registered):
    assert not bpy.ops.dualcolor.generate.poll()
    assert not bpy.ops.dualcolor.export_gcode.poll()
    assert not bpy.ops.dualcolor.render_prediction.poll()
    with pytest.raises(RuntimeError, match="Select a mesh object first"):
        bpy.ops.dualcolor.generate()


def test_generate_makes_strands_and_a_report(block):
    assert not bpy.ops.dualcolor.render_prediction.poll()
    assert bpy.ops.dualcolor.generate() == {"FINISHED"}
    report = report_of(block.dualcolor)
    assert report["layers"] == 12 and report["tool_changes"] == 11
    shown = preview_of(block).objects
    layers = {(held.data.materials[0].name, *set(read_strands(held)[3]["layer"] % 2)) for held in shown}
    assert layers == {("Black ABS", 0), ("White ABS", 1)}
    assert bpy.ops.dualcolor.render_prediction.poll()
    assert block.dualcolor.show_print
    block.dualcolor.show_print = False
    assert block.display_type == "TEXTURED"


def test_whose_settings_count_is_said_where_they_differ(block):
    assert what_is_printed(bpy.context) == ["Cube"]
    other = add_box((5, 5, 5), "other")
    other.select_set(True)
    bpy.context.view_layer.objects.active = block
    assert what_is_printed(bpy.context) == ["Cube and 1 more"]
    other.dualcolor.layer_height = 0.2
    assert what_is_printed(bpy.context) == ["Cube and 1 more", "All are printed with the settings of Cube"]


def test_a_first_picture_tells_which_vertex_colors_it_replaces(block, capfd):
    block.data.color_attributes.new("Painted", "BYTE_COLOR", "CORNER")
    block.data.materials.clear()
    bpy.ops.dualcolor.bake_occlusion(samples=1)
    assert "Occlusion, instead of the color attribute Painted" in capfd.readouterr().out
    bpy.ops.dualcolor.set_up_painting()
    assert "instead" not in capfd.readouterr().out
    bpy.ops.object.mode_set(mode="OBJECT")
    block.dualcolor.image = None
    block.data.materials.clear()
    bpy.ops.dualcolor.set_up_painting()
    assert ", instead of the color attribute Painted" in capfd.readouterr().out


def test_an_active_strand_stands_for_its_source(block):
    bpy.ops.dualcolor.generate()
    first = report_of(block.dualcolor)
    bpy.context.view_layer.objects.active = preview_of(block).objects[0]
    block.dualcolor.layer_height = 0.5
    assert bpy.ops.dualcolor.generate() == {"FINISHED"}
    assert report_of(block.dualcolor)["layers"] < first["layers"]
    assert len(bpy.data.collections) == 1


def test_strands_are_seen_in_a_view_of_the_object_alone(registered):
    bpy.ops.wm.read_homefile(use_factory_startup=True)  # with its 3D view
    use_millimeters(bpy.context.scene)
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    region = next(region for region in area.regions if region.type == "WINDOW")
    block, space = bpy.context.object, area.spaces.active
    block.scale, block.dualcolor.perimeters, block.dualcolor.infill_density = (6, 6, 2), 1, 0
    with bpy.context.temp_override(window=window, area=area, region=region):
        bpy.ops.view3d.localview(frame_selected=False)
        if not block.local_view_get(space):
            pytest.skip("this Blender has no such views in background")
        bpy.ops.dualcolor.generate()
        assert all(shown.local_view_get(space) for shown in preview_of(block).objects)
        assert not bpy.data.objects["Light"].local_view_get(space)
        bpy.ops.view3d.localview(frame_selected=False)


def test_a_print_made_again_from_its_strands_makes_the_object_active(block):
    block.dualcolor.perimeters, block.dualcolor.infill_density = 1, 0
    bpy.ops.dualcolor.generate()
    bpy.context.view_layer.objects.active = preview_of(block).objects[0]
    assert not bpy.ops.dualcolor.check_model.poll()
    with pytest.raises(RuntimeError, match="Select Cube, whose strands these are, first"):
        bpy.ops.dualcolor.check_model()
    assert hints(block, bpy.context.object) == ["Strands are selected: select Cube for the buttons that are gray"]
    bpy.ops.dualcolor.generate()
    assert bpy.context.view_layer.objects.active == block and block.select_get()
    assert bpy.ops.dualcolor.check_model.poll()


def test_the_last_message_tells_that_there_are_warnings(block, tmp_path, capfd):
    block.dualcolor.perimeters, block.dualcolor.infill_density = 1, 0
    bpy.ops.dualcolor.generate()
    bpy.ops.dualcolor.export_gcode(filepath=str(tmp_path / "block.gcode"))
    assert len(report_of(block.dualcolor)["warnings"]) == 1  # it has no picture
    said = [line for line in capfd.readouterr().out.splitlines() if "see the results" in line]
    assert " kB; 1 warning" in said[1]
    assert [line.split(":")[:2] for line in said] == [["Warning", " Cube"], ["Info", " block.gcode"]]


def test_a_copy_of_a_printed_object_and_one_whose_strands_were_deleted_look_as_before(block):
    block.dualcolor.perimeters, block.dualcolor.infill_density = 1, 0
    bpy.ops.dualcolor.generate()
    copy = block.copy()
    bpy.context.scene.collection.objects.link(copy)
    assert copy.display_type == "BOUNDS"
    bpy.context.view_layer.update()
    assert copy.display_type == "TEXTURED" and not copy.hide_render
    assert block.display_type == "BOUNDS" and block.hide_render

    for shown in list(preview_of(block).objects):
        bpy.data.objects.remove(shown)
    bpy.context.view_layer.update()
    assert block.display_type == "TEXTURED" and not block.hide_render and not block.dualcolor.show_print
    block.dualcolor.show_print = True
    assert block.display_type == "TEXTURED", "there is nothing to be shown instead"


def test_an_object_linked_from_the_file_of_its_print_is_seen_as_it_is(block, tmp_path):
    block.dualcolor.perimeters, block.dualcolor.infill_density = 1, 0
    bpy.ops.dualcolor.generate()
    printed, other = tmp_path / "printed.blend", tmp_path / "other.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(printed))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    with bpy.data.libraries.load(str(printed), link=True) as (_, wanted):
        wanted.objects = ["Cube"]
    bpy.context.scene.collection.objects.link(wanted.objects[0])
    bpy.context.view_layer.update()
    for _ in range(2):
        linked = bpy.data.objects["Cube"]
        assert linked.library and linked.display_type == "TEXTURED" and not linked.hide_render
        bpy.ops.wm.save_as_mainfile(filepath=str(other))
        bpy.ops.wm.open_mainfile(filepath=str(other))


def test_an_error_is_reported_and_nothing_is_made(block):
    block.dualcolor.wave_depth_min, block.dualcolor.wave_depth_max = 0.5, 0.4
    before = datablocks()
    with pytest.raises(RuntimeError, match="Wave Depth Min"):
        bpy.ops.dualcolor.generate()
    assert datablocks() == before and block.dualcolor.report == ""


def test_an_error_keeps_the_former_print(block):
    bpy.ops.dualcolor.generate()
    before, report = datablocks(), block.dualcolor.report
    block.scale *= 100
    with pytest.raises(RuntimeError):
        bpy.ops.dualcolor.generate()
    assert datablocks() == before and block.dualcolor.report == report


def test_export_writes_what_was_generated_and_makes_it_anew_if_the_object_changed(block, tmp_path, monkeypatch):
    runs = []
    import dualcolor.operators.generate as generate

    original = generate.steps
    monkeypatch.setattr(generate, "steps", lambda *args: (runs.append(1), original(*args))[1])
    bpy.ops.dualcolor.generate()
    bpy.ops.dualcolor.export_gcode(filepath=str(tmp_path / "a.gcode"))
    assert len(runs) == 1
    assert report_of(block.dualcolor)["gcode"]["bytes"] == (tmp_path / "a.gcode").stat().st_size
    block.data.vertices[0].co.z -= 0.5
    bpy.context.view_layer.update()
    bpy.ops.dualcolor.export_gcode(filepath=str(tmp_path / "b.gcode"))
    assert len(runs) == 2
    results.forget_all()
    bpy.ops.dualcolor.export_gcode(filepath=str(tmp_path / "c.gcode"))
    assert len(runs) == 3
    assert (tmp_path / "c.gcode").read_bytes() == (tmp_path / "b.gcode").read_bytes()
    assert (tmp_path / "a.gcode").read_bytes() != (tmp_path / "b.gcode").read_bytes()


def test_a_gcode_file_that_cannot_be_written_is_an_error(block, tmp_path):
    with pytest.raises(RuntimeError, match="cannot be written"):
        bpy.ops.dualcolor.export_gcode(filepath=str(tmp_path / "missing" / "a.gcode"))


def test_the_results_in_the_sidebar():
    report = {
        "bounds_mm": [[-5, -5, 0], [5, 5, 2]],
        "layers": 1408,
        "settings": {"black_tool": 1},
        "time_s": {"total": 3900.0},
        "filament": {"tool0_mm": 1500.0, "tool0_g": 3.75, "tool1_mm": 2500.0, "tool1_g": 6.25},
    }
    assert figures(report) == [
        ("Size", "10.0 × 10.0 × 2.0 mm"),
        ("Layers", "1,408"),
        ("Time", "1 h 05 min"),
        ("White (right)", "1.50 m, 3.8 g"),
        ("Black (left)", "2.50 m, 6.2 g"),
    ]
    report["solid_regions"] = {"regions": 3, "tool_changes": 1, "outline_time_s": -12.0, "tool_change_time_s": 120.0}
    assert figures(report)[-1] == ("Solid Regions", "3: +1 tool changes, +1.8 min")
    assert duration(59 * 60) == "59 min"
    assert all(len(line) <= 34 for line in wrapped("thin walls " * 20, 280, 1.0))
    assert all(len(line) <= 14 for line in wrapped("thin walls " * 20, 172, 1.0))  # the narrowest there is


def test_export_buttons_name_the_printer_and_are_told_apart_in_a_narrow_sidebar():
    system = SimpleNamespace(system=SimpleNamespace(ui_scale=2.0))
    wide, narrow = (SimpleNamespace(region=SimpleNamespace(width=w), preferences=system) for w in (580, 400))
    two = {"x3g": "Export Replicator 2X X3G", "gcode": "Export Replicator 2X G-code"}
    assert export_texts(wide, "replicator_2x") == two
    assert export_texts(narrow, "replicator_2x") == {"x3g": "Export X3G", "gcode": "Export G-code"}
    assert export_texts(wide, "marlin_dual") == {"gcode": "Export Marlin Dual G-code"}


def test_errors_of_all_operators_name_settings_as_the_sidebar_does(block):
    block.dualcolor.wave_depth_min, block.dualcolor.wave_depth_max = 0.7, 0.3
    for action in ("generate", "soft_proof", "add_calibration_tile"):
        with pytest.raises(RuntimeError, match="Wave Depth Min"):
            getattr(bpy.ops.dualcolor, action)()


def test_soft_proof_names_settings_as_the_sidebar_does(block, capfd):
    block.dualcolor.layer_height = 0.3
    bpy.ops.dualcolor.soft_proof()
    assert "Info: The tone table holds for other settings (Layer Height 0.3" in capfd.readouterr().out
