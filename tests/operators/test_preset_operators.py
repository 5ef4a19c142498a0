"""Presets as users meet them: the menus, save and remove, reset, export and import of all settings, undo."""

import json
from types import SimpleNamespace

import pytest

bpy = pytest.importorskip("bpy")

import dualcolor  # noqa: E402
from dualcolor.bridge import preset_folder  # noqa: E402
from dualcolor.bridge.properties import to_settings  # noqa: E402
from dualcolor.bridge.units import use_millimeters  # noqa: E402
from dualcolor.cli import main  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.core.settings.presets import KINDS, kind_settings  # noqa: E402
from dualcolor.panels import presets  # noqa: E402
from dualcolor.tests.scene import add_box  # noqa: E402


@pytest.fixture
def block(scene, tmp_path, monkeypatch):
    """An object, and a folder of presets that is not the user's."""
    monkeypatch.setattr(preset_folder, "user_presets", lambda: tmp_path / "presets")
    dualcolor.register()
    use_millimeters(scene)
    yield add_box((12, 12, 3))
    dualcolor.unregister()


class Layout:
    """Notes what a panel draws."""

    def __init__(self, drawn=None):
        self.drawn = [] if drawn is None else drawn
        self.enabled = True

    def nested(self, **_):
        return Layout(self.drawn)

    column = row = split = nested

    def separator(self):
        self.drawn.append("---")

    def label(self, text, icon=""):
        self.drawn.append(text)

    def prop(self, _owner, name):
        self.drawn.append(name)

    def menu(self, name, text="", icon="", translate=True):
        self.drawn.append((name, text))

    def operator(self, name, text="", icon="", translate=True):
        made = SimpleNamespace(idname=name, text=text, icon=icon, layout=self)
        self.drawn.append(made)
        return made


def drawn(panel, obj, width=900):
    layout, region = Layout(), SimpleNamespace(width=width)
    preferences = SimpleNamespace(system=SimpleNamespace(ui_scale=1.0))
    context = SimpleNamespace(object=obj, region=region, preferences=preferences)
    panel.draw(SimpleNamespace(layout=layout), context)
    return layout.drawn


def menus(obj, width=900):
    return {each[0]: each[1] for each in drawn(presets.DUALCOLOR_PT_presets, obj, width) if isinstance(each, tuple)}


def entries(kind, obj):
    menu = next(menu for menu in presets.MENUS if menu.__name__ == f"DUALCOLOR_MT_{kind}_presets")
    return drawn(menu, obj)


def removable(obj):
    found = [
        e for e in drawn(presets.DUALCOLOR_PT_presets, obj) if getattr(e, "idname", "") == "dualcolor.remove_preset"
    ]
    return {each.kind: each.name for each in found if each.layout.enabled}


def test_each_kind_has_a_menu_that_names_what_is_chosen(block):
    assert menus(block)["DUALCOLOR_MT_printer_presets"] == "Replicator 2X"
    assert menus(block)["DUALCOLOR_MT_quality_presets"] == "Standard, 0.25 mm"
    assert len(menus(block)) == len(KINDS) == 4
    block.dualcolor.layer_height = 0.17
    assert menus(block)["DUALCOLOR_MT_quality_presets"] == "Custom"
    for kind in KINDS:
        assert f"DUALCOLOR_MT_{kind}_presets" in menus(block) and hasattr(bpy.types, f"DUALCOLOR_MT_{kind}_presets")
        assert {each.icon for each in entries(kind, block)} <= {"NONE", "CHECKMARK"}
    assert next(e.text for e in entries("pattern", block)) == "Waves, as in the paper"


def test_presets_that_a_row_has_no_room_for_are_counted(block):
    wide, narrow = (menus(block, width)["DUALCOLOR_MT_filament_presets"] for width in (900, 260))
    assert wide.startswith("ABS black + ") and narrow == "ABS black + 1 more"


