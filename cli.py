"""The command line: `dualcolor print`, `render` and `demo`, alone or as `blender -b --command dualcolor …`."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .core.errors import OutputError, PrintError
from .core.outputs import OutputFiles
from .core.presets import preset_files, preset_values, read_settings, settings_json
from .core.settings import PrintSettings

if TYPE_CHECKING:
    import bpy

    from .core.pipeline import DualColorPrint

COMMAND = "dualcolor"
DONE, USER_ERROR, INTERRUPTED = 0, 1, 130
OUTPUTS = ("gcode", "x3g", "blend", "render", "report", "dump", "save_settings")

SUFFIXES = {"blend": ".blend", "render": ".png", "dump": ".npz"}

_handles: list[Any] = []


def main(argv: Sequence[str]) -> int:
    """Run one command and return its exit status: 0 done, 1 the user's error, 2 wrong usage.

    Args:
        argv: the arguments after the program's name.
    """
    parser = make_parser()
    try:
        args = parser.parse_args(list(argv))
        changes = [_assignment(parser, text) for text in args.set]
        _check_suffixes(parser, args)
    except SystemExit as stop:  # argparse has printed its message
        return int(stop.code or DONE)
    try:
        settings = _settings(args.preset, args.settings, dict(changes))
        paths = _outputs(args)
        with OutputFiles(paths.values()) as files:
            if args.command == "render":
                message = _render(args.file, paths, files)
            elif args.command == "demo":
                message = _summary(_demo(settings, paths, files))
            else:
                message = _summary(_print(args, settings, paths, files))
    except PrintError as problem:
        print("error:", " ".join(str(problem).split()), file=sys.stderr)
        return USER_ERROR
    except KeyboardInterrupt:
        return INTERRUPTED
    written = [f"wrote {path} ({_size(path.stat().st_size)})" for path in paths.values()]
    print("\n".join([*message, *written]))
    return DONE


def register_command() -> None:
    """Make the commands known to Blender."""
    import bpy

    _handles.append(bpy.utils.register_cli_command(COMMAND, main))


def unregister_command() -> None:
    """Take the commands back."""
    import bpy

    while _handles:
        bpy.utils.unregister_cli_command(_handles.pop())


def make_parser() -> argparse.ArgumentParser:
    """The arguments of all commands."""
    parser = argparse.ArgumentParser(prog=COMMAND, description="Print a picture on a shape with two filaments.")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    job = commands.add_parser("print", help="turn a textured model into a dual-colour print")
    job.add_argument("model", type=Path, metavar="MODEL", help=".blend, .obj, .stl, .ply, .glb or .gltf file")
    job.add_argument("--object", default="", metavar="NAME", help="object to print (default: all meshes of an "
                     "imported file, the active mesh of a .blend)")  # fmt: skip
    job.add_argument("--texture", type=Path, metavar="IMAGE", help="picture to print instead of the model's own")
    job.add_argument("--up", choices=("y", "z"), default="", help="axis of the file that points up (default: y for "
                     ".obj, .glb and .gltf, z for .stl, .ply and .blend)")  # fmt: skip
    job.add_argument("--height-mm", type=_positive, metavar="H", help="scale to this height (default: the size in the "
                     "file, one unit of an imported file being 1 mm)")  # fmt: skip
    job.add_argument("--unwrap", choices=("smart", "xatlas"), help="make UVs if the mesh has none")
    _add_settings(job)
    outputs = job.add_argument_group("outputs")
    outputs.add_argument("--gcode", type=Path, metavar="F.gcode", help="G-code for the Replicator 2X")
    outputs.add_argument("--x3g", type=Path, metavar="F.x3g", help="what the Replicator 2X reads from its card")
    outputs.add_argument("--blend", type=Path, metavar="F.blend", help="Blender file with the model and its strands")
    outputs.add_argument("--render", type=Path, metavar="F.png", help="picture of the predicted print, by Cycles")
    outputs.add_argument("--report", type=Path, metavar="F.json", help="figures of the print")
    outputs.add_argument("--save-settings", type=Path, metavar="F.json", help="all settings, for --settings")
    outputs.add_argument("--dump", type=Path, metavar="F.npz", help="outlines, waves and tones for checks")
    picture = commands.add_parser("render", help="show the print in a G-code or X3G file")
    picture.add_argument("file", type=Path, metavar="FILE", help=".gcode or .x3g file for the Replicator 2X")
    picture.add_argument("--blend", type=Path, metavar="F.blend", help="Blender file with the strands")
    picture.add_argument("--render", type=Path, metavar="F.png", help="picture of the predicted print, by Cycles")
    picture.set_defaults(set=[], preset=[], settings=None)
    demo = commands.add_parser("demo", help="print a sample that the program makes itself: Suzanne in a calico coat")
    demo.add_argument("--out", type=Path, default=Path("out"), metavar="DIR", help="folder of the files (default: out)")
    _add_settings(demo)
    return parser


def _add_settings(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--preset", action="append", default=[], metavar="NAME", help="printer, filament or quality, "
                        f"repeatable: {', '.join(preset_files())}")  # fmt: skip
    parser.add_argument("--settings", type=Path, metavar="FILE", help="settings by name, as JSON, or a G-code file of "
                        "this program, to print with its settings")  # fmt: skip
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="one setting, repeatable; "
                        "docs/settings.md lists them")  # fmt: skip


def _positive(text: str) -> float:
    number = float(text)
    if not (math.isfinite(number) and number > 0):
        raise ValueError
    return number


_positive.__name__ = "positive number"  # argparse puts it into its message


def _assignment(parser: argparse.ArgumentParser, text: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not equals:
        parser.error(f"argument --set: {text!r} is not KEY=VALUE")
    return key.strip(), value.strip()


def _check_suffixes(parser: argparse.ArgumentParser, args: argparse.Namespace) -> None:
    """Refuse names that Blender or numpy would change."""
    for kind, suffix in SUFFIXES.items():
        path = getattr(args, kind, None)
        if path is not None and path.suffix.lower() != suffix:
            parser.error(f"argument --{kind}: {path} does not end in {suffix}")


def _settings(presets: Sequence[str], path: Path | None, changes: dict[str, str]) -> PrintSettings:
    """Defaults, changed by presets, then by a file, then by single assignments.

    Raises:
        SettingsError: a preset is unknown, the file holds something else, or a setting does not fit.
    """
    values = preset_values(presets) | (read_settings(path) if path is not None else {})
    return PrintSettings().changed({**values, **changes})


def _outputs(args: argparse.Namespace) -> dict[str, Path]:
    """The path of each kind of output that was asked for.

    Raises:
        OutputError: the demo's folder cannot be made.
    """
    if args.command != "demo":
        return {kind: getattr(args, kind) for kind in OUTPUTS if getattr(args, kind, None) is not None}
    try:
        args.out.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise OutputError(f"the folder {args.out} cannot be made", problem.strerror or "") from None
    suffixes = {"gcode": ".gcode", "x3g": ".x3g", "blend": ".blend", "render": ".png", "report": ".json"}
    return {kind: args.out / f"suzanne{suffix}" for kind, suffix in suffixes.items()}


def _print(
    args: argparse.Namespace, settings: PrintSettings, paths: dict[str, Path], files: OutputFiles
) -> DualColorPrint:
    from .bridge.image_input import load_image
    from .bridge.model_file import open_model
    from .bridge.quiet import quiet_stdout
    from .bridge.unwrap import unwrap

    with quiet_stdout():
        obj = open_model(args.model, args.object, args.up, args.height_mm)
        if args.unwrap and obj.type == "MESH" and not obj.data.uv_layers:
            unwrap(obj, args.unwrap)
        image = load_image(args.texture) if args.texture else None
    return _produce(obj, image, settings, paths, files)


def _demo(settings: PrintSettings, paths: dict[str, Path], files: OutputFiles) -> DualColorPrint:
    from .bridge.quiet import quiet_stdout
    from .bridge.sample import make_sample

    with quiet_stdout(), _Progress() as progress:
        progress.show(0.0, "making the sample")
        obj = make_sample()
    return _produce(obj, None, settings, paths, files)


def _produce(
    obj: bpy.types.Object,
    image: bpy.types.Image | None,
    settings: PrintSettings,
    paths: dict[str, Path],
    files: OutputFiles,
) -> DualColorPrint:
    """Compute the print of an object, then write what was asked for."""
    import bpy

    from .bridge.mesh_input import surface_model
    from .bridge.quiet import quiet_stdout
    from .core import pipeline

    model = surface_model(obj, bpy.context.evaluated_depsgraph_get(), settings, image)
    with _Progress() as progress:
        result = pipeline.generate(model, settings, progress.show)
        with quiet_stdout():
            return _write(result, obj, paths, files, progress)


def _write(
    result: DualColorPrint,
    obj: bpy.types.Object,
    paths: dict[str, Path],
    files: OutputFiles,
    progress: _Progress,
) -> DualColorPrint:
    from .core import exports

    if "gcode" in paths:
        progress.show(1.0, "writing G-code")
        result = exports.export_gcode(result, files.staged(paths["gcode"]))
    if "x3g" in paths:
        result = exports.export_x3g(result, files.staged(paths["x3g"]))
    if "dump" in paths:
        exports.dump(result, files.staged(paths["dump"]))
    if "blend" in paths or "render" in paths:
        _show(result, obj, paths, files, progress)
    if "save_settings" in paths:
        files.staged(paths["save_settings"]).write_text(settings_json(result.settings), encoding="utf-8")
    if "report" in paths:
        text = json.dumps(result.report, indent=2, allow_nan=False) + "\n"
        files.staged(paths["report"]).write_text(text, encoding="utf-8")
    return result


def _show(
    result: DualColorPrint,
    obj: bpy.types.Object,
    paths: dict[str, Path],
    files: OutputFiles,
    progress: _Progress,
) -> None:
    """Strands in the scene, saved and rendered."""
    from .bridge.curves import build_preview

    progress.show(1.0, "building the strands")
    _save(build_preview(result, obj), paths, files, progress)


def _render(file: Path, paths: dict[str, Path], files: OutputFiles) -> list[str]:
    """Strands of a file, saved and rendered."""
    import bpy

    from .bridge.print_file import show_file
    from .bridge.quiet import quiet_stdout

    with quiet_stdout(), _Progress() as progress:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        progress.show(0.0, "reading the file")
        shown = show_file(file)
        _save(shown, paths, files, progress)
    return [f"{file.name}: {sum(len(held.data.curves) for held in shown.objects)} strands"]


def _save(strands: bpy.types.Collection, paths: dict[str, Path], files: OutputFiles, progress: _Progress) -> None:
    import bpy

    from .bridge.render import render_prediction

    if "blend" in paths:
        bpy.ops.wm.save_as_mainfile(filepath=str(files.staged(paths["blend"]).resolve()), copy=True, compress=True)
    if "render" in paths:
        progress.show(1.0, "rendering")
        render_prediction(strands, files.staged(paths["render"]))


def _summary(result: DualColorPrint) -> list[str]:
    report = result.report
    low, high = report["bounds_mm"]
    size = " × ".join(f"{b - a:.1f}" for a, b in zip(low, high, strict=True))
    hours, minutes = divmod(round(report["time_s"]["total"] / 60), 60)
    filament = report["filament"]
    return [
        f"{result.name}: {size} mm, {report['layers']} layers, {report['tool_changes']} tool changes",
        f"print time {hours} h {minutes:02d} min; filament {filament['tool0_g']:.1f} g in tool 0 (right nozzle), "
        f"{filament['tool1_g']:.1f} g in tool 1 (left nozzle)",
        *(f"warning: {warning}" for warning in result.warnings),
    ]


def _size(count: int) -> str:
    return f"{count / 1e6:.1f} MB" if count >= 1e6 else f"{count / 1e3:.1f} kB"


class _Progress:
    """One line on a terminal's stderr that is written over; nothing where stderr is no terminal."""

    def __init__(self) -> None:
        self._shown = sys.stderr.isatty()

    def __enter__(self) -> _Progress:
        return self

    def __exit__(self, *problem: object) -> None:
        self._write("")

    def show(self, share: float, stage: str) -> None:
        """Say how far the job is, `share` from 0 to 1."""
        self._write(f"{share:4.0%} {stage}")

    def _write(self, text: str) -> None:
        if self._shown:
            print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)
