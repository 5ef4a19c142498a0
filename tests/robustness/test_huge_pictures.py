"""Pictures of absurd size are refused before they are decoded."""

import struct
import zlib
from io import BytesIO

import numpy as np
import pytest
from dualcolor.core.errors import TextureError
from dualcolor.core.texture.image_size import MOST_TEXELS, check_texels, texels
from PIL import Image


def png(width, height):
    """The head of a picture of that size, with hardly anything in it."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"")) + chunk(b"IEND", b"")


def exr(width, height):
    window = b"dataWindow\0box2i\0\x10\0\0\0" + struct.pack("<4i", 0, 0, width - 1, height - 1)
    return b"\x76\x2f\x31\x01\x02\0\0\0channels\0chlist\0\x01\0\0\0\0" + window


@pytest.mark.parametrize("kind", [png, exr])
def test_the_head_tells_the_size(kind):
    assert texels(BytesIO(kind(640, 480))) == 640 * 480
    with pytest.raises(TextureError, match="million texels"):
        check_texels("a", texels(BytesIO(kind(60_000, 60_000))))
    check_texels("a", 8192 * 8192)


@pytest.mark.parametrize("suffix", ["PNG", "JPEG", "TIFF", "BMP", "WEBP"])
def test_kinds_of_files(suffix):
    held = BytesIO()
    Image.new("RGB", (31, 17)).save(held, suffix)
    held.seek(0)
    assert texels(held) == 31 * 17
    random = np.random.default_rng(1)
    for _ in range(60):
        data = bytearray(held.getvalue())
        for at in random.integers(0, min(len(data), 80), 3):
            data[at] = random.integers(0, 256)
        assert texels(BytesIO(bytes(data))) >= 0


def test_blender_never_decodes_them(scene, tmp_path):
    import bpy
    from dualcolor.bridge.input.image_input import image_tone, load_image

    path = tmp_path / "bomb.png"
    path.write_bytes(png(100_000, 100_000))
    with pytest.raises(TextureError, match="million texels"):
        load_image(path)
    assert not bpy.data.images
    unread = bpy.data.images.load(str(path))
    with pytest.raises(TextureError, match="million texels"):
        image_tone(unread)
    unread.pack()
    with pytest.raises(TextureError):
        image_tone(unread)
    assert MOST_TEXELS >= 8192**2


def test_bands_of_a_large_picture_make_the_same_levels(monkeypatch):
    from dualcolor.core.model import ToneImage
    from dualcolor.core.texture import island_levels, pyramid
    from dualcolor.core.texture.charts import Charts

    random = np.random.default_rng(5)
    size = (37, 51)
    image = ToneImage(*(random.random(size).astype(np.float32) for _ in range(2)))
    labels = random.integers(0, 4, size).astype(np.int8)

    def levels():
        (own,) = island_levels.island_levels(Charts(np.zeros(0, np.int8), np.zeros(0), (labels,)), "trilinear")
        return pyramid._averaged(pyramid._finest(image, own[0]), own[1:])

    whole = levels()
    for module in (pyramid, island_levels):
        monkeypatch.setattr(module, "BAND_TEXELS", 200)
    for one, other in zip(whole, levels(), strict=True):
        assert (one.height, one.width) == (other.height, other.width)
        for name in ("paint", "alpha", "coverage", "island", "uniform"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
