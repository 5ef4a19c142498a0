"""Pictures of the predicted print: the arguments and files that `print`, `demo` and `render` have in common."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..core.errors import OutputError
from ..core.pictures.viewing import DISTANCES_MM, TURNTABLE, VIEWS, PictureOptions, view_files
from .arguments import angle, path_ending_in, whole_number

_NAMES = (*VIEWS, TURNTABLE)
PREFIX = "render "
"""Of the kinds of output that are pictures: the rest is the view."""


def add_pictures(parser: argparse._ActionsContainer, named: bool = True) -> None:
    """Let the user choose pictures of the predicted print and how they are taken.

    Args:
        parser: where the arguments go.
        named: whether the user names the files; otherwise the command does.
    """
    if named:
        parser.add_argument("--render", type=path_ending_in(".png"), metavar="F.png", help="picture of the predicted "
                            "print, by Cycles")  # fmt: skip
        parser.add_argument("--contact-sheet", type=path_ending_in(".png"), metavar="F.png", help="texture on the "
                            "model | predicted print | predicted print at viewing distance")  # fmt: skip
    parser.add_argument("--views", type=views, default=(), metavar="VIEW,…", help="pictures F_VIEW.png of several "
                        f"sides instead of one: {', '.join(_NAMES)} (an animated F_turntable.gif)")  # fmt: skip
    parser.add_argument("--azimuth", type=angle, default=0.0, metavar="DEG", help="side of the model that is its front "
                        "in the pictures: 0 is -Y, 90 is +X, 180 is +Y (default: 0)")  # fmt: skip
    parser.add_argument("--distance", choices=tuple(DISTANCES_MM), default="", help="leave out what an eye does not "
                        "see any more: in the hand (300 mm), on the desk (700 mm), on a shelf (2 m)")  # fmt: skip
    parser.add_argument("--pixels", type=whole_number(100, 4000), default=900, metavar="N", help="width and height of "
                        "the pictures (default: 900, a turntable 480 at most)")  # fmt: skip
    parser.add_argument("--whole-plate", action="store_true", help="show supports, tower and skirt in the pictures too")


def views(text: str) -> tuple[str, ...]:
    """Names of views with commas between them.

    Raises:
        argparse.ArgumentTypeError: there is no such view, or none is named.
    """
    chosen = tuple(dict.fromkeys(name.strip() for name in text.split(",")))
    for name in chosen:
        if name not in _NAMES:
            raise argparse.ArgumentTypeError(f"{name!r} is not one of {', '.join(_NAMES)}")
    return chosen


def picture_outputs(args: argparse.Namespace, render: Path | None, sheet: Path | None) -> dict[str, Path]:
    """The pictures that are to be written, by kind.

    Raises:
        OutputError: views are named, but no file.
    """
    if args.views and render is None:
        raise OutputError("--views says which pictures to take, but not where to save them", "name a file by --render")
    found = {PREFIX + view: path for view, path in view_files(render, args.views).items()} if render else {}
    return found | ({"contact_sheet": sheet} if sheet else {})


def picture_options(args: argparse.Namespace) -> PictureOptions:
    """How they are to be taken."""
    return PictureOptions(
        azimuth_deg=args.azimuth,
        distance=args.distance,
        resolution=(args.pixels, args.pixels),
        whole_plate=args.whole_plate,
    )
