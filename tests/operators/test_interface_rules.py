"""What holds for every operator, property and panel: words, undo, a reason where something is gray."""

import importlib
import inspect
import pkgutil
from types import SimpleNamespace

import pytest

bpy = pytest.importorskip("bpy")

import dualcolor  # noqa: E402
from dualcolor.tests.scene import fresh  # noqa: E402

HIDDEN = {"filepath", "filter_glob", "check_existing", "rna_type"}
READS_ONLY = {
    "export_settings",  # writes a file
    "export_strands",
    "remove_preset",
    "render_prediction",
    "save_preset",
}
"""Operators that change nothing in the scene, so that there is nothing to undo."""


@pytest.fixture(scope="module")
def classes():
    fresh()
    dualcolor.register()
    from dualcolor.registration import CLASSES

    yield CLASSES
    dualcolor.unregister()


@pytest.fixture(scope="module")
def operators(classes):
    return [each for each in classes if issubclass(each, bpy.types.Operator)]


def test_every_class_made_for_blender_is_registered_and_so_held_to_these_rules(classes):
    kinds = (bpy.types.Operator, bpy.types.Panel, bpy.types.Menu, bpy.types.FileHandler)
    for folder in ("operators", "panels"):
        package = importlib.import_module(f"dualcolor.{folder}")
        for found in pkgutil.iter_modules(package.__path__, f"{package.__name__}."):
            module = importlib.import_module(found.name)
            made = {
                each for each in vars(module).values() if inspect.isclass(each) and each.__module__ == module.__name__
            }
            named = {each for each in made if issubclass(each, kinds) and each.__name__.startswith("DUALCOLOR_")}
            assert named <= set(classes), named - set(classes)


def test_every_operator_has_words_and_an_undo_step(operators):
    for operator in operators:
        assert operator.bl_idname.startswith("dualcolor.") and operator.bl_label, operator
        assert operator.__doc__ and "\n" not in operator.__doc__ and not operator.__doc__.endswith("."), operator
        short = operator.bl_idname.partition(".")[2]
        assert ("UNDO" in getattr(operator, "bl_options", set())) != (short in READS_ONLY), operator


def gives_reason(function) -> bool:
    return "poll_message_set" in inspect.getsource(function)


def test_every_poll_gives_a_reason(operators):
    from dualcolor.operators import polls

    giving = [name for name, each in inspect.getmembers(polls, inspect.isfunction) if gives_reason(each)]
    assert len(giving) >= 4
    for operator in operators:
        poll = next((vars(each)["poll"] for each in operator.__mro__ if "poll" in vars(each)), None)
        if not isinstance(poll, classmethod):
            continue  # it can always be pressed
        text = inspect.getsource(poll.__func__)
        assert gives_reason(poll.__func__) or any(f"{name}(cls, " in text for name in giving), operator


def test_every_property_of_an_operator_has_a_name_and_words(operators):
    for operator in operators:
        module, name = operator.bl_idname.split(".")
        rna = getattr(getattr(bpy.ops, module), name).get_rna_type()
        for made in rna.properties:
            if made.identifier in HIDDEN or made.is_hidden:
                continue
            assert made.name, (operator, made.identifier)
            assert made.description, (operator, made.identifier)


def test_every_property_of_an_object_has_a_name_and_words(classes):
    group = bpy.types.Object.bl_rna.properties["dualcolor"].fixed_type
    for made in group.properties:
        if made.identifier not in ("rna_type", "name"):
            assert made.name and made.description, made.identifier


IN_PLACE = {
    "apply_orientation",  # a row of the suggestions
    "apply_preset",  # menus of their own in the sidebar
    "remove_preset",
    "save_preset",
    "select_finding",  # a row of what the check has found
}


class Menu:
    """Notes the operators that a menu shows, those of menus inside it too."""

    def __init__(self):
        self.layout, self.shown = self, set()

    def operator(self, name, **_):
        self.shown.add(name)
        return SimpleNamespace()

    def operator_menu_enum(self, name, _property):
        self.shown.add(name)

    def menu(self, name, **_):
        getattr(bpy.types, name).draw(self, None)

    def separator(self):
        pass


def test_search_finds_every_operator(operators):
    """F3 looks through the menus."""
    menus = "TOPBAR_MT_file_export", "TOPBAR_MT_file_import", "VIEW3D_MT_add", "VIEW3D_MT_object", "IMAGE_MT_image"
    menu = Menu()
    for name in (*menus, "VIEW3D_MT_edit_mesh_faces"):
        for entry in getattr(bpy.types, name)._dyn_ui_initialize():
            if entry.__module__.startswith("dualcolor"):
                entry(menu, None)
    assert {operator.bl_idname for operator in operators} - menu.shown == {f"dualcolor.{name}" for name in IN_PLACE}


def test_lengths_are_not_rounded_to_other_lengths(operators):
    """Of what has a unit Blender shows `precision` digits: with one, 25.4 mm is 25 mm and a brim of 2.5 mm is 2 mm."""
    group = bpy.types.Object.bl_rna.properties["dualcolor"].fixed_type
    names = [operator.bl_idname.split(".") for operator in operators]
    kinds = [group, *(getattr(getattr(bpy.ops, module), name).get_rna_type() for module, name in names)]
    lengths = [made for kind in kinds for made in kind.properties if getattr(made, "unit", "") == "CAMERA"]
    assert len(lengths) > 50 and {made.precision for made in lengths} == {4}


@pytest.mark.parametrize(("system", "label"), [("NONE", "Layer Height (mm)"), ("METRIC", "Layer Height")])
def test_lengths_say_their_unit_where_blender_does_not(classes, system, label):
    from dualcolor.panels.rows import label_with_unit

    group = bpy.types.Object.bl_rna.properties["dualcolor"].fixed_type
    scene = SimpleNamespace(unit_settings=SimpleNamespace(system=system))
    assert label_with_unit(group.properties["layer_height"], scene) == label
    assert label_with_unit(group.properties["perimeters"], scene) == "Perimeters"


def test_every_panel_is_in_the_tab_and_its_parent_comes_first(classes):
    panels = [each for each in classes if issubclass(each, bpy.types.Panel)]
    seen = set()
    for panel in panels:
        assert panel.bl_category == "Dual Color" and panel.bl_label, panel
        parent = getattr(panel, "bl_parent_id", "")
        assert not parent or parent in seen, panel
        seen.add(panel.__name__)
    tops = [panel for panel in panels if not getattr(panel, "bl_parent_id", "")]
    stages = [panel.bl_label for panel in sorted(tops, key=lambda panel: panel.bl_order)]
    assert stages == ["Dual Color", "Prepare", "Paint", "Pattern", "Print", "Predict", "Calibrate"]
