"""The whole way from a photograph's file to a tone table."""

from __future__ import annotations

from pathlib import Path

from ..model import FloatArray
from ..records import dataclass
from ..settings import PrintSettings
from .calibrate import shipped_table
from .marks import checked_corners, find_marks
from .photo_table import read_wedge, wedge_table
from .photograph import read_photograph
from .table import ToneTable, read_table


@dataclass(frozen=True)
class PhotoTable:
    """The tone table read from a calibration photograph.

    Attributes:
        table: of the printer and its filaments.
        marks: (4, 2) pixels of the corner marks, x to the right and y down, clockwise from the tile's upper left.
        notes: about the photograph, one sentence each.
    """

    table: ToneTable
    marks: FloatArray
    notes: list[str]


def table_of_photo(
    path: Path,
    settings: PrintSettings,
    corners: FloatArray | None = None,
    ends: tuple[float, float] | None = None,
    simulated: Path | None = None,
    as_stored: bool = False,
) -> PhotoTable:
    """Read a photograph of the printed calibration tile.

    Args:
        path: of the photograph.
        settings: that the tile was printed with.
        corners: (4, 2) pixels near the crossings of the corner marks, clockwise; None to look for them.
        ends: reflectance of the printed black and white, linear; None to take the simulation's.
        simulated: a table made by `measure` for these settings; None for the one of the program.
        as_stored: see `read_photograph`.

    Raises:
        CalibrationError: the photograph cannot be read, shows no tile, or shows it badly.
        TextureError: it is too large.
    """
    base = shipped_table(settings) if simulated is None else read_table(simulated)
    photo = read_photograph(path, as_stored)
    marks = find_marks(photo, settings) if corners is None else checked_corners(photo, corners, settings)
    reading = read_wedge(photo, marks, settings)
    table = wedge_table(reading, settings, base, ends, f"photograph {path.name}")
    notes = list(reading.notes)
    if len(table.slant_deg) == 1 < len(base.slant_deg):
        notes.append(
            "the table is of an upright wall alone, and slopes are printed by it too: no simulation fits the settings ("
            + ", ".join(base.provenance.differences(settings)) + ")"
        )  # fmt: skip
    return PhotoTable(table, marks, notes)
