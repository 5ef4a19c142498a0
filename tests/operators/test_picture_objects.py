"""Add → Dual-Color: picture objects as a script makes them, and as a picture that is dropped in makes them."""

import numpy as np
import pytest
from PIL import Image

bpy = pytest.importorskip("bpy")

import dualcolor  # noqa: E402
from dualcolor.bridge.properties import to_settings  # noqa: E402
from dualcolor.bridge.units import use_millimeters  # noqa: E402
from dualcolor.core.pipeline import generate  # noqa: E402
from dualcolor.tests.scene import extent, model_of, volume  # noqa: E402

ADDERS = ("add_plate", "add_cylinder", "add_lamp_shade")


@pytest.fixture
def registered(scene):
    dualcolor.register()
    yield scene
    dualcolor.unregister()


@pytest.fixture
def picture(tmp_path):
    """120 × 80, brighter to the right and much brighter to the top."""
    x, y = np.meshgrid(np.linspace(0, 80, 120), np.linspace(175, 0, 80))
    path = tmp_path / "ramp.png"
    Image.fromarray((x + y).astype(np.uint8)).save(path)
    return path


def entries():
    return [str(entry) for entry in bpy.types.VIEW3D_MT_add._dyn_ui_initialize() if "dualcolor" in entry.__module__]


def test_the_menu_comes_and_goes():
    assert not entries()
    dualcolor.register()
    assert len(entries()) == 1 and bpy.types.DUALCOLOR_FH_image.bl_import_operator == "dualcolor.add_plate"
    dualcolor.unregister()
    assert not entries() and not hasattr(bpy.types, "DUALCOLOR_FH_image")


@pytest.mark.parametrize("millimeters", [True, False], ids=["mm", "meters"])
def test_a_plate_is_ready_to_print(registered, picture, millimeters):
    if millimeters:
        use_millimeters(registered)
    bpy.context.scene.cursor.location = (0.01, 0.02, 0.0)
    assert bpy.ops.dualcolor.add_plate(filepath=str(picture), height=8) == {"FINISHED"}
    obj = bpy.context.object
    assert obj.name == "ramp Plate" and obj.select_get() and len(bpy.context.selected_objects) == 1
    np.testing.assert_allclose(obj.location, (0.01, 0.02, 0.0), atol=1e-7)
    settings = to_settings(obj.dualcolor)
    assert settings.texture_filter == "lanczos" and settings.brim_width > 0
    model = model_of(obj)
    np.testing.assert_allclose(extent(model), (12, 2, 8), atol=1e-5)
    assert volume(model) == pytest.approx(12 * 2 * 8, rel=1e-5)
    (texture,) = model.textures
    assert texture.tone.shape == (16, 24)
    assert texture.tone[0, 0] < 0.01 and texture.tone[-1, -1] > 0.95
    assert texture.tone[-1, 0] > texture.tone[0, -1]  # upright, not mirrored
    result = generate(model, settings)
    assert result.report["layers"] == 32 and not result.warnings


