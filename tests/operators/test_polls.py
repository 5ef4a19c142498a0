"""What is gray, and the reason that is given: objects of other files, hidden ones."""

import pytest

bpy = pytest.importorskip("bpy")

from dualcolor.tests.scene import add_box, add_material, add_uvs, flat_image, fresh  # noqa: E402

CHANGING = (
    "set_up_painting", "unwrap_smart", "repair_model", "select_finding", "soft_proof", "gray_from_color",
    "bake_occlusion",
)  # fmt: skip


@pytest.fixture
def linked(registered, tmp_path):
    """The active object: a painted block that is linked from another file."""
    box = add_box((20, 20, 20))
    add_uvs(box)
    image = flat_image((1, 1, 1, 1))
    image.pack()
    add_material(box, image)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    fresh()
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (held, wanted):
        wanted.objects = held.objects
    (box,) = wanted.objects
    bpy.context.collection.objects.link(box)
    bpy.context.view_layer.objects.active = box
    return box


@pytest.mark.parametrize("action", [*CHANGING, "scale_to_height", "apply_preset", "reset_settings", "import_settings"])
def test_what_belongs_to_another_file_is_not_changed(linked, action):
    with pytest.raises(RuntimeError, match="local first"):
        getattr(bpy.ops.dualcolor, action)()


@pytest.mark.parametrize("action", CHANGING)
def test_the_mesh_of_an_override_is_not_changed(linked, action):
    bpy.context.view_layer.objects.active = linked.override_create(remap_local_usages=True)
    with pytest.raises(RuntimeError, match="local first"):
        getattr(bpy.ops.dualcolor, action)()


def test_linked_objects_and_overrides_are_checked_and_printed(linked):
    for _ in range(2):
        assert bpy.ops.dualcolor.check_model() == {"FINISHED"}
        assert bpy.ops.dualcolor.generate() == {"FINISHED"}
        if not bpy.context.object.override_library:
            bpy.context.view_layer.objects.active = linked.override_create(remap_local_usages=True)
    assert bpy.ops.dualcolor.scale_to_height(height=30) == {"FINISHED"}


@pytest.mark.parametrize("action", CHANGING)
def test_hidden_objects_cannot_be_edited(registered, action):
    box = add_box((20, 20, 20))
    add_uvs(box)
    add_material(box, flat_image((1, 1, 1, 1)))
    box.hide_set(True)
    with pytest.raises(RuntimeError, match="Unhide"):
        getattr(bpy.ops.dualcolor, action)()


def test_unwrapping_goes_back_to_the_mode_it_was_called_in(registered):
    add_box((20, 20, 20))
    for mode in ("SCULPT", "OBJECT"):
        bpy.ops.object.mode_set(mode=mode)
        assert bpy.ops.dualcolor.unwrap_smart() == {"FINISHED"}
        assert bpy.context.mode == mode


def test_an_instanced_collection_is_to_be_made_real(registered):
    empty = bpy.data.objects.new("instance", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", bpy.data.collections.new("parts")
    bpy.context.scene.collection.objects.link(empty)
    bpy.context.view_layer.objects.active = empty
    with pytest.raises(RuntimeError, match="Make Instances Real first"):
        bpy.ops.dualcolor.generate()


def test_an_override_has_settings_of_its_own_that_are_saved_and_looks_that_come_back(registered, tmp_path):
    add_box((9, 9, 3)).dualcolor.perimeters = 3
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    fresh()
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (held, wanted):
        wanted.objects = held.objects
    own = wanted.objects[0].override_create()
    bpy.context.collection.objects.link(own)
    bpy.context.view_layer.objects.active = own
    own.dualcolor.layer_height = 0.3
    assert bpy.ops.dualcolor.generate() == {"FINISHED"} and own.display_type == "BOUNDS"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "mine.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "mine.blend"))
    own = next(obj for obj in bpy.data.objects if obj.override_library)
    group = own.dualcolor
    group.show_print = False
    assert own.display_type == "TEXTURED" and not own.hide_render
    assert group.layer_height == pytest.approx(0.3) and group.perimeters == 3


@pytest.mark.parametrize("action", ["generate", "analyze", "export_x3g", "scale_to_height"])
def test_a_part_of_a_metaball_names_the_one_to_select(registered, action):
    for place in (0, 1):
        bpy.ops.object.metaball_add(location=(place, 0, 0))
    with pytest.raises(RuntimeError, match="Select Mball first"):
        getattr(bpy.ops.dualcolor, action)()
    assert not bpy.types.DUALCOLOR_PT_prepare.poll(bpy.context)
    bpy.context.view_layer.objects.active = bpy.data.objects["Mball"]
    assert bpy.types.DUALCOLOR_PT_prepare.poll(bpy.context)
