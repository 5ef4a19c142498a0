"""From a photograph of the printed step wedge to a tone table."""

from __future__ import annotations

import numpy as np

from ..errors import CalibrationError
from ..model import BoolArray, FloatArray, IntArray
from ..records import dataclass
from ..settings import PrintSettings
from .homography import projected, square_to
from .marks import patch_pixels
from .photograph import Photograph
from .provenance import Provenance, tone_settings
from .step_wedge import COLUMNS, MARKS, ROWS, STEPS, Patches, patch_tones, patches, references
from .table import ToneTable, isotonic

_FINEST_PATCH_PX = 100.0  # larger patches are averaged before they are read
_MOST_FULL = 0.02  # share of a white patch's pixels that may be at the file's maximum
_LEAST_CONTRAST = 0.02  # between printed white and black, as a share of the white
_OUTLIER = 3.0  # deviations from the median
_LEAST_DEVIATION = 0.01  # of the patch's brightness
_UNEVEN = 0.05  # of the range; more left in the reference patches gives a warning
_DESCENT = 0.05  # of the range; tones that descend by more give a warning


@dataclass(frozen=True)
class WedgeReading:
    """The tones read from a photograph of the wedge. T tones.

    Attributes:
        tone: (T,) from 0 to 1.
        seen: (T,) linear light, the printed black 0 and the printed white 1; not descending.
        noise: (T,) standard error of it.
        notes: about the photograph, one sentence each.
    """

    tone: FloatArray
    seen: FloatArray
    noise: FloatArray
    notes: list[str]


def read_wedge(photo: Photograph, marks: FloatArray, settings: PrintSettings) -> WedgeReading:
    """Read the steps between the printed white and black.

    Args:
        photo: of the wedge.
        marks: (4, 2) pixels, in the order of `MARKS`.
        settings: that the wedge was printed with.

    Raises:
        CalibrationError: the wedge is too small in it, too bright, or has no contrast.
    """
    light, error = patch_means(photo, marks, patches(settings))
    white, black = references()
    share, deviation, left = _evened(light, error)
    notes = []
    if left > _UNEVEN:
        notes.append(
            f"the printed white and black differ by {left:.0%} from place to place: photograph in softer light, "
            "without reflections"
        )
    tone = patch_tones()
    steps = ~(white | black | np.isnan(tone))
    seen, noise = np.zeros(STEPS), np.zeros(STEPS)
    order = np.argsort(tone[steps])
    seen[1:-1], noise[1:-1] = share[steps][order], deviation[steps][order]
    seen[-1] = 1.0
    noise[0], noise[-1] = (float(deviation[those].mean()) for those in (black, white))
    ascending = isotonic(np.clip(seen, 0.0, 1.0))
    descent = float(np.abs(ascending - seen).max())
    if descent > _DESCENT:
        notes.append(
            f"tones that should get lighter get darker by up to {2 * descent:.0%} of the range: check the print"
        )
    return WedgeReading(np.linspace(0.0, 1.0, STEPS), ascending, noise, notes)


def wedge_table(
    reading: WedgeReading, settings: PrintSettings, simulated: ToneTable, ends: tuple[float, float] | None, source: str
) -> ToneTable:
    """The table of a printer and its filaments.

    A photograph shows tones between the printed black and white, not how dark and light these are: that is taken from
    `ends`, or from the simulation. It shows an upright wall. On slopes the simulation is corrected by its error on the
    upright wall, in proportion to the slope's range; a simulation for other settings is not used, and the table has
    only the upright wall.

    Args:
        reading: of the wedge.
        settings: that it was printed with.
        simulated: the table that fits these settings best.
        ends: reflectance of the printed black and white, linear, if they are known.
        source: of the photograph.
    """
    fits = not simulated.provenance.differences(settings)
    rows = np.stack([np.interp(reading.tone, simulated.tone, row) for row in simulated.reflectance])
    black, white = ends or (float(rows[0, 0]), float(rows[0, -1]))
    upright = black + reading.seen * (white - black)
    noise = reading.noise * (white - black)
    provenance = Provenance(tone_settings(settings), dict(simulated.provenance.reflectance), source)
    if not fits:
        return ToneTable(reading.tone, np.zeros(1), upright[None, :], noise[None, :], provenance)
    share = (rows[:, -1] - rows[:, 0]) / (rows[0, -1] - rows[0, 0])
    corrected = rows + share[:, None] * (upright - rows[0])
    return ToneTable(
        reading.tone, simulated.slant_deg, np.stack([isotonic(np.clip(row, 0.0, 1.0)) for row in corrected]),
        np.tile(noise, (len(rows), 1)), provenance,
    )  # fmt: skip


