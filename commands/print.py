"""`dualcolor print`: turn a textured model into a dual-colour print."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..core.outputs import OutputFiles
from .arguments import add_settings, chosen_settings, positive
from .pictures import picture_options
from .produce import add_outputs, named_outputs, produce
from .terminal import summary

NAME = "print"
HELP = "turn a textured model into a dual-colour print"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("model", type=Path, metavar="MODEL", help=".blend, .obj, .stl, .ply, .glb or .gltf file")
    parser.add_argument("--object", default="", metavar="NAME", help="object to print (default: all meshes of an "
                        "imported file, the active mesh of a .blend)")  # fmt: skip
    parser.add_argument("--texture", type=Path, metavar="IMAGE", help="picture to print instead of the model's own")
    parser.add_argument("--up", choices=("y", "z"), default="", help="axis of the file that points up (default: y for "
                        ".obj, .glb and .gltf, z for .stl, .ply and .blend)")  # fmt: skip
    parser.add_argument("--height-mm", type=positive, metavar="H", help="scale to this height (default: the size in "
                        "the file, one unit of an imported file being 1 mm)")  # fmt: skip
    parser.add_argument("--unwrap", choices=("smart", "xatlas"), help="make UVs if the mesh has none")
    add_settings(parser)
    add_outputs(parser)


def outputs(args: argparse.Namespace) -> dict[str, Path]:
    """The files that are to be written.

    Raises:
        OutputError: views are named, but no file for them.
    """
    return named_outputs(args)


def run(args: argparse.Namespace, paths: dict[str, Path], files: OutputFiles) -> list[str]:
    """Open the model, print it, and say what came out.

    Raises:
        PrintError: the input cannot be printed, or a file cannot be written.
    """
    settings = chosen_settings(args)
    from ..bridge.image_input import load_image
    from ..bridge.model_file import open_model
    from ..bridge.quiet import quiet_stdout
    from ..bridge.unwrap import unwrap

    with quiet_stdout():
        obj = open_model(args.model, args.object, args.up, args.height_mm)
        if args.unwrap and obj.type == "MESH" and not obj.data.uv_layers:
            unwrap(obj, args.unwrap)
        image = load_image(args.texture) if args.texture else None
    return summary(produce(obj, image, settings, paths, files, picture_options(args)))
