"""The soft proof follows the object's settings, and leaves the object as it was."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

import dualcolor  # noqa: E402
from dualcolor.bridge.proof.soft_proof import is_proofed, proof_notes  # noqa: E402
from dualcolor.bridge.properties import to_settings  # noqa: E402
from dualcolor.core.analysis.soft_proof import proof_table, tone_range  # noqa: E402
from dualcolor.tests.scene import add_box, add_material, add_uvs, flat_image, model_of  # noqa: E402

KINDS = ("materials", "images", "node_groups", "objects", "meshes", "scenes")


def looks(obj):
    """All that the proof could have changed."""
    slots = []
    for slot in obj.material_slots:
        link = slot.link
        slot.link = "OBJECT"
        slots.append((link, slot.material))
        slot.link = link
    trees = [
        (tuple(map(repr, material.node_tree.nodes)), len(material.node_tree.links))
        for material in obj.data.materials
        if material
    ]
    attributes = [(each.name, each.data_type, each.domain) for each in obj.data.attributes]
    names = [sorted(each.name for each in getattr(bpy.data, kind)) for kind in KINDS]
    keys = sorted(set(obj.keys()) - {"dualcolor"}), sorted(obj.data.keys())  # before Blender 5 settings are a key too
    return slots, list(obj.data.materials), trees, attributes, names, keys


def dressed(kind):
    box = add_box((20, 20, 20))
    add_uvs(box)
    if kind == "bare":
        return box
    image = flat_image((0.2, 0.2, 0.2, 1))
    own, _ = add_material(box, image)
    if kind == "several":
        add_material(box, color=(0.5, 0.1, 0.1, 1))
        box.data.materials.append(None)
        box.data.polygons.foreach_set("material_index", np.arange(6) % 3)
    if kind in ("of the object", "hidden on the object"):
        other = own.copy()
        box.material_slots[0].link = "OBJECT"
        box.material_slots[0].material = other
    if kind == "hidden on the object":
        box.material_slots[0].link = "DATA"
    if kind == "chosen":
        box.dualcolor.image = flat_image((0.9, 0.9, 0.9, 1), "chosen")
    return box


@pytest.mark.parametrize("kind", ["bare", "one", "several", "of the object", "hidden on the object", "chosen"])
def test_afterwards_all_is_as_it_was(registered, kind):
    box = dressed(kind)
    before, printed = looks(box), model_of(box, box.dualcolor.image)
    assert bpy.ops.dualcolor.soft_proof() == {"FINISHED"}
    assert is_proofed(box)
    meanwhile = model_of(box, box.dualcolor.image)
    assert len(meanwhile.textures) == len(printed.textures)
    np.testing.assert_array_equal(meanwhile.polygon_texture, printed.polygon_texture)
    assert bpy.ops.dualcolor.soft_proof() == {"FINISHED"}
    assert not is_proofed(box) and looks(box) == before


def test_objects_with_the_same_mesh_keep_their_looks(registered):
    box = dressed("bare")
    twin = bpy.data.objects.new("twin", box.data)
    bpy.context.scene.collection.objects.link(twin)
    bpy.ops.dualcolor.soft_proof()
    assert is_proofed(box) and not is_proofed(twin)
    bpy.context.view_layer.objects.active = twin
    bpy.ops.dualcolor.soft_proof()
    bpy.context.view_layer.objects.active = box
    bpy.ops.dualcolor.soft_proof()
    assert is_proofed(twin) and not is_proofed(box)
    bpy.context.view_layer.objects.active = twin
    bpy.ops.dualcolor.soft_proof()
    assert not box.data.materials and not bpy.data.materials


def test_copies_of_a_proofed_object_are_freed_one_by_one(registered):
    box = dressed("of the object")
    own = box.material_slots[0].material
    bpy.ops.dualcolor.soft_proof()
    copy = box.copy()
    bpy.context.scene.collection.objects.link(copy)
    bpy.ops.dualcolor.soft_proof()
    assert is_proofed(copy) and box.material_slots[0].material == own
    bpy.context.view_layer.objects.active = copy
    bpy.ops.dualcolor.soft_proof()
    assert copy.material_slots[0].material == own and len(bpy.data.images) == 1


def test_a_file_that_was_saved_meanwhile_opens_with_all_in_it(registered, tmp_path):
    box = dressed("of the object")
    own = box.material_slots[0].material.name
    own_of_mesh = box.data.materials[0].name
    bpy.ops.dualcolor.soft_proof()
    table = proof_table(to_settings(box.dualcolor), tone_range(model_of(box), to_settings(box.dualcolor)))
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "proofed.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "proofed.blend"))
    box = bpy.data.objects["box"]
    assert is_proofed(box) and box.data.materials[0].name == own_of_mesh
    image = bpy.data.images["box Soft Proof"]
    pixels = np.array(image.pixels[:]).reshape(*table.reflectance.shape, 4)[..., 0]
    np.testing.assert_allclose(pixels, table.reflectance, atol=1e-5)
    bpy.context.view_layer.objects.active = box
    bpy.ops.dualcolor.soft_proof()
    assert box.material_slots[0].material.name == own and box.material_slots[0].link == "OBJECT"
    assert "box Soft Proof" not in bpy.data.images and "box Soft Proof" not in bpy.data.materials


def test_removing_the_extension_removes_the_proof(registered):
    box = dressed("several")
    before = looks(box)
    bpy.ops.dualcolor.soft_proof()
    dualcolor.unregister()
    after = looks(box)
    dualcolor.register()
    assert after == before


def test_settings_and_picture_are_followed(registered):
    box = dressed("one")
    bpy.ops.dualcolor.soft_proof()
    proof = box.material_slots[0].material
    response = proof.node_tree.nodes["Response"].image

    def table():
        return np.array(response.pixels[:])[::4]

    first = table()
    box.dualcolor.gamut_mapping = "clip"
    assert np.abs(table() - first).max() > 0.01
    box.dualcolor.pattern = "wave_offset"
    assert proof.node_tree.nodes["Across"].outputs[0].default_value == pytest.approx(box.dualcolor.wavelength)
    box.dualcolor.calibration, box.dualcolor.calibration_file = "file", "/nothing.json"
    assert "cannot be read" in proof_notes(box)[0]
    box.dualcolor.calibration = "slope_aware"
    assert not any("cannot be read" in note for note in proof_notes(box))
    box.dualcolor.image = flat_image((1, 1, 1, 1), "other")
    shown = box.material_slots[0].material.node_tree.nodes.active
    assert shown.image.name == "other"  # strokes go there, not to the table


def test_settings_that_are_undone_and_redone_are_followed(registered):
    dressed("one")
    bpy.ops.ed.undo_push(message="a box")
    bpy.ops.dualcolor.soft_proof("EXEC_DEFAULT", True)

    def table():
        return np.array(bpy.data.images["box Soft Proof"].pixels[:])[::4]

    first = table()
    bpy.ops.dualcolor.apply_preset("EXEC_DEFAULT", True, name="paper")
    second = table()
    assert second.shape != first.shape or np.abs(second - first).max() > 0.01
    bpy.ops.ed.undo()
    np.testing.assert_array_equal(table(), first)
    bpy.ops.ed.redo()
    np.testing.assert_array_equal(table(), second)


def test_a_picture_without_uv_map_is_said_and_nothing_is_changed(registered):
    box = add_box((20, 20, 20))
    add_material(box, flat_image((1, 1, 1, 1)))
    before = looks(box)
    with pytest.raises(RuntimeError, match="no UV map"):
        bpy.ops.dualcolor.soft_proof()
    assert looks(box) == before


def test_a_reason_is_given_where_it_is_gray(registered):
    with pytest.raises(RuntimeError, match="Select a mesh object with faces first"):
        bpy.ops.dualcolor.soft_proof()