def patch_means(photo: Photograph, marks: FloatArray, size: Patches) -> tuple[FloatArray, FloatArray]:
    """(5, 9) linear light of each patch's middle part and its standard error.

    A patch is cut into pieces, each a whole period of the pattern high; pieces that differ from the others, by blobs or
    gaps, are left out. Pixels are weighted by the area of the patch that they show, so perspective needs no
    interpolation.

    Args:
        photo: of the wedge.
        marks: (4, 2) pixels, in the order of `MARKS`.
        size: of the patches.

    Raises:
        CalibrationError: the patches are too small or too bright in it.
    """
    span = MARKS[2] - MARKS[0]
    grid = np.array([(0, 0), (COLUMNS, 0), (COLUMNS, ROWS), (0, ROWS)], dtype=np.float64)
    corners = projected(square_to(marks), (grid - MARKS[0]) / span)
    patch_px = patch_pixels(marks)
    part, begin = photo.cropped(corners, 2.0)
    factor = max(int(patch_px / _FINEST_PATCH_PX), 1)
    part = part.reduced(factor)
    row, column = np.indices(part.light.shape)
    pixel = (np.stack([column.ravel(), row.ravel()], axis=1) + 0.5) * factor + begin
    inverse = np.linalg.inv(square_to(marks))
    place = projected(inverse, pixel) * span + MARKS[0]
    # The area of the wedge that a pixel shows goes with the inverse cube of the homography's denominator.
    depth = np.abs(inverse[2, 0] * pixel[:, 0] + inverse[2, 1] * pixel[:, 1] + inverse[2, 2])
    area = (depth.min() / depth) ** 3
    on_grid = ((place >= 0) & (place < (COLUMNS, ROWS))).all(axis=1)
    patch = np.floor(place[on_grid]).astype(np.int64)
    number = patch[:, 1] * COLUMNS + patch[:, 0]
    off = (place[on_grid] - patch - 0.5) * (size.width, size.height)
    _check_exposure(part.is_full.ravel()[on_grid], number)
    pixel_mm = size.height / (patch_px / factor)
    pieces = _pieces(off, pixel_mm, part.light.ravel()[on_grid], area[on_grid], number, size)
    return _without_outliers(pieces)


def _check_exposure(is_full: BoolArray, number: IntArray) -> None:
    full = np.bincount(number, is_full, minlength=ROWS * COLUMNS)
    share = full / np.maximum(np.bincount(number, minlength=ROWS * COLUMNS), 1)
    most = float(share[references()[0].ravel()].max())
    if most > _MOST_FULL:
        raise CalibrationError(
            f"the photograph is overexposed, {most:.0%} of a white patch is as bright as it can be", "expose it less"
        )


def _pieces(
    off: FloatArray, pixel_mm: float, light: FloatArray, area: FloatArray, number: IntArray, size: Patches
) -> FloatArray:
    """(P, 45) mean of P pieces of each patch: a period high, half of the read width wide, weighted by a triangle."""
    means = []
    half = size.read_width / 2
    for across in (-half / 2, half / 2):
        fade = np.clip(1.0 - np.abs(off[:, 0] - across) / half, 0.0, None)
        for period in range(size.read_periods):
            low = (period - size.read_periods / 2) * size.period
            # The share of a pixel that lies in the piece, so that periods are exact to a fraction of a pixel.
            inside = np.minimum(off[:, 1] + pixel_mm / 2, low + size.period) - np.maximum(off[:, 1] - pixel_mm / 2, low)
            weight = fade * area * np.clip(inside, 0.0, None)
            total = np.bincount(number, weight, minlength=ROWS * COLUMNS)
            means.append(np.bincount(number, weight * light, minlength=ROWS * COLUMNS) / np.maximum(total, 1e-12))
    return np.stack(means)


def _without_outliers(pieces: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(5, 9) means and their standard errors of pieces (P, 45)."""
    median = np.median(pieces, axis=0)
    off = np.abs(pieces - median)
    usual = np.maximum(1.4826 * np.median(off, axis=0), _LEAST_DEVIATION * median)
    kept = off <= _OUTLIER * usual
    count = kept.sum(axis=0)
    mean = np.where(kept, pieces, 0.0).sum(axis=0) / count
    spread = np.sqrt(np.where(kept, (pieces - mean) ** 2, 0.0).sum(axis=0) / np.maximum(count - 1, 1) / count)
    return mean.reshape(ROWS, COLUMNS), spread.reshape(ROWS, COLUMNS)


def _evened(light: FloatArray, error: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """(5, 9) light between local black (0) and white (1), its standard error, and how far reference patches are off.

    Second-degree polynomials over the wedge are fitted to the logarithms of the light of the white patches and of the
    black ones: they contain fall-off, veiling light and the influence of the viewing direction.

    Raises:
        CalibrationError: white and black look alike.
    """
    row, column = np.indices(light.shape)
    x, y = column.ravel() / (COLUMNS - 1) - 0.5, row.ravel() / (ROWS - 1) - 0.5
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)
    known = np.log(np.maximum(light, 1e-6)).ravel()
    white, black = (
        np.exp(terms @ np.linalg.lstsq(terms[those.ravel()], known[those.ravel()], rcond=None)[0]).reshape(light.shape)
        for those in references()
    )
    if (white - black < _LEAST_CONTRAST * white).any():
        raise CalibrationError("the printed white and black look alike in the photograph", "check corners and light")
    share = (light - black) / (white - black)
    is_white, is_black = references()
    left = np.concatenate([share[is_white] - 1.0, share[is_black]])
    return share, np.hypot(error / (white - black), left.std()), float(np.abs(left).max())
