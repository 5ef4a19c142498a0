"""`dualcolor read-photo`: a tone table from a photograph of the printed calibration tile."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import numpy as np

from ..core.errors import SettingsError
from ..core.files import OutputFiles
from .arguments import add_settings, chosen_settings, path_ending_in

NAME = "read-photo"
HELP = "make a tone table from a photograph of the calibration tile, printed by dualcolor tile"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("photo", type=Path, metavar="PHOTO", help="JPEG or PNG, the whole tile from the front in soft "
                        "light")  # fmt: skip
    parser.add_argument("--out", type=path_ending_in(".json"), required=True, metavar="F.json", help="the tone table")
    parser.add_argument("--corners", type=_place, nargs=4, metavar="X,Y", help="where the squares of the four corner "
                        "marks meet, clockwise, in pixels from the upper left (default: looked for)")  # fmt: skip
    parser.add_argument("--black", type=float, metavar="R", help="reflectance of the printed black patches, 0 to 1")
    parser.add_argument("--white", type=float, metavar="R", help="reflectance of the printed white patches, 0 to 1 "
                        "(default: both as simulated)")  # fmt: skip
    parser.add_argument("--simulated", type=Path, metavar="F.json", help="a table made by dualcolor build-table for "
                        "the tile's settings, for slopes (default: the one that comes with the program)")  # fmt: skip
    add_settings(parser)


def outputs(args: argparse.Namespace) -> dict[str, Path]:
    """The table."""
    return {"table": args.out}


def run(args: argparse.Namespace, files: OutputFiles) -> list[str]:
    """Read the photograph, write the table.

    Raises:
        PrintError: a setting does not fit, or the photograph cannot be read, shows no tile, or shows it badly.
    """
    from ..core.calibration.read_photo import table_of_photo
    from ..core.calibration.table import write_table

    corners = None if args.corners is None else np.array(args.corners)
    made = table_of_photo(args.photo, chosen_settings(args), corners, _ends(args), args.simulated)
    write_table(files.staged("table"), made.table)
    row, noise = made.table.reflectance[0], float(made.table.noise[0].max())
    at = " ".join(f"{x:.0f},{y:.0f}" for x, y in made.marks)
    return [
        f"corner marks at {at}",
        *(f"warning: {note}" for note in made.notes),
        f"upright wall: {row[0]:.3f} to {row[-1]:.3f} ± {noise:.3f}, slants up to {made.table.slant_deg[-1]:g}°",
    ]


def _ends(args: argparse.Namespace) -> tuple[float, float] | None:
    if args.black is None and args.white is None:
        return None
    if args.black is None or args.white is None or not 0 <= args.black < args.white <= 1:
        raise SettingsError("--black and --white do not fit together", "give both, 0 <= black < white <= 1")
    return args.black, args.white


def _place(text: str) -> tuple[float, float]:
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        x = y = math.nan
    if not (math.isfinite(x) and math.isfinite(y)):
        raise argparse.ArgumentTypeError(f"{text!r} is not X,Y")
    return x, y
