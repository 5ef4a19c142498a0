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
    outputs.add_argument("--x3g", type=path_ending_in(".x3g"), metavar="F.x3g", help="what the Replicator "
                         "2X reads from its card")  # fmt: skip
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
    obj: bpy.types.Object,
    image: bpy.types.Image | None,
    settings: PrintSettings,
    paths: dict[str, Path],
    files: OutputFiles,
    pictures: PictureOptions,
    others: Sequence[bpy.types.Object] = (),
    markers: Sequence[tuple[bpy.types.Object, SupportMark]] = (),
) -> DualColorPrint:
    """Compute the print of an object, or of several on a plate, then write what was asked for.

    Args:
        obj: the mesh object; it gives the print its name.
        image: a picture instead of the objects' own, or None.
        settings: of the print.
        paths: the path of each kind of output that is wanted, by a name of `OUTPUTS` or a picture's.
        files: where they are staged.
        pictures: how pictures are taken.
        others: the objects beside it.
        markers: objects that enforce or block supports.

    Raises:
        PrintError: the input cannot be printed, or a file cannot be written.
    """
    import bpy

    from ..bridge.input.plate import plate_model
    from ..bridge.quiet import quiet_stdout
    from ..bridge.strands.preview import build_preview
    from ..core import pipeline

    keep_inputs(paths.values(), _files_read(settings))
    objects = [obj, *others]
    model = plate_model(objects, bpy.context.evaluated_depsgraph_get(), settings, [image] * len(objects), markers)
    with Progress() as progress:
        result = pipeline.generate(model, settings, progress.show, begin_gcode="gcode" in paths)
        with quiet_stdout():
            result = _write(result, paths, files, progress)
            if strands_wanted(paths):
                progress.show(1.0, "building the strands")
                save_strands(build_preview(result, obj, others), paths, files, pictures, progress, model, settings)
    return result


def strands_wanted(paths: dict[str, Path]) -> bool:
    """Whether any output shows the strands."""
    return any(kind in ("blend", "mesh", "contact_sheet") or kind.startswith(PREFIX) for kind in paths)


def save_strands(
    strands: bpy.types.Collection,
    paths: dict[str, Path],
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

    if "mesh" in paths:
        progress.show(1.0, "writing the mesh")
        write_mesh(files.staged(paths["mesh"]), rods_of(strands))
    if "blend" in paths:
        save_blend(files.staged(paths["blend"]))
    views = {kind.removeprefix(PREFIX): files.staged(path) for kind, path in paths.items() if kind.startswith(PREFIX)}
    sheet = files.staged(paths["contact_sheet"]) if "contact_sheet" in paths else None
    if views or sheet:
        steps = picture_steps(strands, views, pictures, sheet, model, settings.background_tone)
        drained(steps, lambda step: progress.show(*step))


def _files_read(settings: PrintSettings) -> list[Path]:
    """The files of the scene's pictures, and the tone table."""
    import bpy

    pictures = [bpy.path.abspath(image.filepath) for image in bpy.data.images if image.filepath]
    return [Path(name) for name in [*pictures, settings.calibration_file] if name]


def _write(
    result: DualColorPrint,
    paths: dict[str, Path],
    files: OutputFiles,
    progress: Progress,
) -> DualColorPrint:
    from ..core import exports

    if "gcode" in paths:
        progress.show(1.0, "writing G-code")
        result = exports.export_gcode(result, files.staged(paths["gcode"]))
    if "x3g" in paths:
        result = exports.export_x3g(result, files.staged(paths["x3g"]))
    if "dump" in paths:
        exports.dump(result, files.staged(paths["dump"]))
    if "save_settings" in paths:
        write_file(files.staged(paths["save_settings"]), settings_json(result.settings).encode())
    if "report" in paths:
        text = json.dumps(result.report, indent=2, allow_nan=False) + "\n"
        write_file(files.staged(paths["report"]), text.encode())
    return result