def test_applying_changes_only_what_the_preset_names(block):
    block.dualcolor.perimeters = 3
    assert bpy.ops.dualcolor.apply_preset(name="fine") == {"FINISHED"}
    assert bpy.ops.dualcolor.apply_preset(name="paper") == {"FINISHED"}
    settings = to_settings(block.dualcolor)
    assert (settings.layer_height, settings.pattern, settings.perimeters) == (0.2, "wave", 3)
    assert menus(block)["DUALCOLOR_MT_quality_presets"] == "Fine, 0.2 mm"
    assert [e.name for e in entries("quality", block) if e.icon == "CHECKMARK"] == ["fine"]
    with pytest.raises(RuntimeError, match="There is no preset named 'none such'"):
        bpy.ops.dualcolor.apply_preset(name="none such")


def test_own_presets_come_and_go(block, tmp_path):
    block.dualcolor.layer_height = 0.3
    assert bpy.ops.dualcolor.save_preset(kind="quality", name="Draft") == {"FINISHED"}
    assert json.loads((tmp_path / "presets/quality/Draft.json").read_text())["settings"]["layer_height"] == 0.3
    assert menus(block)["DUALCOLOR_MT_quality_presets"] == "Draft"
    assert entries("quality", block)[-2:][0] == "---"
    bpy.ops.dualcolor.save_preset(kind="pattern", name="Same as another")
    assert menus(block)["DUALCOLOR_MT_pattern_presets"] == "Same as another"
    bpy.ops.dualcolor.remove_preset(kind="pattern", name="Same as another")
    assert removable(block) == {"quality": "Draft"}
    bpy.ops.dualcolor.reset_settings()
    assert removable(block) == {}
    bpy.ops.dualcolor.apply_preset(name="Draft")
    assert to_settings(block.dualcolor) == PrintSettings(layer_height=0.3)
    with pytest.raises(RuntimeError, match="choose another name"):
        bpy.ops.dualcolor.save_preset(kind="filament", name="Draft")
    assert bpy.ops.dualcolor.remove_preset(kind="quality", name="Draft") == {"FINISHED"}
    assert not (tmp_path / "presets/quality/Draft.json").exists()
    assert block.dualcolor.layer_height == pytest.approx(0.3)
    with pytest.raises(RuntimeError, match="not one of your own presets"):
        bpy.ops.dualcolor.remove_preset(kind="quality", name="fine")


def test_a_broken_file_of_the_users_is_shown_and_does_no_harm(block, tmp_path):
    (tmp_path / "presets/filament").mkdir(parents=True)
    (tmp_path / "presets/filament/odd.json").write_text("{")
    assert [e.icon for e in entries("filament", block) if e != "---" and e.name == "odd"] == ["ERROR"]
    with pytest.raises(RuntimeError, match=r"odd\.json is not JSON"):
        bpy.ops.dualcolor.apply_preset(name="odd")
    (tmp_path / "presets/filament/odd.json").write_text('{"settings": {"nozzle_temperature_0": 900}}')
    with pytest.raises(RuntimeError, match="Nozzle Temperature 0 = 900 is outside"):
        bpy.ops.dualcolor.apply_preset(name="odd")
    assert to_settings(block.dualcolor) == PrintSettings()


def test_what_this_version_does_not_know_is_left_out_and_named(block, tmp_path, capfd):
    (tmp_path / "presets/quality").mkdir(parents=True)
    (tmp_path / "presets/quality/older.json").write_text('{"settings": {"layer_height": 0.2, "zebra_mode": 3}}')
    assert bpy.ops.dualcolor.apply_preset(name="older") == {"FINISHED"}
    assert block.dualcolor.layer_height == pytest.approx(0.2)
    assert (
        "Warning: Preset older; left out, because this version has no such setting: zebra_mode"
        in capfd.readouterr().out
    )