def test_texels_show_on_the_layers_in_front(registered, picture):
    """The tone that the pipeline finds on the front is that of the texel row of the layer pair."""
    use_millimeters(registered)
    bpy.ops.dualcolor.add_plate(filepath=str(picture), height=8)
    model = model_of(bpy.context.object)
    outlines = generate(model, to_settings(bpy.context.object.dualcolor)).outlines
    layer = np.repeat(outlines.layer, np.diff(outlines.start))
    front = (outlines.base[:, 1] < -0.7) & (np.abs(outlines.base[:, 0]) < 5)
    column = np.floor((outlines.base[:, 0] + 6) / 0.5).astype(int).clip(0, 23)
    for pair in range(16):
        mine = front & (layer // 2 == pair)
        wanted = model.textures[0].tone[pair, column[mine]]
        assert np.abs(outlines.tone[mine] - wanted).mean() < 0.03, pair


def test_frame_and_crop(registered, picture):
    use_millimeters(registered)
    frame = {"frame": 1.0, "frame_tone": 0.25}
    bpy.ops.dualcolor.add_plate(filepath=str(picture), height=8, width=6, crop=True, thickness=3, **frame)
    model = model_of(bpy.context.object)
    np.testing.assert_allclose(extent(model), (8, 3, 10), atol=1e-5)
    tone = model.textures[0].tone
    assert tone.shape == (20, 16)
    np.testing.assert_allclose([tone[0, 0], tone[-1, -1], tone[1, 8]], 0.25, atol=4e-3)


def test_a_cylinder_and_a_lamp_shade_have_a_picture_once_around(registered, picture):
    use_millimeters(registered)
    bpy.ops.dualcolor.add_cylinder(filepath=str(picture), diameter=10)
    cylinder = model_of(bpy.context.object)
    np.testing.assert_allclose(extent(cylinder), (10, 10, 21), atol=0.05)  # π · 10 · 2 / 3 in whole pairs
    assert volume(cylinder) == pytest.approx(np.pi * 25 * 21, rel=5e-3)
    bpy.ops.dualcolor.add_lamp_shade(filepath=str(picture), bottom_diameter=20, top_diameter=12, crop=True, height=10)
    shade = model_of(bpy.context.object)
    np.testing.assert_allclose(extent(shade), (20, 20, 10), atol=0.05)
    solid = np.pi * 10 / 3 * np.array([100 + 60 + 36, 64 + 32 + 16])
    assert volume(shade) == pytest.approx(solid[0] - solid[1], rel=5e-3)
    assert shade.textures[0].tone.shape == (20, round(np.pi * 16 / 0.5))
    assert len(bpy.context.selected_objects) == 1
    result = generate(shade, to_settings(bpy.context.object.dualcolor))
    assert np.bincount(result.outlines.layer).tolist() == [2] * 40  # outside and inside


@pytest.mark.parametrize("adder", ADDERS)
def test_what_is_no_picture_is_refused_and_leaves_nothing(registered, tmp_path, adder):
    broken = tmp_path / "broken.png"
    broken.write_text("no picture")
    before = [len(held) for held in (bpy.data.objects, bpy.data.images, bpy.data.meshes, bpy.data.materials)]
    for path in (broken, tmp_path / "missing.png"):
        with pytest.raises(RuntimeError, match="read"):
            getattr(bpy.ops.dualcolor, adder)(filepath=str(path))
    assert before == [len(held) for held in (bpy.data.objects, bpy.data.images, bpy.data.meshes, bpy.data.materials)]


def test_impossible_walls_are_refused(registered, picture):
    with pytest.raises(RuntimeError, match="leaves no room"):
        bpy.ops.dualcolor.add_lamp_shade(filepath=str(picture), top_diameter=10, wall=6)


def test_objects_are_added_in_object_mode_only(registered):
    bpy.ops.mesh.primitive_cube_add()
    assert bpy.ops.dualcolor.add_plate.poll()
    bpy.ops.object.mode_set(mode="EDIT")
    assert not any(getattr(bpy.ops.dualcolor, adder).poll() for adder in ADDERS)
    with pytest.raises(RuntimeError, match="Switch to Object Mode"):
        bpy.ops.dualcolor.add_cylinder()
    bpy.ops.object.mode_set(mode="OBJECT")


@pytest.mark.parametrize("kind", ["GRADIENT", "CHECKERED", "PHASE_SHIFTED", "ATTENUATED"])
def test_cylinders_that_show_the_pattern_keep_what_makes_them(registered, kind):
    use_millimeters(registered)
    assert bpy.ops.dualcolor.add_figure_cylinder(kind=kind, diameter=8, height=6) == {"FINISHED"}
    obj = bpy.context.object
    settings, model = to_settings(obj.dualcolor), model_of(obj)
    np.testing.assert_allclose(extent(model), (8, 8, 6), atol=0.05)
    assert (settings.calibration == "slope_aware") == (kind == "GRADIENT")
    assert bool(settings.phase_shift_layers) == (kind == "PHASE_SHIFTED")
    assert bool(settings.mostly_white_below and settings.mostly_black_above) == (kind == "CHECKERED")
    rows = model.textures[0].tone.mean(axis=1)
    wanted = np.linspace(0, 1, 12) if kind in ("GRADIENT", "ATTENUATED") else np.full(12, 0.5)
    np.testing.assert_allclose(rows, wanted, atol=0.005)


def distances():
    areas = [area for screen in bpy.data.screens for area in screen.areas if area.type == "VIEW_3D"]
    return [area.spaces.active.region_3d.view_distance for area in areas]


def test_the_first_object_and_one_scaled_for_a_scene_in_mm_are_seen_in_all_workspaces(registered, picture):
    before = distances()
    assert len(before) > 5
    bpy.ops.dualcolor.add_plate(filepath=str(picture), height=30)
    first = distances()
    size = max(bpy.context.object.dimensions)
    assert all(size < distance < 3 * size for distance in first) and first != before
    bpy.ops.dualcolor.add_plate(filepath=str(picture), height=60)
    bpy.ops.dualcolor.scale_to_height(height=50)
    assert distances() == first  # views that are used already stay
    bpy.ops.dualcolor.scale_to_height(height=140, scene_in_mm=True)
    assert distances() != first
