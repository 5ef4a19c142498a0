"""From the tone asked for to the tone to print: the stage before the modulation (paper, section 6.2)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..contours.contours import POINTS_PER_WAVELENGTH
from ..errors import CalibrationError
from ..model import FloatArray
from ..parallel import CHUNK_ROWS
from ..records import dataclass
from ..settings import PrintSettings
from .gamut_mapping import image_range, printable_tones
from .table import ToneTable, read_table, slope_shares

SHIPPED = Path(__file__).resolve().parent.parent.parent / "presets" / "calibration"
# Resolution of the look-up table: steps from black to white, and degrees from slope to slope.
_LEVELS, _SLANT_STEP = 512, 0.25
_HINT = "measure one with dualcolor measure and dualcolor build-table, or set calibration = none"


@dataclass(frozen=True)
class ToneCurve:
    """From tones asked for to tones to print, on walls of S slopes.

    Attributes:
        to_print: (S, K) for K tones evenly spread from 0 to 1.
        slants: (S,) degrees.
    """

    to_print: FloatArray
    slants: FloatArray

    def printed(self, tone: FloatArray, slant_deg: FloatArray) -> FloatArray:
        """(N,) tones to print for the tones asked for (N,) on slopes (N,) degrees; each depends on no other.

        They are interpolated between tones, and taken for the nearest slope in steps of a quarter degree.
        """
        fine = np.arange(self.slants[0], self.slants[-1] + _SLANT_STEP, _SLANT_STEP)
        flat = np.einsum("fs,sl->fl", slope_shares(self.slants, fine), self.to_print).ravel()
        rise = np.diff(flat, append=flat[-1])
        printed = np.empty_like(tone)
        for begin in range(0, len(tone), CHUNK_ROWS):
            part = slice(begin, begin + CHUNK_ROWS)
            across = np.clip(tone[part], 0.0, 1.0) * _LEVELS
            column = across.astype(np.int64)
            across -= column
            row = np.clip((slant_deg[part] - self.slants[0]) * (1 / _SLANT_STEP) + 0.5, 0.0, len(fine) - 1.0)
            column += row.astype(np.int64) * self.to_print.shape[1]
            across *= rise.take(column)
            np.add(across, flat.take(column), out=printed[part])
        return printed


def tone_curve(tone: FloatArray, settings: PrintSettings) -> tuple[ToneCurve | None, list[str]]:
    """The curve from tones asked for to tones to print, None if they are the same; and notes about the table.

    Args:
        tone: (N,) asked for, at the points of all contours.
        settings: calibration, calibration_file and gamut_mapping are used, and those that the table must fit.

    Raises:
        CalibrationError: calibration_file cannot be read.
    """
    idle = settings.calibration_file and settings.calibration != "file"
    notes = ["calibration_file is not used; set calibration = file to print with it"] if idle else []
    if settings.calibration == "none":
        return None, notes
    table = table_for(settings)
    if differences := table.provenance.differences(settings):
        notes.append(f"the tone table holds for other settings ({', '.join(differences)}): {_HINT}")
    slants = table.slant_deg[:1] if settings.calibration == "upright" else table.slant_deg
    shown = image_range(tone, settings.layer_height * settings.wavelength / POINTS_PER_WAVELENGTH)
    to_print = printable_tones(np.linspace(0.0, 1.0, _LEVELS + 1), slants, table, shown, settings).printed
    return ToneCurve(to_print, slants), notes


def table_for(settings: PrintSettings) -> ToneTable:
    """The tone table of the pattern: the user's own, or the one that comes with the program.

    Raises:
        CalibrationError: calibration_file cannot be read.
    """
    if settings.calibration != "file":
        return shipped_table(settings)
    if not settings.calibration_file:
        hint = (
            "make one (in Blender: Read Calibration Photo; on the command line: read-photo, build-table) and choose it"
        )
        raise CalibrationError("calibration is file, but calibration_file names no tone table", hint)
    return read_table(Path(settings.calibration_file))


def shipped_table(settings: PrintSettings) -> ToneTable:
    """The table of the program that fits this pattern and its settings best."""
    tables = [read_table(path) for path in sorted((SHIPPED / settings.pattern).glob("*.json"))]
    return min(tables, key=lambda table: table.provenance.distance(settings))
