"""`dualcolor analyze`: shows the pattern's seams, tracelines and slopes without printing anything."""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path
from typing import TYPE_CHECKING

from ..core.errors import OutputError
from ..core.files import OutputFiles, write_file
from ..core.pictures.viewing import TURNTABLE, VIEWS, png, view_files
from ..core.settings import PrintSettings
from .arguments import (
    add_settings,
    add_stand,
    angle,
    chosen_outputs,
    chosen_settings,
    path_ending_in,
    rotation,
    whole_number,
)
from .painted import chosen_pictures
from .pictures import views
from .produce import keep_scene_files
from .terminal import Progress, load_blender

if TYPE_CHECKING:
    import bpy

    from ..core.analysis.analysis import Analysis

NAME = "analyze"
HELP = "show seams, tracelines and slopes of the pattern, and which way up is best"
PICTURES = ("heatmap", "tracelines", "slopes")
_UPRIGHT = 1e-6  # by which the cosine of a direction that counts as upright may be less than 1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("model", type=Path, nargs="?", metavar="MODEL", help=".blend, .obj, .stl, .ply, .glb or .gltf "
                        "file (default: the program's own sample)")  # fmt: skip
    parser.add_argument("--object", default="", metavar="NAME", help="object to analyze (default: all meshes of an "
                        "imported file as one, the active mesh of a .blend)")  # fmt: skip
    add_stand(parser)
    add_settings(parser)
    outputs = parser.add_argument_group("outputs")
    outputs.add_argument("--report", type=Path, metavar="F.json", help="all figures")
    for name, what in zip(PICTURES, ("seam errors", "tracelines", "slopes too flat for tones"), strict=True):
        outputs.add_argument(f"--{name}", type=path_ending_in(".png"), metavar="F.png", help=f"picture of the {what}")
    outputs.add_argument("--views", type=views, default=(), metavar="VIEW,…", help="pictures F_VIEW.png of several "
                         f"sides instead of one: {', '.join(VIEWS)}")  # fmt: skip
    outputs.add_argument("--azimuth", type=angle, default=0.0, metavar="DEG", help="side of the model that is its "
                         "front in the pictures: 0 is -Y, 90 is +X, 180 is +Y (default: 0)")  # fmt: skip
    outputs.add_argument("--pixels", type=whole_number(100, 4000), default=900, metavar="N", help="longer side of "
                         "the pictures (default: 900)")  # fmt: skip


def outputs(args: argparse.Namespace) -> dict[str, Path]:
    """The files that are to be written: `report`, and `<picture> <view>` of each picture.

    Raises:
        OutputError: a turntable is asked for, or views of no picture.
    """
    if TURNTABLE in args.views:
        raise OutputError("an analysis has no turntable", "name sides by --views")
    paths = chosen_outputs(args, ("report",))
    pictures = chosen_outputs(args, PICTURES)
    if args.views and not pictures:
        raise OutputError("--views says which pictures to take, but not of what", "name a file by --heatmap, "
                          "--tracelines or --slopes")  # fmt: skip
    for name, path in pictures.items():
        paths |= {f"{name} {view}": file for view, file in view_files(path, args.views).items()}
    return paths


def run(args: argparse.Namespace, files: OutputFiles) -> list[str]:
    """Open the model, analyze it, draw it, and say what was found.

    Raises:
        PrintError: the input cannot be printed, or its pattern has no seams to draw.
    """
    settings = chosen_settings(args)
    load_blender()
    from ..bridge.quiet import quiet_stdout
    from ..core.analysis import figures

    draw = {
        "heatmap": figures.heatmap, "tracelines": figures.traceline_picture, "slopes": figures.slope_picture
    }  # fmt: skip
    with quiet_stdout(), Progress() as progress:
        found, notes = _analyzed(args, settings, files, progress)
        for number, kind in enumerate(files.paths):
            if kind == "report":
                text = json.dumps(found.report, indent=2, allow_nan=False) + "\n"
                write_file(files.staged(kind), text.encode())
                continue
            name, view = kind.split(" ", 1)
            progress.show(number / len(files.paths), f"drawing, {name}")
            azimuth, elevation = VIEWS[view]
            write_file(files.staged(kind), png(draw[name](found, (azimuth + args.azimuth, elevation), args.pixels)))
    return [*summary(found), *notes, *_orientations(found, args)]


