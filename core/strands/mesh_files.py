"""Mesh files of the predicted print: binary STL and Wavefront OBJ, in mm."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ..errors import OutputError, PrintError
from ..files import reason
from ..gcode.numbers import FOUR_DIGITS, WordArray, filament_words, word
from ..model import IntArray
from .tubes import SIDES, Rods, Tubes, count, tubes

_STL_RECORD = [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]


def _without_leading_zeros(texts: WordArray) -> WordArray:
    digits = texts.view(np.uint8).reshape(-1, 4)
    shown = np.logical_or.accumulate(digits > ord("0"), axis=1)
    shortened: WordArray = np.where(shown, digits, 0).astype(np.uint8).view(np.uint32)[:, 0]
    return shortened


_LEADING = _without_leading_zeros(FOUR_DIGITS)


def write_mesh(path: Path, rods: Rods) -> int:
    """Write lines as closed tubes; the kind of file follows from the suffix, .stl or .obj.

    Args:
        path: of the file.
        rods: the lines.

    Returns:
        How many tubes there are.

    Raises:
        PrintError: there are no strands.
        OutputError: the file cannot be written, or has another suffix.
    """
    writers: dict[str, Callable[[BinaryIO, Rods], None]] = {".stl": _write_stl, ".obj": _write_obj}
    if path.suffix.lower() not in writers:
        raise OutputError(f"{path} is neither .stl nor .obj", "choose one of these suffixes")
    if not len(rods.points):
        raise PrintError("there are no strands to write", "generate the toolpath first")
    try:
        with path.open("wb") as file:
            writers[path.suffix.lower()](file, rods)
    except OSError as problem:
        raise OutputError(f"{path} cannot be written", reason(problem)) from None
    return count(rods)[1]


def _write_stl(file: BinaryIO, rods: Rods) -> None:
    points, parts = count(rods)
    faces = (points - parts) * SIDES * 2 + parts * 2 * (SIDES - 2)
    file.write(b"predicted print, mm".ljust(80) + np.uint32(faces).tobytes())
    for part in tubes(rods):
        triangles = part.triangles()
        record = np.zeros(len(triangles), dtype=_STL_RECORD)
        corners = part.vertices[triangles]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        record["normal"] = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-12)[:, None]
        record["corners"] = corners
        file.write(record.tobytes())


def _write_obj(file: BinaryIO, rods: Rods) -> None:
    first = 1
    for part in tubes(rods):
        file.write(_text(_vertex_words(part)))
        for faces in (part.quads, part.caps):
            file.write(_text(_face_words(faces + first)))
        first += len(part.vertices)


def _vertex_words(part: Tubes) -> list[WordArray]:
    steps = np.rint(part.vertices * 1e5).astype(np.int64)
    columns: list[WordArray] = []
    for number in range(3):
        columns += [_same("v " if number == 0 else " ", len(steps)), *filament_words(steps[:, number])]
    return [*columns, _same("\n", len(steps))]


def _face_words(faces: IntArray) -> list[WordArray]:
    columns: list[WordArray] = []
    for number in range(faces.shape[1]):
        high, low = np.divmod(faces[:, number], 10_000)
        far, high = np.divmod(high, 10_000)
        columns += [
            _same("f " if number == 0 else " ", len(faces)),
            _LEADING[far],
            np.where(far > 0, FOUR_DIGITS[high], _LEADING[high]),
            np.where((far > 0) | (high > 0), FOUR_DIGITS[low], _LEADING[low]),
        ]
    return [*columns, _same("\n", len(faces))]


def _same(text: str, times: int) -> WordArray:
    return np.full(times, word(text), dtype=np.uint32)


def _text(columns: Iterable[WordArray]) -> bytes:
    """Rows of words as text, without zero bytes."""
    return np.stack(list(columns), axis=1).astype("<u4").tobytes().translate(None, b"\0")
