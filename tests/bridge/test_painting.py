"""From a bare mesh to a picture that can be painted on, and from a colored picture to a gray one."""

import math
import tracemalloc

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from dualcolor.bridge.paint.ambient_occlusion import darkened  # noqa: E402
from dualcolor.bridge.paint.painting import picture_of, picture_size  # noqa: E402
from dualcolor.bridge.paint.unwrap import unwrap  # noqa: E402
from dualcolor.core.errors import MeshError, TextureError  # noqa: E402
from dualcolor.core.settings.printer import printer_profile  # noqa: E402
from dualcolor.core.texture.decode import linear_from_srgb, srgb_from_linear  # noqa: E402
from dualcolor.core.texture.grade import Grade, graded  # noqa: E402
from dualcolor.tests.scene import add_box, add_material, add_uvs, flat_image  # noqa: E402


def test_srgb_there_and_back():
    light = np.linspace(0, 1, 1001)
    np.testing.assert_allclose(linear_from_srgb(srgb_from_linear(light)), light, atol=1e-7)


def rgba(colors, alpha=None):
    alpha = np.ones(colors.shape[:2]) if alpha is None else alpha
    return np.dstack([colors, alpha]).astype(np.float32)


def test_channel_mix_takes_the_channel_asked_for():
    colors = np.random.default_rng(1).random((6, 7, 3)).astype(np.float32)
    gray = graded(rgba(colors), Grade((0.0, 2.0, 0.0), auto_contrast=False))
    np.testing.assert_allclose(linear_from_srgb(gray), colors[..., 1], atol=1e-6)


def test_levels_and_gamma():
    encoded = np.linspace(0, 1, 11)
    colors = np.repeat(linear_from_srgb(encoded)[None, :, None], 3, axis=2).astype(np.float32)
    gray = graded(rgba(colors), Grade(black=0.2, white=0.8, gamma=2.0, auto_contrast=False))
    np.testing.assert_allclose(gray[0], np.clip((encoded - 0.2) / 0.6, 0, 1) ** 0.5, atol=1e-5)


def test_auto_contrast_fills_the_range_and_ignores_what_is_not_painted():
    colors = np.full((20, 20, 3), 0.3, dtype=np.float32)
    colors[:, :10] = 0.4
    alpha = np.ones((20, 20), dtype=np.float32)
    colors[0], alpha[0] = 1.0, 0.0
    gray = graded(rgba(colors, alpha), Grade())
    assert gray[1:, :10].min() == 1.0 and gray[1:, 10:].max() == 0.0


def test_colors_that_are_multiplied_by_alpha_are_graded_like_others():
    random = np.random.default_rng(2)
    colors, alpha = random.random((6, 7, 3)), random.uniform(0.05, 1, (6, 7))
    whole, of_alpha = (graded(rgba(part, alpha), Grade(), premultiplied=multiplied)
                       for part, multiplied in ((colors, False), (colors * alpha[..., None], True)))  # fmt: skip
    np.testing.assert_allclose(of_alpha, whole, atol=1e-5)


def test_a_grade_that_makes_no_sense_is_said():
    pixels = rgba(np.full((2, 2, 3), 0.3))
    with pytest.raises(TextureError, match="black level"):
        graded(pixels, Grade(black=0.7, white=0.7, auto_contrast=False))
    with pytest.raises(TextureError, match="channel mix"):
        graded(pixels, Grade((1.0, -1.0, 0.0)))


def test_large_pictures_are_graded_and_darkened_in_little_memory(registered):
    pixels = np.random.default_rng(2).random((2048, 1024, 4)).astype(np.float32)
    image = bpy.data.images.new("large", 1024, 2048, alpha=True)
    shade = np.full((2048, 1024), 0.5, dtype=np.float32)
    tracemalloc.start()
    try:
        graded(pixels, Grade(), encoded_srgb=True)
        graded_peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.reset_peak()
        darkened(image, shade, 1.0)
        darkened_peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert graded_peak < 1.2 * pixels.nbytes and darkened_peak < 2.2 * pixels.nbytes  # the latter holds the pixels too


def test_picture_has_texels_no_larger_than_asked(registered):
    box = add_box((100, 100, 100))
    add_uvs(box)  # each face fills the square
    assert picture_size(box, 0.5, "replicator_2x") == 256  # 200 texels are needed
    assert picture_size(box, 0.125, "replicator_2x") == 1024  # 800 are needed
    assert picture_size(box, 0.19, "replicator_2x") == 1024  # 526, more than 512


