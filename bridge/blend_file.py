"""Saving the open file as .blend, and checking that it is complete."""

from __future__ import annotations

from pathlib import Path

import bpy

from ..core.errors import OutputError

_SEEK_TABLE_END = (0x8F92EAB1).to_bytes(4, "little")  # what a compressed file of Blender's ends with


def save_blend(path: Path) -> None:
    """Save a compressed copy.

    Blender does not report that a full disk has cut a compressed file short; its last bytes show it.

    Raises:
        OutputError: the file cannot be written, or is not whole; what there is of it is removed.
    """
    problem = "the disk is full"
    try:
        bpy.ops.wm.save_as_mainfile(filepath=str(path.resolve()), copy=True, compress=True)
    except RuntimeError as failed:  # how an operator tells that it has failed
        problem = str(failed).strip().splitlines()[0].removeprefix("Error: ")
    if path.is_file() and _end_of(path) == _SEEK_TABLE_END:
        return
    path.unlink(missing_ok=True)
    raise OutputError(f"{path} cannot be written", problem)


def _end_of(path: Path) -> bytes:
    with path.open("rb") as file:
        file.seek(max(path.stat().st_size - len(_SEEK_TABLE_END), 0))
        return file.read()
