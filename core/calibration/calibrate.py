"""From the tone asked for to the tone to print: the stage in front of the modulation (paper, section 6.2)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..model import FloatArray
from ..pattern.chunks import in_chunks
from ..settings import PrintSettings
from .table import ToneTable, read_table

SHIPPED = Path(__file__).resolve().parent.parent.parent / "presets" / "calibration"
_LEVELS = 512
_LEAST_SHARED = 0.75  # of a slope's range, or of the upright wall's if that is smaller, is used at least
_HINT = "measure one with dualcolor measure and dualcolor build-table, or set calibration = none"


def calibrated(tone: FloatArray, slant_deg: FloatArray, settings: PrintSettings) -> tuple[FloatArray, list[str]]:
    """The tones to print so that the tones asked for are seen, face on, and what is to be said about the table.

    Args:
        tone: (N,) asked for, 0 black to 1 white.
        slant_deg: (N,) of the surface; overhangs count as upright.
        settings: calibration, calibration_file and gamut_mapping, and those that the table must hold for.

    Raises:
        CalibrationError: calibration_file cannot be read.
    """
    if settings.calibration == "none":
        return tone, []
    table = read_table(Path(settings.calibration_file)) if settings.calibration == "file" else shipped_table(settings)
    if table is None:
        return tone, [f"pattern {settings.pattern} has no tone table, its tones are printed as they are: {_HINT}"]
    differences = table.about.differences(settings)
    notes = [f"the tone table holds for other settings ({', '.join(differences)}): {_HINT}"] if differences else []
    if settings.calibration == "upright":
        table = table.upright
    ways = inverse(table, settings.gamut_mapping)
    return _looked_up(ways, table.slant_deg, tone, slant_deg), notes


def shipped_table(settings: PrintSettings) -> ToneTable | None:
    """Of the tables that come with the program the one for this pattern that fits best; None if there is none."""
    tables = [read_table(path) for path in sorted(SHIPPED.glob("*.json"))]
    tables = [table for table in tables if table.about.settings.get("pattern") == settings.pattern]
    return min(tables, key=lambda table: len(table.about.differences(settings)), default=None)


def targets(table: ToneTable, mapping: str, tone: FloatArray) -> FloatArray:
    """(S, K) the reflectance that stands for each tone asked for, on each slope.

    `compress` puts black and white, and all tones evenly between them, where an upright wall's darkest and lightest
    print are, whatever the picture uses of that range: so equal tones look equal in every print and, as far as they
    can, on every slope. A slope whose own range lies elsewhere gets them lighter or darker, just enough to show most of
    its range. `clip` takes the tones for the reflectance of the plastics themselves. What is out of reach prints as the
    nearest tone.

    Args:
        table: of which the least slope sets the printable range.
        mapping: "compress" or "clip".
        tone: (K,) 0 to 1.
    """
    if mapping == "clip":
        black, white = table.about.reflectance["Black"], table.about.reflectance["White"]
        return np.tile(black + tone * (white - black), (len(table.slant_deg), 1))
    low, high = table.reflectance[:, :1], table.reflectance[:, -1:]
    black, white = low[0, 0], high[0, 0]
    shared = _LEAST_SHARED * np.minimum(white - black, high - low)
    lighter = np.maximum(low + shared - white, 0.0)
    darker = np.maximum(black + shared - high, 0.0)
    return np.asarray(black + tone * (white - black) + lighter - darker)


def inverse(table: ToneTable, mapping: str) -> FloatArray:
    """(S, 513) the tone to print on each slope of the table for tones asked for from 0 to 1."""
    return table.printed(targets(table, mapping, np.linspace(0.0, 1.0, _LEVELS + 1)))


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
