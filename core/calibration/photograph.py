"""A photograph as linear light: decoded from sRGB, and reduced where it is finer than needed."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from ..errors import CalibrationError
from ..model import BoolArray, Float32Array, FloatArray
from ..records import dataclass
from ..texture.decode import LUMINANCE, linear_from_srgb
from ..texture.image_size import check_texels, texels_of_file

_HINT = "save it as JPEG or PNG"


@dataclass(frozen=True)
class Photograph:
    """A photograph in linear light.

    Attributes:
        light: (H, W) linear luminance, row 0 at the top.
        is_full: (H, W) where a color channel is at the file's maximum.
    """

    light: Float32Array
    is_full: BoolArray

    def reduced(self, factor: int) -> Photograph:
        """With blocks of `factor` by `factor` pixels averaged; what is left over at the right and below is cut off."""
        if factor <= 1:
            return self
        rows, columns = (size // factor for size in self.light.shape)
        cut = slice(0, rows * factor), slice(0, columns * factor)
        blocks = (rows, factor, columns, factor)
        light = self.light[cut].reshape(blocks).mean(axis=(1, 3), dtype=np.float32)
        return Photograph(light, self.is_full[cut].reshape(blocks).any(axis=(1, 3)))

    def cropped(self, corners: FloatArray, margin: float) -> tuple[Photograph, FloatArray]:
        """The part around corners (4, 2), and (2,) the pixel at which it begins."""
        low = np.maximum(np.floor(corners.min(axis=0) - margin), 0).astype(int)
        high = np.ceil(corners.max(axis=0) + margin).astype(int)
        part = slice(low[1], high[1]), slice(low[0], high[0])
        return Photograph(self.light[part], self.is_full[part]), low.astype(np.float64)


def read_photograph(path: Path, as_stored: bool = False) -> Photograph:
    """A photograph in a file.

    Args:
        path: of a file with 8 bits per color.
        as_stored: as Blender shows it; otherwise turned by its EXIF orientation, as photo programs show it.

    Raises:
        CalibrationError: it is missing, or not a picture of 8 bits per color.
        TextureError: it is too large.
    """
    from PIL import Image, ImageOps

    try:
        check_texels(path.name, texels_of_file(path))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(path) as image:
                if image.mode.startswith(("I", "F")):
                    raise CalibrationError(f"{path} has more than 8 bits per color", "save it with 8 bits")
                shown = image if as_stored else ImageOps.exif_transpose(image)
                values = np.asarray(shown.convert("RGB"))
    except (OSError, ValueError, SyntaxError, EOFError, Image.DecompressionBombError) as problem:
        why = problem.strerror if isinstance(problem, OSError) and problem.strerror else _HINT
        raise CalibrationError(f"the photograph {path} cannot be read", why) from None
    light = np.zeros(values.shape[:2], dtype=np.float32)
    decoded = linear_from_srgb(np.arange(256) / 255.0)
    for channel, weight in enumerate(LUMINANCE):
        light += (weight * decoded).astype(np.float32)[values[..., channel]]
    return Photograph(light, values.max(axis=2) == 255)
