"""Blender's images become tone, whatever kind they are of, and what cannot is said."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from dualcolor.bridge.input.image_input import _as_rgba, image_tone  # noqa: E402
from dualcolor.bridge.paint.ambient_occlusion import darkened  # noqa: E402
from dualcolor.core.errors import TextureError  # noqa: E402
from dualcolor.core.texture.decode import linear_from_srgb  # noqa: E402
from dualcolor.tests.scene import add_box, add_uvs, flat_image  # noqa: E402

GRAY_LINEAR = 0.21404114  # sRGB 0.5, decoded
pytestmark = pytest.mark.usefixtures("registered")


@pytest.mark.parametrize(("options", "tone"), [({}, GRAY_LINEAR), ({"is_data": True}, 0.5), ({"is_float": True}, 0.5)])
def test_images_are_decoded_by_kind_and_color_space(options, tone):
    np.testing.assert_allclose(image_tone(flat_image((0.5, 0.5, 0.5, 1), **options)).tone, tone, atol=2.5e-3)


def test_alpha_means_coverage_unless_the_image_says_otherwise():
    image = flat_image((1, 1, 1, 0.0))
    assert image_tone(image).alpha.max() == 0
    image.alpha_mode = "CHANNEL_PACKED"
    assert image_tone(image).alpha.min() == 1


@pytest.mark.parametrize(("mode", "tone", "alpha"), [("PREMUL", 0.5, 0.5), ("STRAIGHT", 0.25, 0.5), ("NONE", 0.25, 1)])
def test_an_exr_of_half_covered_gray(tmp_path, mode, tone, alpha):
    """Its color is multiplied by alpha in the file, as renderers write it, unless the image says otherwise."""
    settings = bpy.context.scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGBA", "32"
    flat_image((0.25, 0.25, 0.25, 0.5), is_float=True).save_render(str(tmp_path / "half.exr"))
    image = bpy.data.images.load(str(tmp_path / "half.exr"))
    image.colorspace_settings.name, image.alpha_mode = "Linear Rec.709", mode
    found = image_tone(image)
    np.testing.assert_allclose(found.tone, tone, atol=1e-3)
    np.testing.assert_allclose(found.alpha, alpha, atol=1e-3)


def test_pixels_keep_their_place():
    image = flat_image((0, 0, 0, 1))
    pixels = np.zeros((4, 4, 4), dtype=np.float32)
    pixels[..., 3] = 1
    pixels[0, 3, :3] = 1  # bottom right
    image.pixels.foreach_set(pixels.ravel())
    tone = image_tone(image).tone
    assert tone[0, 3] == 1 and tone.sum() == 1


def test_a_missing_picture_is_said_before_anything_is_made_of_it():
    box = add_box((9, 9, 9))
    add_uvs(box)
    image = flat_image((1, 1, 1, 1), "lost")
    image.source, image.filepath = "FILE", "/nowhere/lost.png"
    box.dualcolor.image = image
    with pytest.raises(TextureError, match="the image lost has no pixels"):
        image_tone(image)
    for operator in (bpy.ops.dualcolor.bake_occlusion, bpy.ops.dualcolor.gray_from_color, bpy.ops.dualcolor.generate):
        with pytest.raises(RuntimeError, match="The image lost has no pixels"):
            operator()


@pytest.mark.parametrize("space", ["sRGB", "AgX Base sRGB", "Non-Color", "Linear Rec.709", "Linear Rec.2020", "ACEScg"])
def test_what_is_darkened_was_as_bright_as_it_is_printed(space):
    """Both decode it alike: half of the light is left wherever half of the light arrives."""
    image = flat_image((0, 0, 0, 1))
    image.colorspace_settings.name = space  # which makes it anew
    image.pixels.foreach_set(np.tile(np.array([0.6, 0.6, 0.6, 1.0], dtype=np.float32), 16))
    before = image_tone(image).tone
    after = image_tone(darkened(image, np.full((4, 4), 0.5, dtype=np.float32), 1.0)).tone
    np.testing.assert_allclose(after, before / 2, atol=4e-3)
    expected = float(linear_from_srgb(np.array(0.6))) if space.endswith("sRGB") else 0.6
    np.testing.assert_allclose(before, expected, atol=4e-3)


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_pictures_of_any_number_of_channels(channels):
    pixels = np.random.default_rng(channels).random((3, 4, channels), dtype=np.float32)
    found = _as_rgba(pixels)
    np.testing.assert_array_equal(found[..., :3], pixels[..., :3] if channels > 2 else np.repeat(pixels[..., :1], 3, 2))
    np.testing.assert_array_equal(found[..., 3], pixels[..., -1] if channels % 2 == 0 else 1)
