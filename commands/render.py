"""`dualcolor render`: show the print in a file for the printer."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..core.outputs import OutputFiles
from .arguments import chosen_outputs, path_ending_in
from .produce import save_preview
from .terminal import Progress

NAME = "render"
HELP = "show the print in a G-code or X3G file"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("file", type=Path, metavar="FILE", help=".gcode or .x3g file for the Replicator 2X")
    parser.add_argument("--blend", type=path_ending_in(".blend"), metavar="F.blend", help="Blender file with the "
                        "strands")  # fmt: skip
    parser.add_argument("--render", type=path_ending_in(".png"), metavar="F.png", help="picture of the predicted "
                        "print, by Cycles")  # fmt: skip


def outputs(args: argparse.Namespace) -> dict[str, Path]:
    """The files that are to be written."""
    return chosen_outputs(args, ("blend", "render"))


def run(args: argparse.Namespace, paths: dict[str, Path], files: OutputFiles) -> list[str]:
    """Read the file, save and render its strands.

    Raises:
        PrintError: the file is not one for this printer, or an output cannot be written.
    """
    import bpy

    from ..bridge.print_file import show_file
    from ..bridge.quiet import quiet_stdout

    with quiet_stdout(), Progress() as progress:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        progress.show(0.0, "reading the file")
        shown = show_file(args.file)
        save_preview(shown, paths, files, progress)
    return [f"{args.file.name}: {sum(len(held.data.curves) for held in shown.objects)} strands"]
