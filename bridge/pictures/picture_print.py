"""A picture's predicted print, photographed straight from the front and compared with the picture."""

from __future__ import annotations

import numpy as np

from ...core.model import Float32Array, ToneImage
from ...core.pictures.match import PictureMatch, pattern_period, picture_match
from ...core.pictures.shapes import PictureShape, surface_of
from ...core.pipeline import DualColorPrint, generate
from ...core.records import dataclass
from ...core.settings import PrintSettings
from ..measuring.instrument import Face, photograph


@dataclass(frozen=True)
class PicturePrint:
    """The predicted print of a plate.

    Attributes:
        result: the print.
        photograph: (H, W) linear reflectance of its front, row 0 at the top, NaN where there is nothing.
        match: of photograph and picture.
        painted: (H, W) the picture with the background's tone where it is not painted, row 0 at the bottom.
    """

    result: DualColorPrint
    photograph: Float32Array
    match: PictureMatch
    painted: Float32Array


def picture_print(
    picture: ToneImage,
    plate: PictureShape,
    settings: PrintSettings,
    name: str,
    mm_per_pixel: float = 0.05,
    samples: int = 4,
) -> PicturePrint:
    """Print a plate, photograph its front in even light and compare.

    Args:
        picture: fitted to the plate.
        plate: made with the same settings.
        settings: of the print.
        name: of the object.
        mm_per_pixel: of the photograph.
        samples: of each of its pixels.

    Raises:
        PrintError: the plate cannot be printed.
    """
    result = generate(surface_of(plate, picture, settings.background_tone, name), settings)
    width, height = plate.size
    front = Face((0.0, float(plate.vertices[:, 1].min()), height / 2), width, height)
    seen = photograph(result.moves, settings, front, mm_per_pixel=mm_per_pixel, samples=samples)
    painted = picture.alpha * picture.tone + (1 - picture.alpha) * np.float32(settings.background_tone)
    match = picture_match(seen, painted, mm_per_pixel, pattern_period(result.outlines, settings))
    return PicturePrint(result, seen, match, painted)
