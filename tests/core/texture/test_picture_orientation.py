"""Pictures from a camera stand the way up that they were taken."""

import numpy as np
import pytest
from dualcolor.core.model import ToneImage
from dualcolor.core.texture.exif_orientation import orientation_of_file, upright
from PIL import Image, ImageOps


def stored(path, orientation, **how):
    """A picture of 5 × 3 different grays whose file tells an orientation; as stored, row 0 at the top."""
    gray = np.arange(15, dtype=np.uint8).reshape(3, 5) * 16
    image = Image.fromarray(gray)
    tags = image.getexif()
    tags[0x0112] = orientation
    image.save(path, exif=tags, **how)
    return gray


@pytest.mark.parametrize("orientation", range(1, 9))
def test_pictures_are_turned_as_pillow_turns_them(tmp_path, orientation):
    path = tmp_path / "photo.png"
    gray = stored(path, orientation)[::-1].astype(np.float32)
    told = orientation_of_file(path, (5, 3))
    assert told == orientation
    turned = upright(ToneImage(gray, gray + 1), told)
    with Image.open(path) as image:
        expected = np.asarray(ImageOps.exif_transpose(image))[::-1]
    np.testing.assert_array_equal(turned.tone, expected)
    np.testing.assert_array_equal(turned.alpha, expected + 1.0)


def test_what_is_turned_already_or_tells_nothing_stays(tmp_path):
    path = tmp_path / "photo.jpg"
    stored(path, 6)
    assert orientation_of_file(path, (5, 3)) == 6
    assert orientation_of_file(path, (3, 5)) == 1
    stored(path, 99)
    assert orientation_of_file(path, (5, 3)) == 1
    for content in (b"", b"no picture", path.read_bytes()[:40]):
        path.write_bytes(content)
        assert orientation_of_file(path, (5, 3)) == 1
    assert orientation_of_file(tmp_path / "missing.png", (5, 3)) == 1


def test_a_plate_shows_a_photograph_upright(registered, tmp_path):
    bpy = pytest.importorskip("bpy")
    path = tmp_path / "photo.png"
    gray = np.zeros((40, 60), dtype=np.uint8)
    gray[:, :20] = 255  # the left of what is stored is the top of what was taken
    image = Image.fromarray(gray)
    tags = image.getexif()
    tags[0x0112] = 6
    image.save(path, exif=tags)
    assert bpy.ops.dualcolor.add_plate(filepath=str(path), height=12) == {"FINISHED"}
    width, _, height = bpy.context.object.dimensions
    assert width == pytest.approx(8, rel=0.05) and height == pytest.approx(12, rel=0.05)
    shown = next(image for image in bpy.data.images if image.name.startswith("photo"))
    tone = np.array(shown.pixels[:]).reshape(shown.size[1], shown.size[0], 4)[..., 0]
    assert tone[-3:].min() > 0.9 and tone[:3].max() < 0.1