def test_the_dialog_tells_that_a_preset_is_replaced(block):
    draw, text = bpy.types.DUALCOLOR_OT_save_preset.draw, "Replaces your preset of that name"

    def said(name):
        layout = Layout()
        draw(SimpleNamespace(layout=layout, kind="quality", name=name), None)
        return layout.drawn[1:]

    assert said("Draft") == said("fine") == []
    bpy.ops.dualcolor.save_preset(kind="quality", name="Draft")
    assert said("Draft ") == [text] and said("Other") == []


def test_who_removes_a_preset_is_told_which(block):
    told = []
    manager = SimpleNamespace(invoke_confirm=lambda operator, event, title, confirm_text: told.append(title))
    bpy.types.DUALCOLOR_OT_remove_preset.invoke(
        SimpleNamespace(name="Draft"), SimpleNamespace(window_manager=manager), 0
    )
    assert told == ["Remove the preset Draft?"]


def test_reset_gives_every_default(block):
    for name in kind_settings("pattern"):
        if isinstance(getattr(block.dualcolor, name), float):
            setattr(block.dualcolor, name, 0.7)
    block.dualcolor.black_tool = 1
    image = bpy.data.images.new("kept", 4, 4)
    block.dualcolor.image = image
    assert bpy.ops.dualcolor.reset_settings() == {"FINISHED"}
    assert to_settings(block.dualcolor) == PrintSettings()
    assert block.dualcolor.image == image


def test_settings_go_through_a_file(block, tmp_path):
    bpy.ops.dualcolor.apply_preset(name="pla")
    block.dualcolor.brim_width = 3.2
    wanted = to_settings(block.dualcolor)
    path = tmp_path / "settings.json"
    assert bpy.ops.dualcolor.export_settings(filepath=str(path)) == {"FINISHED"}
    bpy.ops.dualcolor.reset_settings()
    assert bpy.ops.dualcolor.import_settings(filepath=str(path)) == {"FINISHED"}
    assert to_settings(block.dualcolor) == wanted
    gcode = tmp_path / "block.gcode"
    bpy.ops.dualcolor.export_gcode(filepath=str(gcode))
    bpy.ops.dualcolor.reset_settings()
    bpy.ops.dualcolor.import_settings(filepath=str(gcode))
    assert to_settings(block.dualcolor) == wanted
    with pytest.raises(RuntimeError, match=r"missing\.json cannot be read"):
        bpy.ops.dualcolor.import_settings(filepath=str(tmp_path / "missing.json"))
    path.write_text('{"layer_hight": 0.2}')
    with pytest.raises(RuntimeError, match="There is no setting named layer_hight"):
        bpy.ops.dualcolor.import_settings(filepath=str(path))
    assert to_settings(block.dualcolor) == wanted


def test_without_an_object_nothing_can_be_pressed(block):
    bpy.context.view_layer.objects.active = None
    for name in (
        "apply_preset",
        "save_preset",
        "remove_preset",
        "reset_settings",
        "import_settings",
        "export_settings",
    ):
        assert not getattr(bpy.ops.dualcolor, name).poll()
    with pytest.raises(RuntimeError, match="Select a mesh object first"):
        bpy.ops.dualcolor.reset_settings()


def test_changes_can_be_undone(block):
    for name in ("apply_preset", "reset_settings", "import_settings"):
        operator = getattr(bpy.types, f"DUALCOLOR_OT_{name}")
        assert "UNDO" in operator.bl_options


def test_the_command_line_knows_own_presets(block, tmp_path, capfd):
    block.dualcolor.layer_height = 0.3
    bpy.ops.dualcolor.save_preset(kind="quality", name="Draft")
    model, saved = tmp_path / "box.obj", tmp_path / "saved.json"
    bpy.ops.wm.obj_export(filepath=str(model), export_materials=False)
    command = ["print", str(model), "--preset", "Draft", "--preset", "replicator_dual", "--save-settings", str(saved)]
    assert main(command) == 0
    values = json.loads(saved.read_text())
    assert (values["layer_height"], values["printer"]) == (0.3, "replicator_dual")
    assert main([*command, "--preset", "Drift"]) == 1
    assert "there is no preset named 'Drift': choose among" in capfd.readouterr().err
