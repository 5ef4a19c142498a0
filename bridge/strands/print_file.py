"""The preview of a print made from its G-code or X3G file."""

from __future__ import annotations

from pathlib import Path

import bpy

from ...core.files import read_print_file, title
from ...core.gcode.reader import read_gcode
from ...core.toolpaths.recovered import ReadPrint
from ...core.x3g.moves import moves_of_x3g
from .preview import build_preview

SUFFIXES = (".gcode", ".x3g")


def read_print(path: Path) -> ReadPrint:
    """Read a file of either kind.

    Raises:
        PrintError: it cannot be read, or is damaged.
    """
    data = read_print_file(path)
    return moves_of_x3g(data, title(path)) if path.suffix.lower() == ".x3g" else read_gcode(data, title(path))


def show_file(path: Path) -> bpy.types.Collection:
    """Strands of the print in a file, on a bed whose middle is the world's origin.

    Raises:
        PrintError: the file cannot be read, or is damaged.
    """
    return build_preview(read_print(path))
