"""`dualcolor render`: show the print in a file for the printer."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..core.files import OutputFiles
from .arguments import chosen_outputs, path_ending_in
from .pictures import add_pictures, picture_options, picture_outputs
from .produce import save_strands
from .terminal import Progress, load_blender

NAME = "render"
HELP = "show the print in a G-code or X3G file"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("file", type=Path, metavar="FILE", help=".gcode or .x3g file of a print")
    parser.add_argument("--blend", type=path_ending_in(".blend"), metavar="F.blend", help="Blender file with the "
                        "strands")  # fmt: skip
    parser.add_argument("--mesh", type=path_ending_in(".stl", ".obj"), metavar="F.stl|F.obj", help="mesh of the "
                        "predicted print, every strand a closed tube")  # fmt: skip
    add_pictures(parser)


def outputs(args: argparse.Namespace) -> dict[str, Path]:
    """The files that are to be written.

    Raises:
        OutputError: views are named, but no file for them.
    """
    return chosen_outputs(args, ("blend", "mesh")) | picture_outputs(args, args.render, args.contact_sheet)


def run(args: argparse.Namespace, files: OutputFiles) -> list[str]:
    """Read the file, save and render its strands.

    Raises:
        PrintError: the file is not one for this printer, or an output cannot be written.
    """
    load_blender()
    import bpy

    from ..bridge.quiet import quiet_stdout
    from ..bridge.strands.preview import build_preview
    from ..bridge.strands.print_file import read_print

    with quiet_stdout(), Progress() as progress:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        progress.show(0.0, "reading the file")
        read = read_print(args.file)
        shown = build_preview(read)
        save_strands(shown, files, picture_options(args), progress, None, read.settings)
    found = [f"{args.file.name}: {read.summary}"]
    return found if files.paths else [*found, "nothing is written: name the file that you want by --render, --blend, …"]
