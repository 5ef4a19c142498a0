"""From the tone asked for to the tone to print: the stage in front of the modulation (paper, section 6.2)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..model import FloatArray
from ..pattern.chunks import in_chunks
from ..pattern.contours import POINTS_PER_WAVELENGTH
from ..settings import PrintSettings
from .gamut_mapping import image_range, printable_tones
from .table import ToneTable, read_table

SHIPPED = Path(__file__).resolve().parent.parent.parent / "presets" / "calibration"
_LEVELS = 512
_HINT = "measure one with dualcolor measure and dualcolor build-table, or set calibration = none"


def calibrated(tone: FloatArray, slant_deg: FloatArray, settings: PrintSettings) -> tuple[FloatArray, list[str]]:
    """The tones to print so that the tones asked for are seen, face on, and what is to be said about the table.

    Args:
        tone: (N,) asked for, 0 black to 1 white, at the points of all contours.
        slant_deg: (N,) of the surface; overhangs count as upright.
        settings: calibration, calibration_file and gamut_mapping, and those that the table must hold for.

    Raises:
        CalibrationError: calibration_file cannot be read.
    """
    if settings.calibration == "none":
        return tone, []
    table = table_for(settings)
    if table is None:
        return tone, [f"pattern {settings.pattern} has no tone table, its tones are printed as they are: {_HINT}"]
    differences = table.about.differences(settings)
    notes = [f"the tone table holds for other settings ({', '.join(differences)}): {_HINT}"] if differences else []
    slants = table.slant_deg[:1] if settings.calibration == "upright" else table.slant_deg
    shown = image_range(tone, settings.layer_height * settings.wavelength / POINTS_PER_WAVELENGTH)
    ways = printable_tones(np.linspace(0.0, 1.0, _LEVELS + 1), slants, table, shown, settings).printed
    return _looked_up(ways, slants, tone, slant_deg), notes


def table_for(settings: PrintSettings) -> ToneTable | None:
    """The table that tells how the pattern looks: the user's own, or the one that comes with the program.

    Raises:
        CalibrationError: calibration_file cannot be read.
    """
    return read_table(Path(settings.calibration_file)) if settings.calibration == "file" else shipped_table(settings)


def shipped_table(settings: PrintSettings) -> ToneTable | None:
    """Of the tables that come with the program the one for this pattern that fits best; None if there is none."""
    tables = [read_table(path) for path in sorted((SHIPPED / settings.pattern).glob("*.json"))]
    return min(tables, key=lambda table: table.about.distance(settings), default=None)


def _looked_up(ways: FloatArray, slants: FloatArray, tone: FloatArray, slant_deg: FloatArray) -> FloatArray:
    """(N,) read off between the four nearest entries of the table."""
    flat = ways.ravel()

    def part(asked: FloatArray, leaning: FloatArray) -> tuple[FloatArray]:
        across = np.clip(asked, 0.0, 1.0) * _LEVELS
        column = np.minimum(across.astype(np.int64), _LEVELS - 1)
        across -= column
        if len(slants) == 1:
            return (flat[column] * (1 - across) + flat[column + 1] * across,)
        up = np.interp(leaning, slants, np.arange(len(slants)))
        row = np.minimum(up.astype(np.int64), len(slants) - 2)
        up -= row
        at = row * (_LEVELS + 1) + column
        low = flat[at] * (1 - across) + flat[at + 1] * across
        at += _LEVELS + 1
        high = flat[at] * (1 - across) + flat[at + 1] * across
        return (low * (1 - up) + high * up,)

    return in_chunks(part, tone, slant_deg)[0]
