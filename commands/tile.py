"""`dualcolor tile`: the calibration tile, ready to print and to photograph."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..core.calibration.step_wedge import wedge_settings
from ..core.files import OutputFiles
from .arguments import add_settings, chosen_settings
from .pictures import picture_options
from .produce import NOTHING, add_outputs, named_outputs, produce
from .terminal import load_blender, summary

NAME = "tile"
HELP = "print the calibration tile, whose photograph dualcolor read-photo turns into a tone table"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_outputs(parser)
    add_settings(parser)


def outputs(args: argparse.Namespace) -> dict[str, Path]:
    """The files that are to be written."""
    return named_outputs(args)


def run(args: argparse.Namespace, files: OutputFiles) -> list[str]:
    """Make the tile, print it, and say what came out.

    Raises:
        PrintError: a setting does not fit, or a file cannot be written.
    """
    settings = wedge_settings(chosen_settings(args))
    load_blender()
    import bpy

    from ..bridge.objects.calibration_tile import tile_object
    from ..bridge.quiet import quiet_stdout
    from ..bridge.units import use_millimeters

    with quiet_stdout():
        bpy.ops.wm.read_factory_settings(use_empty=True)
        use_millimeters(bpy.context.scene)
        obj = tile_object(settings)
    lines = summary(produce([obj], [None], settings, files, picture_options(args)))
    return lines if files.paths else [*lines, NOTHING]