def summary(found: Analysis) -> list[str]:
    """Seams, tracelines, slopes and warnings of an analysis, a line each."""
    report = found.report
    lines = [f"{report['name']}: {report['layers']} layers"]
    if (pattern := report["pattern"]) and (traced := report["tracelines"]):
        lines += [
            f"seams: {pattern['error_free']:.1%} free of error, {pattern['imperceptible']:.1%} imperceptible, "
            f"{pattern['salient']:.2%} salient; {pattern['discarded_probes']:,} of {pattern['probes']:,} probes "
            f"discarded ({pattern['discarded']:.1%})",
            *(
                [f"salient, weighted by how it is seen: {pattern['salient_seen']:.2%}"]
                if "salient_seen" in pattern
                else []
            ),
            f"tracelines: {traced['tracelines']:,}, {traced['births']:,} births, {traced['deaths']:,} deaths",
        ]
    slopes, faded = report["slopes"], report["faded"]
    lines += [
        f"wave or set-back faded for want of room: {faded['share']:.1%} of the outline; "
        f"outlines too short for the pattern: {report['too_short']['outlines']} of {report['too_short']['of']}",
        f"painted contrast on slopes from 20° to 30°: {slopes['contrast_degraded']:.1%}, flatter: "
        f"{slopes['contrast_gone']:.1%}",
    ]
    return [*lines, *(f"warning: {warning}" for warning in found.warnings)]


def _orientations(found: Analysis, args: argparse.Namespace) -> list[str]:
    """The best ways up, a line each, with the options that turn the model so."""
    lines = []
    for number, one in enumerate(found.orientations[:3], start=1):
        turning = turning_options(one.up, args)
        if turning and args.height_mm is not None:
            turning.append(f"--height-mm {one.height_mm:.4g}")
        lines.append(
            f"orientation {number}: {one.contrast:.0%} of the contrast shown, {one.support_mm2:.0f} mm² to support, "
            f"{one.height_mm:.0f} mm high: {' '.join(turning) or 'as it stands'}"
        )
    return lines


def turning_options(up: tuple[float, float, float], args: argparse.Namespace) -> list[str]:
    """Options that turn the model until a direction of the analyzed one points up; none if it does so already."""
    from mathutils import Matrix

    from ..bridge.input.model_file import rotation as matrix
    from ..core.analysis.orientation import upright

    if up[2] > 1 - _UPRIGHT:
        return []
    turned = (Matrix(upright(up).tolist()).to_4x4() @ matrix(rotation(args))).to_euler("XYZ")
    degrees = {axis: round(math.degrees(radians), 1) for axis, radians in zip("xyz", turned, strict=True)}
    options = [f"--rotate-{axis} {turn:g}" for axis, turn in degrees.items() if turn]
    # A model that stands upright without the options that were given needs one that says so.
    return options or (["--rotate-x 0"] if any(rotation(args)) else [])


def _analyzed(
    args: argparse.Namespace, settings: PrintSettings, files: OutputFiles, progress: Progress
) -> tuple[Analysis, list[str]]:
    """What was found, and warnings about the pictures."""
    import bpy

    from ..bridge.input.plate import plate_model
    from ..core.analysis.analysis import analyze

    obj = _opened(args)
    images, notes = chosen_pictures([obj], args, settings)
    keep_scene_files(files, settings)
    model = plate_model([obj], bpy.context.evaluated_depsgraph_get(), settings, images)
    return analyze(model, settings, progress.show), notes


def _opened(args: argparse.Namespace) -> bpy.types.Object:
    from ..bridge.input.model_file import open_model
    from ..bridge.objects.sample import make_sample

    if args.model is None:
        return make_sample()
    return open_model(args.model, args.object, args.up, args.height_mm, scale=args.scale, rotate_deg=rotation(args))
