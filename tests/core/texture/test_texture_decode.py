"""Colors become linear-light tone; alpha stays apart."""

import numpy as np
import pytest
from dualcolor.core.errors import TextureError
from dualcolor.core.texture.decode import color_tone, linear_from_srgb, tone_image


def picture(rgba, shape=(3, 5)):
    return np.broadcast_to(np.asarray(rgba, np.float32), (*shape, 4)).copy()


def reference(value):
    """The sRGB curve for one number, written out by its definition."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def test_the_srgb_curve():
    values = np.linspace(0, 1, 1001)
    assert linear_from_srgb(values) == pytest.approx([reference(v) for v in values], abs=1e-12)
    assert linear_from_srgb(np.array([0.5]))[0] == pytest.approx(0.21404, abs=1e-5)


@pytest.mark.parametrize("value", [0.0, 10 / 255, 0.5, 128 / 255, 200 / 255, 0.73, 1.0])
def test_gray_is_decoded_for_bytes_and_floats_alike(value):
    image = tone_image(picture([value, value, value, 1]), True)
    assert image.tone == pytest.approx(reference(value), abs=2e-6)
    assert image.tone.dtype == np.float32 and image.tone.shape == (3, 5) and (image.alpha == 1).all()


def test_every_byte_comes_out_as_by_the_curve():
    ramp = picture([0, 0, 0, 1], (1, 256))
    ramp[0, :, :3] = (np.arange(256, dtype=np.float32) * np.float32(1 / 255))[:, None]
    assert tone_image(ramp, True).tone[0] == pytest.approx([reference(b / 255) for b in range(256)], abs=1e-6)


def test_linear_pixels_are_not_decoded_and_alpha_never_is():
    image = tone_image(picture([0.5, 0.5, 0.5, 0.5]), False)
    assert image.tone == pytest.approx(0.5) and image.alpha == pytest.approx(0.5)
    image = tone_image(picture([0.5, 0.5, 0.5, 0.5]), True)
    assert image.tone == pytest.approx(0.21404, abs=1e-5) and image.alpha == pytest.approx(0.5)


@pytest.mark.parametrize(("channel", "weight"), [(0, 0.2126), (1, 0.7152), (2, 0.0722)])
def test_luminance_is_taken_of_linear_light(channel, weight):
    for level in (128 / 255, 0.3):
        color = [0.0, 0.0, 0.0, 1.0]
        color[channel] = level
        assert tone_image(picture(color), True).tone == pytest.approx(weight * reference(level), abs=1e-6)
        assert tone_image(picture(color), False).tone == pytest.approx(weight * level, abs=1e-6)


def test_premultiplied_colors_are_divided_by_alpha():
    image = tone_image(picture([0.2, 0.2, 0.2, 0.25]), False, premultiplied=True)
    assert image.tone == pytest.approx(0.8) and image.alpha == pytest.approx(0.25)
    hidden = tone_image(picture([0, 0, 0, 0]), False, premultiplied=True)
    assert np.isfinite(hidden.tone).all() and (hidden.alpha == 0).all()


@pytest.mark.parametrize("encoded", [True, False])
def test_broken_and_excessive_pixels(encoded):
    pixels = picture([1, 1, 1, 1], (2, 2))
    pixels[0, 0, 1], pixels[0, 1, 3], pixels[1, 0] = np.nan, np.inf, [7, 7, 7, 3]
    image = tone_image(pixels, encoded)
    assert (image.alpha == [[0, 0], [1, 1]]).all()
    assert image.tone[1] == pytest.approx([1, 1]) and np.isfinite(image.tone).all()


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize("premultiplied", [True, False])
@pytest.mark.parametrize("encoded", [True, False])
def test_numbers_of_any_size_are_clipped(encoded, premultiplied):
    image = tone_image(picture([3e38, 3e38, 3e38, 1e-20], (2, 2)), encoded, premultiplied)
    assert image.tone == pytest.approx(1) and image.alpha == pytest.approx(1e-20)


@pytest.mark.parametrize("beyond", [-6e-8, 1 + 1e-6])
def test_bytes_that_are_hardly_beyond_their_range_are_clipped(beyond):
    image = tone_image(picture([beyond] * 4, (2, 2)), True)
    assert (image.tone == round(beyond)).all() and (image.alpha == round(beyond)).all()


def test_alpha_that_is_not_finite_is_unpainted_in_byte_images_too():
    pixels = picture([1, 1, 1, 1], (1, 3))
    pixels[0, :, 3] = [np.nan, np.inf, -np.inf]
    assert (tone_image(pixels, True).alpha == 0).all()


def test_pixels_keep_their_place_in_large_pictures():
    rng = np.random.default_rng(0)
    pixels = rng.integers(0, 256, (700, 801, 4)).astype(np.float32) / np.float32(255)
    pixels[650, 3, 0] = 0.1234  # the last part is no byte picture any more
    image = tone_image(pixels, True)
    linear = linear_from_srgb(pixels[..., :3].astype(float))
    assert np.abs(image.tone - linear @ [0.2126, 0.7152, 0.0722]).max() < 1e-6
    assert np.array_equal(image.alpha, pixels[..., 3])


def test_a_picture_without_pixels_is_refused():
    with pytest.raises(TextureError, match="no pixels"):
        tone_image(np.zeros((0, 7, 4), np.float32), True)


def test_colors_blend_over_the_background():
    colors = [
        [1, 1, 1, 1],
        [1, 1, 1, 0],
        [0, 0, 0, 0.25],
        [0, 1, 0, 1],
        [np.nan, 0, 0, 1],
        [0, 0, 0, np.inf],
        [9, 9, 9, 1],
    ]
    tone = color_tone(np.array(colors), 0.4)
    assert tone == pytest.approx([1, 0.4, 0.3, 0.7152, 0.4, 0.4, 1])
    assert color_tone(np.zeros((0, 4)), 0.4).shape == (0,)
