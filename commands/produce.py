"""From an object in the scene to the files of its print: what `print` and `demo` have in common."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

from ..core.outputs import OutputFiles
from ..core.presets import settings_json
from ..core.settings import PrintSettings
from .arguments import path_ending_in
from .terminal import Progress

if TYPE_CHECKING:
    import bpy

    from ..core.pipeline import DualColorPrint

OUTPUTS = ("gcode", "x3g", "blend", "render", "report", "dump", "save_settings")


def add_outputs(parser: argparse.ArgumentParser) -> None:
    """Let the user choose which files are written."""
    outputs = parser.add_argument_group("outputs")
    outputs.add_argument("--gcode", type=Path, metavar="F.gcode", help="G-code for the Replicator 2X")
    outputs.add_argument("--x3g", type=Path, metavar="F.x3g", help="what the Replicator 2X reads from its card")
    outputs.add_argument("--blend", type=path_ending_in(".blend"), metavar="F.blend", help="Blender file with the "
                         "model and its strands")  # fmt: skip
    outputs.add_argument("--render", type=path_ending_in(".png"), metavar="F.png", help="picture of the predicted "
                         "print, by Cycles")  # fmt: skip
    outputs.add_argument("--report", type=Path, metavar="F.json", help="figures of the print")
    outputs.add_argument("--save-settings", type=Path, metavar="F.json", help="all settings, for --settings")
    outputs.add_argument("--dump", type=path_ending_in(".npz"), metavar="F.npz", help="outlines, waves and tones for "
                         "checks")  # fmt: skip


def produce(
    obj: bpy.types.Object,
    image: bpy.types.Image | None,
    settings: PrintSettings,
    paths: dict[str, Path],
    files: OutputFiles,
) -> DualColorPrint:
    """Compute the print of an object, then write what was asked for.

    Args:
        obj: the mesh object.
        image: a picture instead of the object's own, or None.
        settings: of the print.
        paths: the path of each kind of output that is wanted, by a name of `OUTPUTS`.
        files: where they are staged.

    Raises:
        PrintError: the input cannot be printed, or a file cannot be written.
    """
    import bpy

    from ..bridge.mesh_input import surface_model
    from ..bridge.quiet import quiet_stdout
    from ..core import pipeline

    model = surface_model(obj, bpy.context.evaluated_depsgraph_get(), settings, image)
    with Progress() as progress:
        result = pipeline.generate(model, settings, progress.show)
        with quiet_stdout():
            return _write(result, obj, paths, files, progress)


def save_preview(strands: bpy.types.Collection, paths: dict[str, Path], files: OutputFiles, progress: Progress) -> None:
    """Save the scene with its strands, and render them, as far as asked for."""
    import bpy

    from ..bridge.render import render_prediction

    if "blend" in paths:
        bpy.ops.wm.save_as_mainfile(filepath=str(files.staged(paths["blend"]).resolve()), copy=True, compress=True)
    if "render" in paths:
        progress.show(1.0, "rendering")
        render_prediction(strands, files.staged(paths["render"]))


def _write(
    result: DualColorPrint,
    obj: bpy.types.Object,
    paths: dict[str, Path],
    files: OutputFiles,
    progress: Progress,
) -> DualColorPrint:
    from ..bridge.curves import build_preview
    from ..core import exports

    if "gcode" in paths:
        progress.show(1.0, "writing G-code")
        result = exports.export_gcode(result, files.staged(paths["gcode"]))
    if "x3g" in paths:
        result = exports.export_x3g(result, files.staged(paths["x3g"]))
    if "dump" in paths:
        exports.dump(result, files.staged(paths["dump"]))
    if "blend" in paths or "render" in paths:
        progress.show(1.0, "building the strands")
        save_preview(build_preview(result, obj), paths, files, progress)
    if "save_settings" in paths:
        files.staged(paths["save_settings"]).write_text(settings_json(result.settings), encoding="utf-8")
    if "report" in paths:
        text = json.dumps(result.report, indent=2, allow_nan=False) + "\n"
        files.staged(paths["report"]).write_text(text, encoding="utf-8")
    return result