def test_a_picture_for_an_object_that_is_too_large_is_as_fine_as_its_print(registered):
    """The cube of a new scene got one of 8192², and baking ambient occlusion into that took seven gigabytes."""
    box = add_box((2000, 2000, 2000))
    add_uvs(box)
    printer = printer_profile(box.dualcolor.printer)
    room = min(np.subtract(printer.reach_max, printer.reach_min))
    assert 128 <= room < 160  # of which 0.25 mm are 512 to 640 texels
    assert picture_size(box, 0.25, "replicator_2x") == 1024
    box.scale = (0.5, 0.5, 0.5)
    bpy.context.view_layer.update()
    assert picture_size(box, 0.25, "replicator_2x") == 1024


def test_painting_is_set_up_on_a_bare_mesh(registered):
    box = add_box((40, 40, 40))
    box.dualcolor.background_tone = 1.0
    assert bpy.ops.dualcolor.set_up_painting() == {"FINISHED"}
    assert box.mode == "TEXTURE_PAINT" and box.data.uv_layers
    paint = bpy.context.scene.tool_settings.image_paint
    assert paint.canvas.name == "box Tone" and paint.canvas.size[0] >= 512
    assert min(paint.canvas.pixels[:4]) == 1.0
    texel = 40 * math.sqrt(6 / 0.6) / paint.canvas.size[0]  # charts fill a part of the picture
    assert 0.18 < paint.seam_bleed * texel < 0.32  # mm: half of what is between charts
    bpy.ops.object.mode_set(mode="OBJECT")


def test_brushes_paint_black_and_the_palette_has_even_steps_for_the_eye(registered):
    add_box((40, 40, 40))
    paint = bpy.context.scene.tool_settings.image_paint
    shared = getattr(paint, "unified_paint_settings", None) or bpy.context.tool_settings.unified_paint_settings
    shared.color = (1.0, 0.0, 0.0)
    bpy.ops.dualcolor.set_up_painting()
    assert tuple(shared.color) == (0.0, 0.0, 0.0) and not (paint.brush and any(paint.brush.color))
    stored = np.array([held.color[:] for held in paint.palette.colors])
    # Since Blender 5 these colors are linear; what a picture of bytes gets is encoded.
    shown = srgb_from_linear(stored) if bpy.app.version >= (5, 0) else stored
    np.testing.assert_allclose(shown, np.linspace(0, 1, 11)[:, None].repeat(3, axis=1), atol=1e-6)
    bpy.ops.object.mode_set(mode="OBJECT")


def test_painting_keeps_the_picture_and_the_materials_that_are_there(registered):
    box = add_box((40, 40, 40))
    layer = add_uvs(box)
    image = flat_image((0.2, 0.4, 0.6, 1))
    material, _ = add_material(box, image)
    bpy.ops.dualcolor.set_up_painting()
    paint = bpy.context.scene.tool_settings.image_paint
    assert paint.canvas == image and box.data.materials[0] == material
    assert [each.name for each in box.data.uv_layers] == [layer.name]
    bpy.ops.object.mode_set(mode="OBJECT")


def test_painting_chooses_a_picture_beside_materials_without_one(registered):
    box = add_box((40, 40, 40))
    material, _ = add_material(box, color=(1, 0, 0, 1))
    bpy.ops.dualcolor.set_up_painting()
    assert box.data.materials[0] == material and box.dualcolor.image.name == "box Tone"
    bpy.ops.object.mode_set(mode="OBJECT")


def test_gray_picture_is_printed_instead_of_the_colored_one(registered):
    box = add_box()
    add_uvs(box)
    image = flat_image((1, 0, 0, 1))
    add_material(box, image)
    assert bpy.ops.dualcolor.gray_from_color(mix=(1, 0, 0), auto_contrast=False) == {"FINISHED"}
    made = box.dualcolor.image
    assert made != image and list(made.pixels[:4]) == [1, 1, 1, 1]
    assert list(image.pixels[:4]) == [1, 0, 0, 1] and image.use_fake_user
    assert {node.image for node in box.active_material.node_tree.nodes if node.type == "TEX_IMAGE"} == {made}


def test_a_gray_picture_of_one_material_leaves_the_picture_of_another(registered):
    box = add_box()
    add_uvs(box)
    first, second = flat_image((1, 0, 0, 1), "first"), flat_image((0, 0, 1, 1), "second")
    for picture in (first, second):
        add_material(box, picture)
    box.data.polygons[0].material_index = 1
    bpy.ops.dualcolor.gray_from_color()
    assert box.dualcolor.image is None, "it would cover the other material too"
    assert picture_of(box).name == "first Gray"
    assert {node.image for node in box.data.materials[1].node_tree.nodes if node.type == "TEX_IMAGE"} == {second}


