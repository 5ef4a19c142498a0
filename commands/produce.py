"""From an object in the scene to the files of its print: what `print` and `demo` have in common."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..core.files import OutputFiles, keep_inputs, write_file
from ..core.pictures.viewing import PictureOptions
from ..core.progress import drained
from ..core.settings import PrintSettings
from ..core.settings.presets import settings_json
from .arguments import chosen_outputs, gcode_path, path_ending_in
from .pictures import PREFIX, add_pictures, picture_outputs
from .terminal import Progress

if TYPE_CHECKING:
    import bpy

    from ..core.model import SupportMark, SurfaceModel
    from ..core.pipeline import DualColorPrint

NOTHING = "nothing is written: name the files that you want by --x3g, --gcode, --render, …"
OUTPUTS = ("gcode", "x3g", "blend", "mesh", "report", "dump", "save_settings")


def add_outputs(parser: argparse.ArgumentParser) -> None:
    """Let the user choose which files are written."""
    outputs = parser.add_argument_group("outputs")
    outputs.add_argument("--gcode", type=gcode_path, metavar="F.gcode", help="G-code for the printer")
    outputs.add_argument("--x3g", type=path_ending_in(".x3g"), metavar="F.x3g", help="what a MakerBot "
                         "Replicator reads from its card")  # fmt: skip
    outputs.add_argument("--blend", type=path_ending_in(".blend"), metavar="F.blend", help="Blender file with the "
                         "model and its strands")  # fmt: skip
    outputs.add_argument("--mesh", type=path_ending_in(".stl", ".obj"), metavar="F.stl|F.obj", help="mesh of the "
                         "predicted print, every strand a closed tube")  # fmt: skip
    outputs.add_argument("--report", type=Path, metavar="F.json", help="figures of the print")
    outputs.add_argument("--save-settings", type=Path, metavar="F.json", help="all settings, for --settings")
    outputs.add_argument("--dump", type=path_ending_in(".npz"), metavar="F.npz", help="outlines, waves and tones for "
                         "checks")  # fmt: skip
    add_pictures(outputs)


def named_outputs(args: argparse.Namespace) -> dict[str, Path]:
    """The path of each kind of output that the user named.

    Raises:
        OutputError: views are named, but no file for them.
    """
    return chosen_outputs(args, OUTPUTS) | picture_outputs(args, args.render, args.contact_sheet)


def produce(
    objects: Sequence[bpy.types.Object],
    images: Sequence[bpy.types.Image | None],
    settings: PrintSettings,
    files: OutputFiles,
    pictures: PictureOptions,
    markers: Sequence[tuple[bpy.types.Object, SupportMark]] = (),
) -> DualColorPrint:
    """Compute the print of an object, or of several on a plate, then write what was asked for.

    Args:
        objects: to print together; the first one gives the print its name.
        images: for each object a picture instead of its own, or None.
        settings: of the print.
        files: the outputs that are wanted; their kinds are names of `OUTPUTS` and pictures.
        pictures: how pictures are taken.
        markers: objects that enforce or block supports.

    Raises:
        PrintError: the input cannot be printed, or a file cannot be written.
    """
    import bpy

    from ..bridge.input.plate import plate_model
    from ..bridge.quiet import quiet_stdout
    from ..bridge.strands.preview import build_preview
    from ..core import pipeline

    keep_scene_files(files, settings)
    model = plate_model(objects, bpy.context.evaluated_depsgraph_get(), settings, images, markers)
    with Progress() as progress:
        result = pipeline.generate(model, settings, progress.show, begin_gcode="gcode" in files.paths)
        with quiet_stdout():
            result = _write(result, files, progress)
            if strands_wanted(files.paths):
                progress.show(1.0, "building the strands")
                strands = build_preview(result, objects[0], objects[1:])
                save_strands(strands, files, pictures, progress, model, settings)
    return result


def strands_wanted(paths: dict[str, Path]) -> bool:
    """Whether any output shows the strands."""
    return any(kind in ("blend", "mesh", "contact_sheet") or kind.startswith(PREFIX) for kind in paths)


def save_strands(
    strands: bpy.types.Collection,
    files: OutputFiles,
    pictures: PictureOptions,
    progress: Progress,
    model: SurfaceModel | None,
    settings: PrintSettings,
) -> None:
    """Save the scene with its strands, their mesh and their pictures, as far as asked for."""
    from ..bridge.blend_file import save_blend
    from ..bridge.pictures.views import picture_steps
    from ..bridge.strands.rods import rods_of
    from ..core.strands.mesh_files import write_mesh

    if "mesh" in files.paths:
        progress.show(1.0, "writing the mesh")
        write_mesh(files.staged("mesh"), rods_of(strands))
    if "blend" in files.paths:
        save_blend(files.staged("blend"))
    views = {kind.removeprefix(PREFIX): files.staged(kind) for kind in files.paths if kind.startswith(PREFIX)}
    sheet = files.staged("contact_sheet") if "contact_sheet" in files.paths else None
    if views or sheet:
        steps = picture_steps(strands, views, pictures, sheet, model, settings.background_tone)
        drained(steps, lambda step: progress.show(*step))


def keep_scene_files(files: OutputFiles, settings: PrintSettings) -> None:
    """Make sure that no output takes the place of a picture or linked file of the scene, or of the tone table.

    Raises:
        OutputError: one would.
    """
    import bpy

    blocks = [*bpy.data.images, *bpy.data.libraries]
    linked = [bpy.path.abspath(block.filepath, library=block.library) for block in blocks if block.filepath]
    keep_inputs(files.paths.values(), [Path(name) for name in [*linked, settings.calibration_file] if name])


def _write(result: DualColorPrint, files: OutputFiles, progress: Progress) -> DualColorPrint:
    from ..core import exports

    if "gcode" in files.paths:
        progress.show(1.0, "writing G-code")
        result = exports.export_gcode(result, files.staged("gcode"))
    if "x3g" in files.paths:
        result = exports.export_x3g(result, files.staged("x3g"))
    if "dump" in files.paths:
        exports.dump(result, files.staged("dump"))
    if "save_settings" in files.paths:
        write_file(files.staged("save_settings"), settings_json(result.settings).encode())
    if "report" in files.paths:
        text = json.dumps(result.report, indent=2, allow_nan=False) + "\n"
        write_file(files.staged("report"), text.encode())
    return result
