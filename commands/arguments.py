"""Arguments that several commands share, and the kinds of values that they take."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ..core.settings import PrintSettings
from ..core.settings.presets import preset_files, preset_values, read_settings
from .terminal import load_blender


def add_settings(parser: argparse.ArgumentParser) -> None:
    """Let the user choose settings by preset, by file and one by one."""
    parser.add_argument("--preset", action="append", default=[], metavar="NAME", help="printer, filament, quality or "
                        f"pattern, repeatable: {', '.join(preset_files())}")  # fmt: skip
    parser.add_argument("--settings", type=Path, metavar="FILE", help="settings by name, as JSON, or a G-code file of "
                        "this program, to print with its settings")  # fmt: skip
    parser.add_argument("--set", action="append", default=[], type=assignment, metavar="KEY=VALUE", help="one setting, "
                        "repeatable; docs/settings.md lists them")  # fmt: skip


def add_stand(parser: argparse.ArgumentParser) -> None:
    """Let the user say how the models stand, how large they are, and what is painted on them."""
    picture = parser.add_mutually_exclusive_group()
    picture.add_argument("--texture", type=Path, metavar="IMAGE", help="picture to print instead of the model's own")
    picture.add_argument("--bake-material", action="store_true", help="print what the materials show with all their "
                         "nodes, not only the picture in them")  # fmt: skip
    parser.add_argument("--unwrap", choices=("smart", "xatlas"), help="make UVs if the mesh has none")
    parser.add_argument("--up", choices=("y", "z"), default="", help="axis of the file that points up (default: y for "
                        ".obj, .glb and .gltf, z for .stl, .ply and .blend)")  # fmt: skip
    for axis, what in (("x", "X axis, which points right"), ("y", "Y axis, which points back"), ("z", "vertical axis")):
        parser.add_argument(f"--rotate-{axis}", type=angle, default=0.0, metavar="DEG", help="turn the upright model "
                            f"about the {what}; first X, then Y, then Z")  # fmt: skip
    size = parser.add_mutually_exclusive_group()
    size.add_argument("--height-mm", type=positive, metavar="H", help="scale each file to this height (default: the "
                      "size in the file, one unit of an imported file being 1 mm)")  # fmt: skip
    size.add_argument("--scale", type=positive, default=1.0, metavar="F", help="scale each file by this factor: 25.4 "
                      "for inches, 1000 for meters")  # fmt: skip


def rotation(args: argparse.Namespace) -> tuple[float, float, float]:
    """The angles of `add_stand`, degrees."""
    return args.rotate_x, args.rotate_y, args.rotate_z


def chosen_settings(args: argparse.Namespace, **own: Any) -> PrintSettings:
    """Defaults, changed by the command's own, then by presets, then by a file, then by single assignments.

    Raises:
        SettingsError: a preset is unknown, the file holds something else, or a setting does not fit.
    """
    values = preset_values(args.preset, _own_presets(args.preset)) | (
        read_settings(args.settings) if args.settings is not None else {}
    )
    return PrintSettings().changed({**own, **values, **dict(args.set)})


def _own_presets(names: Sequence[str]) -> Path | None:
    """The folder of the user's own presets, if the names are not all those of the program's."""
    if set(names) <= set(preset_files()):
        return None
    load_blender()
    from ..bridge.preset_folder import user_presets

    return user_presets()


def chosen_outputs(args: argparse.Namespace, kinds: Sequence[str]) -> dict[str, Path]:
    """The path of each kind of output that was asked for by an option of that name."""
    return {kind: getattr(args, kind) for kind in kinds if getattr(args, kind) is not None}


def assignment(text: str) -> tuple[str, str]:
    """KEY=VALUE as a pair.

    Raises:
        argparse.ArgumentTypeError: there is no equals sign, or nothing before it.
    """
    key, equals, value = (part.strip() for part in text.partition("="))
    if not (key and equals):
        raise argparse.ArgumentTypeError(f"{text!r} is not KEY=VALUE")
    return key, value


def positive(text: str) -> float:
    """A number above zero.

    Raises:
        argparse.ArgumentTypeError: it is something else.
    """
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not (math.isfinite(number) and number > 0):
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive number")
    return number


def whole_number(low: int, high: int) -> Callable[[str], int]:
    """A kind of argument: whole numbers from `low` to `high`."""

    def number(text: str) -> int:
        if not text.isdecimal() or not low <= int(text) <= high:
            raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from {low} to {high}")
        return int(text)

    return number


def angle(text: str) -> float:
    """Degrees, any number of them.

    Raises:
        argparse.ArgumentTypeError: it is no number, or not a finite one.
    """
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise argparse.ArgumentTypeError(f"{text!r} is not an angle in degrees")
    return number


def path_ending_in(*suffixes: str) -> Callable[[str], Path]:
    """A kind of argument: paths with one of these suffixes only, since Blender and numpy would append theirs."""

    def path(text: str) -> Path:
        if Path(text).suffix.lower() not in suffixes:
            raise argparse.ArgumentTypeError(f"{text} does not end in {' or '.join(suffixes)}")
        return Path(text)

    return path


def gcode_path(text: str) -> Path:
    """A path for G-code, which may end in anything but what a printer reads from its card as X3G.

    Raises:
        argparse.ArgumentTypeError: it ends in .x3g.
    """
    if Path(text).suffix.lower() == ".x3g":
        raise argparse.ArgumentTypeError(f"{text} would hold G-code: --x3g writes X3G")
    return Path(text)
