"""Tone tables made by hand."""

import numpy as np
from dualcolor.core.calibration.calibrate import tone_curve
from dualcolor.core.calibration.gamut_mapping import WHOLE_RANGE, printable_tones
from dualcolor.core.calibration.provenance import Provenance, tone_settings
from dualcolor.core.calibration.table import ToneTable
from dualcolor.core.model import FloatArray
from dualcolor.core.settings import PrintSettings

DEFAULT = PrintSettings()
PROVENANCE = Provenance(tone_settings(DEFAULT), {"Black": 0.0, "White": 1.0}, "a test")
TONE = np.linspace(0, 1, 11)


def table(*rows, slants=None, tone=TONE):
    rows = np.array(rows)
    slants = np.arange(len(rows)) * 30.0 if slants is None else np.array(slants)
    return ToneTable(tone, slants, rows, np.full(rows.shape, 0.001), PROVENANCE)


def inverse(made, mapping="compress", shown=WHOLE_RANGE):
    """(S, 513) the tone to print for tones from 0 to 1 on each slope of the table."""
    chosen = PrintSettings(gamut_mapping=mapping)
    return printable_tones(np.linspace(0, 1, 513), made.slant_deg, made, shown, chosen).printed


def calibrated(tone: FloatArray, slant_deg: FloatArray, settings: PrintSettings) -> tuple[FloatArray, list[str]]:
    """The tones to print so that, seen face on, they look like those asked for; and notes about the table.

    Args:
        tone: (N,) asked for, 0 black to 1 white, at the points of all contours.
        slant_deg: (N,) of the surface; overhangs count as upright.
        settings: see `tone_curve`.

    Raises:
        CalibrationError: calibration_file cannot be read.
    """
    curve, notes = tone_curve(tone, settings)
    return tone if curve is None else curve.printed(tone, slant_deg), notes
