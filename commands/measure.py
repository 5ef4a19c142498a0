"""`dualcolor measure`: print calibration tiles in the computer and read their tones from all sides."""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from ..core.calibration.sweep import BLOCKS, read_sweep, sweep_path, write_sweep
from ..core.errors import CalibrationError
from ..core.files import OutputFiles, make_folder
from .arguments import add_settings, chosen_settings
from .terminal import Progress, load_blender

NAME = "measure"
HELP = "measure what tones look like on walls of several slopes, from several sides"

SLANTS = tuple(float(slant) for slant in range(0, 81, 10))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("--slants", type=slants, default=SLANTS, metavar="DEG,DEG,…", help="how far the tiles lean "
                        "back (default: 0 to 80 in steps of 10)")  # fmt: skip
    parser.add_argument("--blocks", type=blocks, default=("phi", "theta"), metavar="NAME,NAME", help="directions: phi "
                        "(from above and below), theta (from the sides), face (face on alone, all that a tone table "
                        "needs) (default: phi,theta)")  # fmt: skip
    parser.add_argument("--light", choices=("even", "lamp"), default="even", help="from all sides alike, or half of "
                        "it from a lamp (default: even)")  # fmt: skip
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder of the readings; what it holds "
                        "already is not measured again")  # fmt: skip
    add_settings(parser)


def outputs(args: argparse.Namespace) -> dict[str, Path]:
    """No files that appear together: every job writes its own when it is done."""
    return {}


def run(args: argparse.Namespace, files: OutputFiles) -> list[str]:
    """Do the jobs that are not done yet.

    Raises:
        PrintError: a setting does not fit, or the folder cannot be written or holds readings of other settings.
    """
    load_blender()
    import bpy

    from ..bridge.measuring.gonioreflectometer import measure, provenance
    from ..bridge.quiet import quiet_stdout

    settings = chosen_settings(args)
    make_folder(args.out)
    jobs = [(slant, block) for slant in args.slants for block in args.blocks]
    wanted, lines = provenance(settings, args.light), []
    with Progress() as progress:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        for number, (slant, block) in enumerate(jobs):
            path = sweep_path(args.out, slant, block)
            if path.exists():
                if read_sweep(path).provenance != wanted:
                    raise CalibrationError(f"{path} was measured otherwise", "give another folder, or remove it")
                lines.append(f"{path}: done before")
                continue
            progress.show(number / len(jobs), f"slant {slant:g}°, {block}")
            begin = time.monotonic()
            with quiet_stdout():
                write_sweep(path, measure(slant, block, settings, args.light))
            lines.append(f"{path}: {time.monotonic() - begin:.0f} s")
    return lines


def slants(text: str) -> tuple[float, ...]:
    """Angles, separated by commas.

    Raises:
        argparse.ArgumentTypeError: one is no number from 0 to 85.
    """
    try:
        angles = tuple(float(part) for part in text.split(","))
    except ValueError:
        angles = (-1.0,)
    if not all(0.0 <= angle <= 85.0 for angle in angles):
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of angles from 0 to 85")
    return angles


def blocks(text: str) -> tuple[str, ...]:
    """Names of blocks, separated by commas.

    Raises:
        argparse.ArgumentTypeError: one is unknown.
    """
    names = tuple(part.strip() for part in text.split(","))
    if not set(names) <= set(BLOCKS):
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of {', '.join(BLOCKS)}")
    return names
