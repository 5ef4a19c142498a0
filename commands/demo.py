"""`dualcolor demo`: the main job on a sample that the program makes itself."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..core.files import OutputFiles, make_folder
from .arguments import add_settings, chosen_settings
from .pictures import add_pictures, picture_options, picture_outputs
from .produce import produce
from .terminal import Progress, load_blender, summary

NAME = "demo"
HELP = "print a sample that the program makes itself: Suzanne in a calico coat"
SUFFIXES = {"gcode": ".gcode", "x3g": ".x3g", "blend": ".blend", "report": ".json"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("--out", type=Path, default=Path("out"), metavar="DIR", help="folder of the files (default: "
                        "out)")  # fmt: skip
    add_settings(parser)
    add_pictures(parser, named=False)


def outputs(args: argparse.Namespace) -> dict[str, Path]:
    """The files that are to be written; their folder is made.

    Raises:
        OutputError: the folder cannot be made.
    """
    make_folder(args.out)
    named = {kind: args.out / f"suzanne{suffix}" for kind, suffix in SUFFIXES.items()}
    return named | picture_outputs(args, args.out / "suzanne.png", None)


def run(args: argparse.Namespace, files: OutputFiles) -> list[str]:
    """Make the sample, print it, with supports under ears and chin, and say what came out.

    Raises:
        PrintError: a setting does not fit, or a file cannot be written.
    """
    settings = chosen_settings(args, support_enable=True)
    load_blender()
    from ..bridge.objects.sample import make_sample
    from ..bridge.quiet import quiet_stdout

    with quiet_stdout(), Progress() as progress:
        progress.show(0.0, "making the sample")
        obj = make_sample()
    return summary(produce([obj], [None], settings, files, picture_options(args)))