def test_strokes_go_by_the_uv_map_that_the_picture_is_seen_by(registered):
    box = add_box((40, 40, 40))
    add_uvs(box, name="rendered").active_render = True
    add_uvs(box, name="active").active = True
    add_material(box, flat_image((1, 0, 0, 1)))
    bpy.ops.dualcolor.set_up_painting()
    assert box.data.uv_layers.active.name == "rendered"
    bpy.ops.object.mode_set(mode="OBJECT")

    bare = add_box((40, 40, 40), "bare")
    add_uvs(bare, name="rendered").active_render = True
    add_uvs(bare, name="active").active = True
    bpy.ops.dualcolor.set_up_painting()
    layer = bare.data.uv_layers.active
    assert layer.name == "active" and layer.active_render
    bpy.ops.object.mode_set(mode="OBJECT")


def test_the_panel_says_what_is_printed(registered):
    from dualcolor.panels.paint import hints

    box = add_box((20, 30, 40))
    assert any("background tone" in hint for hint in hints(box))
    box.data.color_attributes.active_color = box.data.color_attributes.new("Scan", "BYTE_COLOR", "CORNER")
    assert any("color attribute Scan" in hint for hint in hints(box))
    add_uvs(box)
    add_material(box, flat_image((0, 0, 0, 1)))
    assert any("material's image" in hint for hint in hints(box))


def test_unwrapping_fills_the_square_and_keeps_the_old_map(registered):
    pytest.importorskip("xatlas")
    box = add_box((20, 30, 40))
    old = add_uvs(box).name
    assert bpy.ops.dualcolor.unwrap_xatlas() == {"FINISHED"}
    assert [layer.name for layer in box.data.uv_layers] == [old, "Dual-Color"]
    assert box.data.uv_layers.active.name == "Dual-Color"
    uv = np.empty(len(box.data.loops) * 2, dtype=np.float32)
    box.data.uv_layers.active.uv.foreach_get("vector", uv)
    assert uv.min() >= 0 and uv.max() <= 1 and np.ptp(uv) > 0.5
    assert len(box.data.polygons) == 12


@pytest.mark.parametrize("name", ["unwrap_smart", "unwrap_xatlas"])
def test_a_mesh_with_as_many_uv_maps_as_there_may_be_is_left_as_it_is(registered, name):
    box = add_box((10, 10, 10))
    for number in range(8):
        add_uvs(box, name=f"map {number}")
    with pytest.raises(RuntimeError, match="no room for another UV map") as refused:
        getattr(bpy.ops.dualcolor, name)()
    assert "Traceback" not in str(refused.value) and box.mode == "OBJECT"
    assert len(box.data.polygons) == 6 and len(box.data.uv_layers) == 8


def test_unwrapping_does_not_spoil_sculpted_detail(registered):
    """It splits polygons into triangles, to whose corners the detail does not belong."""
    box = add_box((10, 10, 10))
    box.modifiers.new("Detail", "MULTIRES")
    bpy.ops.object.multires_subdivide(modifier="Detail")
    with pytest.raises(MeshError, match="Multiresolution"):
        unwrap(box, "xatlas")
    assert len(box.data.polygons) == 6
    assert bpy.ops.dualcolor.unwrap_smart() == {"FINISHED"}


@pytest.mark.parametrize("kind", ["TILED", "SEQUENCE", "FILE"])
def test_painting_is_not_set_up_on_what_cannot_be_printed(registered, kind):
    box = add_box((10, 10, 10))
    add_uvs(box)
    image = bpy.data.images.new("odd", 8, 8, tiled=kind == "TILED")
    if kind == "TILED":
        image.tiles.new(1002)
    else:
        image.source, image.filepath = kind, "/nowhere/odd.png"
    add_material(box, image)
    with pytest.raises(RuntimeError, match=r"odd (has several tiles|is a movie|has no pixels)"):
        bpy.ops.dualcolor.set_up_painting()
    assert bpy.context.mode == "OBJECT"


def test_unwrapping_dropped_half_way_leaves_the_mesh_alone(registered):
    pytest.importorskip("xatlas")
    from dualcolor.bridge.paint.unwrap import unwrap_steps
    from dualcolor.core.mesh.unwrapping import ChartOptions, PackOptions

    box = add_box()
    job = unwrap_steps(box, ChartOptions(), PackOptions())
    next(job)
    job.close()
    assert not box.data.uv_layers and len(box.data.polygons) == 6
    assert len(bpy.data.meshes) == 1


def test_buttons_say_what_is_missing(registered):
    with pytest.raises(RuntimeError, match="Select a mesh object with faces first"):
        bpy.ops.dualcolor.set_up_painting()
    add_box()
    with pytest.raises(RuntimeError, match="Choose an image"):
        bpy.ops.dualcolor.gray_from_color()


def test_strokes_that_would_show_in_several_places_are_told_of(registered, capfd):
    for uv, told in ((None, True), ("unwrapped", False)):
        box = add_box((20, 30, 40))
        if uv is None:
            add_uvs(box)
        bpy.ops.dualcolor.set_up_painting()
        bpy.ops.object.mode_set(mode="OBJECT")
        assert ("strokes may show in several places" in capfd.readouterr().out) == told
