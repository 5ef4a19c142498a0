"""Blender images as tone."""

from __future__ import annotations

from contextlib import suppress
from io import BytesIO
from pathlib import Path

import bpy
import numpy as np

from ...core.errors import TextureError
from ...core.model import Float32Array, ToneImage
from ...core.texture.decode import tone_image
from ...core.texture.exif_orientation import orientation_of_file, upright
from ...core.texture.image_size import check_texels, texels, texels_of_file
from ..quiet import quiet_stderr
from .base_color import HOW_TO_BAKE

RAW_COLOR_SPACES = ("Non-Color", "Raw", "Generic Data", "ACES2065-1", "ACEScg", "Working Space")
"""Color spaces whose values are proportional to light, beside those whose name begins with "Linear"."""


def load_image(path: Path) -> bpy.types.Image:
    """Open a picture file.

    Raises:
        TextureError: the file is missing, not a picture, or one of absurd size.
    """
    hint = "give a PNG, JPEG, TIFF or EXR file"
    with suppress(OSError):  # reported below
        check_texels(path.name, texels_of_file(path))
    try:
        image = bpy.data.images.load(str(path.resolve()))
    except RuntimeError:  # how Blender tells that it cannot open the file
        raise TextureError(f"the image {path} cannot be read", hint) from None
    with quiet_stderr():  # the size is known once the file is decoded, about which Blender before 5 has its own say
        is_picture = all(image.size)
    if not is_picture:
        bpy.data.images.remove(image)
        raise TextureError(f"{path} is not an image that Blender can read", hint)
    return image


def picture_tone(path: Path) -> ToneImage:
    """The tone of a picture file, turned by its EXIF orientation; Blender itself shows pictures as they are stored.

    Raises:
        TextureError: the file is missing, not a picture, or one of absurd size.
    """
    image = load_image(path)
    try:
        return upright(image_tone(image), orientation_of_file(path, tuple(image.size)))
    finally:
        bpy.data.images.remove(image)


def image_tone(image: bpy.types.Image) -> ToneImage:
    """The tone of a Blender image, as it is now (painted pixels too).

    Byte images hold encoded values unless their color space is a linear one; float images are linear, and their
    color is multiplied by alpha. An alpha that is ignored or used for something else is no coverage.

    Raises:
        TextureError: the image has no pixels, is made of UDIM tiles, or moves.
    """
    rgba, encoded, premultiplied = stored_pixels(image)
    return tone_image(rgba, encoded_srgb=encoded, premultiplied=premultiplied)


def image_size(image: bpy.types.Image) -> tuple[int, int]:
    """Width and height in texels.

    Raises:
        TextureError: the image has no pixels, claims more than any picture has, is made of UDIM tiles, or moves.
    """
    if image.source in ("MOVIE", "SEQUENCE"):  # which of its frames is shown is not the image's own affair
        raise TextureError(
            f"the image {image.name} is a movie or a sequence", "save one of its frames, and choose that"
        )
    if image.source == "TILED" and len(image.tiles) > 1:
        raise TextureError(f"the image {image.name} has several tiles", f"bake them into one {HOW_TO_BAKE}")
    if not image.has_data:  # asking for the size would decode it
        check_texels(image.name, _texels_undecoded(image))
    width, height = image.size
    if not width or not height:
        raise TextureError(f"the image {image.name} has no pixels", "its file may be missing: reload or replace it")
    return width, height


def image_pixels(image: bpy.types.Image) -> Float32Array:
    """(H, W, 1 to 4) as stored.

    Raises:
        TextureError: the image has no pixels, claims more than any picture has, is made of UDIM tiles, or moves.
    """
    width, height = image_size(image)
    pixels = np.empty(width * height * image.channels, dtype=np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, image.channels)


def is_encoded(image: bpy.types.Image) -> bool:
    """Whether an image's colors are sRGB-encoded: bytes are, unless their color space is a linear one."""
    space = image.colorspace_settings.name
    return not (image.is_float or space in RAW_COLOR_SPACES or space.startswith("Linear"))


def stored_pixels(image: bpy.types.Image) -> tuple[Float32Array, bool, bool]:
    """(H, W, 4) as stored, whether colors are sRGB-encoded, and whether they are multiplied by alpha.

    An alpha that is ignored or used for something else is 1.

    Raises:
        TextureError: the image has no pixels, is made of UDIM tiles, or moves.
    """
    rgba = _as_rgba(image_pixels(image))
    covers = image.alpha_mode in ("STRAIGHT", "PREMUL")
    if not covers:
        rgba[..., 3] = 1.0
    # Blender multiplies what is straight in the file when it reads it, and divides what is bytes.
    return rgba, is_encoded(image), image.is_float and covers


def _texels_undecoded(image: bpy.types.Image) -> int:
    """Number of texels according to the head of an image's file, 0 if it does not say."""
    if image.packed_file:
        return texels(BytesIO(image.packed_file.data))
    with suppress(OSError):  # a missing file has no texels
        return texels_of_file(Path(bpy.path.abspath(image.filepath, library=image.library)))
    return 0


def _as_rgba(pixels: Float32Array) -> Float32Array:
    """(H, W, 4) from (H, W, 1 to 4): gray is repeated, missing alpha is 1."""
    channels = pixels.shape[2]
    if channels == 4:
        return pixels
    rgba = np.ones((*pixels.shape[:2], 4), dtype=np.float32)
    rgba[..., :3] = pixels[..., :3] if channels == 3 else pixels[..., :1]
    if channels == 2:
        rgba[..., 3] = pixels[..., 1]
    return rgba
