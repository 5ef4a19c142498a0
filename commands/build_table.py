"""`dualcolor build-table`: the tone table and the gamut maps that readings make."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..core.files import OutputFiles
from .arguments import path_ending_in

NAME = "build-table"
HELP = "make a tone table and gamut maps from what dualcolor measure has read"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder of the readings")
    parser.add_argument("--table", type=path_ending_in(".json"), metavar="F.json", help="the tone table (default: "
                        "DIR/table.json)")  # fmt: skip
    parser.add_argument("--maps", type=path_ending_in(".png"), metavar="F.png", help="picture of the gamut maps "
                        "(default: DIR/gamut_maps.png)")  # fmt: skip


def outputs(args: argparse.Namespace) -> dict[str, Path]:
    """The table and the picture."""
    return {"table": args.table or args.folder / "table.json", "maps": args.maps or args.folder / "gamut_maps.png"}


def run(args: argparse.Namespace, files: OutputFiles) -> list[str]:
    """Read all readings and write both.

    Raises:
        CalibrationError: there are none, or they are of different settings.
    """
    from ..core.calibration.gamut_maps import gamut_maps
    from ..core.calibration.sweep import read_sweeps
    from ..core.calibration.table import table_of, write_table

    sweeps = read_sweeps(args.folder)
    table = table_of(sweeps)
    write_table(files.staged("table"), table)
    gamut_maps(sweeps).save(files.staged("maps"))
    rows = zip(table.slant_deg, table.reflectance, table.noise, strict=True)
    return [f"slant {slant:g}°: {row[0]:.3f} to {row[-1]:.3f} ± {noise.max():.3f}" for slant, row, noise in rows]
