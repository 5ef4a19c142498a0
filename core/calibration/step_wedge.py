"""The step wedge to print and photograph: patches of all tones among white and black ones, marks in the corners.

Its grid has five rows of nine patches. Those along the edge are black and white in turn, and two inside are black: they
show how the light falls. The others are the steps from dark to light, row by row from the top. Each corner has a mark
of two by two squares, by whose crossing the photograph is registered.
"""

from __future__ import annotations

import math

import numpy as np

from ..model import BoolArray, Float32Array, FloatArray, ToneImage
from ..pattern.modulation import PERIOD_LAYERS
from ..pictures.shapes import PLATE_BRIM_MM, PictureShape, picture_plate
from ..records import dataclass
from ..settings import PrintSettings

ROWS, COLUMNS = 5, 9
STEPS = 21
MARKS = np.array([(0.5, 0.5), (COLUMNS - 0.5, 0.5), (COLUMNS - 0.5, ROWS - 0.5), (0.5, ROWS - 0.5)])
"""(4, 2) crossings of the marks, in patches right of and below the grid's upper left corner; clockwise from there."""

_WAVES, _PERIODS = 6, 6  # width of a patch in waves, height in periods
_MARGIN_WAVES, _MARGIN_PERIODS = 1, 1  # on each side that are not read, since neighbors blend there
_FRAME_MM, _FRAME_TONE, _THICKNESS_MM = 3.0, 0.5, 4.0


@dataclass(frozen=True)
class Patches:
    """Size of the patches, mm. The part that is read keeps off the edges and is whole periods of the pattern high.

    Attributes:
        width: of a patch.
        height: of a patch.
        read_width: of its middle part.
        period: height of a period of the pattern.
        read_periods: that are read of each patch.
    """

    width: float
    height: float
    read_width: float
    period: float
    read_periods: int


def patches(settings: PrintSettings) -> Patches:
    """Their size, whole texels and at least six waves wide, six periods of the pattern high."""
    texel = 2 * settings.layer_height
    period = PERIOD_LAYERS * settings.layer_height
    width = math.ceil(_WAVES * settings.wavelength / texel - 1e-9) * texel
    margin = _MARGIN_WAVES * settings.wavelength
    return Patches(width, _PERIODS * period, width - 2 * margin, period, _PERIODS - 2 * _MARGIN_PERIODS)


def patch_tones() -> FloatArray:
    """(5, 9) tone of each patch, the upper row first; NaN in the corners, which bear marks."""
    row, column = np.indices((ROWS, COLUMNS))
    tone = ((row + column) % 2).astype(np.float64)
    inside = (row > 0) & (row < ROWS - 1) & (column > 0) & (column < COLUMNS - 1)
    inside[ROWS // 2, [3, 5]] = False  # black, so that the light is known in the middle too
    tone[ROWS // 2, [3, 5]] = 0.0
    tone[inside] = np.linspace(0.0, 1.0, STEPS)[1:-1]
    tone[[0, 0, -1, -1], [0, -1, 0, -1]] = np.nan
    return np.asarray(tone)


def quarter_tones() -> FloatArray:
    """(10, 18) tone of each quarter of a patch, the upper row first: the marks' squares too."""
    tone = np.kron(patch_tones(), np.ones((2, 2)))
    row, column = np.indices(tone.shape)
    return np.asarray(np.where(np.isnan(tone), (row + column) % 2, tone))


def references() -> tuple[BoolArray, BoolArray]:
    """(5, 9) which patches are white, and which are black."""
    tone = patch_tones()
    return tone == 1.0, tone == 0.0


def wedge_plate(settings: PrintSettings) -> tuple[PictureShape, ToneImage]:
    """The upright plate with the wedge on its front, and its picture.

    Args:
        settings: layer heights and wavelength are used.
    """
    size = patches(settings)
    plate = picture_plate(COLUMNS * size.width, ROWS * size.height, _THICKNESS_MM, settings, _FRAME_MM)
    across = (plate.columns - 2 * plate.frame) // COLUMNS
    up = (plate.rows - 2 * plate.frame) // ROWS
    quarters = quarter_tones()[::-1]
    row, column = (2 * np.arange(cells * texels) // texels for cells, texels in ((ROWS, up), (COLUMNS, across)))
    shown: Float32Array = quarters[np.ix_(row, column)].astype(np.float32)
    framed = np.pad(shown, plate.frame, constant_values=_FRAME_TONE)
    return plate, ToneImage(framed, np.ones_like(framed))


def wedge_settings(settings: PrintSettings) -> PrintSettings:
    """The settings that the wedge is printed with: each step is modulated by its own tone, without calibration."""
    return settings.changed(
        {"calibration": "none", "solid_regions": "none", "texture_filter": "lanczos",
         "brim_width": max(settings.brim_width, PLATE_BRIM_MM)}
    )  # fmt: skip
