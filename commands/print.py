"""`dualcolor print`: turn a textured model into a dual-color print."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..core.files import OutputFiles
from ..core.model import SupportMark
from .arguments import add_settings, add_stand, chosen_settings, rotation
from .painted import chosen_pictures
from .pictures import picture_options
from .produce import NOTHING, add_outputs, named_outputs, produce
from .terminal import load_blender, summary

NAME = "print"
HELP = "turn a textured model into a dual-color print"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("model", type=Path, nargs="+", metavar="MODEL", help=".blend, .obj, .stl, .ply, .glb or .gltf "
                        "file; several are printed on one plate")  # fmt: skip
    parser.add_argument("--object", action="append", default=[], metavar="NAME", help="object to print, repeatable "
                        "(default: all meshes of an imported file as one, the active mesh of a .blend)")  # fmt: skip
    parser.add_argument("--arrange", action="store_true", help="put several objects side by side; else they keep their "
                        "places")  # fmt: skip
    parser.epilog = "Example: dualcolor print cow.obj --height-mm 60 --set support_enable=true --x3g cow.x3g"
    add_stand(parser)
    for mark, what in (("enforcer", "there are supports"), ("blocker", "there are none")):
        parser.add_argument(f"--support-{mark}", action="append", default=[], metavar="FILE", help="model file, or "
                            f"object of a .blend, in whose inside {what}, repeatable")  # fmt: skip
    add_settings(parser)
    add_outputs(parser)


def outputs(args: argparse.Namespace) -> dict[str, Path]:
    """The files that are to be written.

    Raises:
        OutputError: views are named, but no file for them.
    """
    return named_outputs(args)


def run(args: argparse.Namespace, files: OutputFiles) -> list[str]:
    """Open the models, print them, and say what came out.

    Raises:
        PrintError: the input cannot be printed, or a file cannot be written.
    """
    settings = chosen_settings(args)
    if args.arrange:
        settings = settings.changed({"arrange": True})
    load_blender()
    from ..bridge.input.marker_file import open_marker
    from ..bridge.input.model_file import open_models
    from ..bridge.quiet import quiet_stdout

    with quiet_stdout():
        objects = open_models(
            args.model, args.object, args.up, args.height_mm, scale=args.scale, rotate_deg=rotation(args)
        )
        images, notes = chosen_pictures(objects, args, settings)
        named = {SupportMark.ENFORCER: args.support_enforcer, SupportMark.BLOCKER: args.support_blocker}
        markers = [
            (open_marker(name, objects[0], args.up, rotation(args)), mark)
            for mark, names in named.items()
            for name in names
        ]
    lines = summary(produce(objects, images, settings, files, picture_options(args), markers)) + notes
    return lines if files.paths else [*lines, NOTHING]
