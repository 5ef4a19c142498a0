"""`dualcolor plate`: pictures on plates, printed in several patterns, photographed and measured."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from ..core.errors import SettingsError
from ..core.files import OutputFiles, make_folder, write_file
from ..core.pattern.modulation import PERIOD_LAYERS
from ..core.pictures.match import PictureMatch
from ..core.pictures.shapes import PictureShape, fitted, picture_plate
from ..core.settings import PrintSettings
from .arguments import add_settings, chosen_settings, positive, whole_number
from .terminal import Progress, load_blender

NAME = "plate"
HELP = "put pictures on plates, predict their prints in each pattern and measure how well they show the picture"
PATTERNS = {"wave": "paper", "wave_offset": "waves_set_back", "offset": "set_back"}
"""The preset that each pattern is printed with."""
TABLE = "plates"
MOST_PIXELS = 50_000_000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("images", type=Path, nargs="+", metavar="IMAGE", help="picture file")
    parser.add_argument("--out", type=Path, default=Path("out"), metavar="DIR", help="folder of the files (default: "
                        "out)")  # fmt: skip
    parser.add_argument("--width", type=positive, default=30.0, metavar="MM", help="of the picture, which is cut to "
                        "fit (default: 30)")  # fmt: skip
    parser.add_argument("--height", type=positive, default=35.5, metavar="MM", help="of the picture (default: 35.5)")
    parser.add_argument("--thickness", type=positive, default=2.0, metavar="MM", help="of the plate (default: 2)")
    parser.add_argument("--patterns", type=_patterns, default=tuple(PATTERNS), metavar="NAMES", help="with commas "
                        f"between them (default: {','.join(PATTERNS)})")  # fmt: skip
    parser.add_argument("--plain-contrast", action="store_true", help="leave the tones as they are, instead of "
                        "stretching them from black to white")  # fmt: skip
    parser.add_argument("--mm-per-pixel", type=positive, default=0.05, metavar="MM", help="of the photographs "
                        "(default: 0.05)")  # fmt: skip
    parser.add_argument(
        "--samples", type=whole_number(1, 4096), default=4, metavar="N", help="rays a pixel (default: 4)"
    )
    parser.add_argument("--gcode", action="store_true", help="write the plates' G-code too")
    add_settings(parser)


def outputs(args: argparse.Namespace) -> dict[str, Path]:
    """The files that are to be written; their folder is made.

    Raises:
        OutputError: the folder cannot be made.
    """
    make_folder(args.out)
    paths = {"table": args.out / f"{TABLE}.md", "report": args.out / f"{TABLE}.json"}
    for image in args.images:
        paths[_sheet(image)] = args.out / f"{TABLE}_{image.stem}.png"
        if args.gcode:
            paths |= {_gcode(image, name): args.out / f"{image.stem}_{name}.gcode" for name in args.patterns}
    return paths


def run(args: argparse.Namespace, files: OutputFiles) -> list[str]:
    """Print, photograph and measure all plates.

    Raises:
        PrintError: an image cannot be read, a plate cannot be printed, or a file cannot be written.
    """
    settings = _settings(args)
    plate = picture_plate(args.width, args.height, args.thickness, settings)
    widest = 2 * settings.wavelength  # that a wave can be
    if min(plate.size[0] / widest, plate.size[1] / (PERIOD_LAYERS * settings.layer_height)) < 3:
        raise SettingsError("the plate is smaller than three periods of the pattern", "make it larger")
    if (pixels := plate.size[0] * plate.size[1] / args.mm_per_pixel**2) > MOST_PIXELS:
        raise SettingsError(f"a photograph would have {pixels / 1e6:,.0f} million pixels", "raise --mm-per-pixel")
    if args.mm_per_pixel > settings.layer_height:
        raise SettingsError("a pixel of the photographs is higher than a layer", "lower --mm-per-pixel")
    load_blender()
    rows: list[tuple[str, str, PictureMatch]] = []
    with Progress() as progress:
        for number, image in enumerate(args.images):
            found = _plates(args, image, plate, files, (progress, number))
            rows += [(image.name, pattern, match) for pattern, match in found.items()]
    _write_tables(args, rows, plate, settings, files)
    return [
        f"{name} {pattern}: r {match.correlation:.3f}, by texel {match.texel_correlation:.3f}, "
        f"contrast {match.contrast:.2f}"
        for name, pattern, match in rows
    ]


def _settings(args: argparse.Namespace, *presets: str) -> PrintSettings:
    """Those chosen; presets that are named here come before all others."""
    chosen = chosen_settings(argparse.Namespace(**{**vars(args), "preset": [*presets, *args.preset]}))
    return chosen.changed({"texture_filter": "lanczos"})


def _plates(
    args: argparse.Namespace,
    image: Path,
    plate: PictureShape,
    files: OutputFiles,
    progress: tuple[Progress, int],
) -> dict[str, PictureMatch]:
    """One picture in all patterns: its sheet is written."""
    from PIL import Image

    from ..bridge.input.image_input import picture_tone
    from ..bridge.pictures.picture_print import picture_print
    from ..bridge.quiet import quiet_stdout
    from ..core.exports import export_gcode
    from ..core.pictures.report import sheet

    bar, before = progress
    with quiet_stdout():
        picture = fitted(picture_tone(image), plate, auto_contrast=not args.plain_contrast)
    photographs, found, periods = {}, {}, {}
    for number, pattern in enumerate(args.patterns):
        bar.show((before + number / len(args.patterns)) / len(args.images), f"{image.name}, {pattern}")
        chosen = _settings(args, PATTERNS[pattern]).changed({"pattern": pattern})
        with quiet_stdout():
            made = picture_print(picture, plate, chosen, image.stem, args.mm_per_pixel, args.samples)
        photographs[pattern], found[pattern] = made.photograph, made.match
        periods[pattern] = (PERIOD_LAYERS * chosen.layer_height, made.match.period_mm)
        if args.gcode:
            export_gcode(made.result, files.staged(_gcode(image, pattern)))
    drawn = sheet(made.painted, photographs, periods, args.mm_per_pixel)
    Image.fromarray(drawn).convert("L").save(files.staged(_sheet(image)), optimize=True)
    return found


def _write_tables(
    args: argparse.Namespace,
    rows: list[tuple[str, str, PictureMatch]],
    plate: PictureShape,
    settings: PrintSettings,
    files: OutputFiles,
) -> None:
    from ..core.pictures.report import pictures_of, table

    command = f"./dualcolor plate {' '.join(image.name for image in args.images)} --out {args.out.as_posix()}"
    text = table(rows, (*plate.size, plate.columns, plate.rows), settings, not args.plain_contrast, command)
    text += pictures_of({image.name: Path(files.paths[_sheet(image)].name) for image in args.images})
    write_file(files.staged("table"), text.encode("utf-8", "replace"))
    figures = [{"picture": name, "pattern": pattern} | match.as_dict() for name, pattern, match in rows]
    report = {"plates": figures, "settings": settings.as_dict()}
    write_file(files.staged("report"), (json.dumps(report, indent=2, allow_nan=False) + "\n").encode())


def _sheet(image: Path) -> str:
    return f"sheet of {image}"


def _gcode(image: Path, pattern: str) -> str:
    return f"G-code of {image}, {pattern}"


def _patterns(text: str) -> tuple[str, ...]:
    names = tuple(name.strip() for name in text.split(","))
    if not set(names) <= set(PATTERNS) or len(set(names)) < len(names):
        raise argparse.ArgumentTypeError(f"{text!r} is not some of {','.join(PATTERNS)}")
    return names
