"""Mistakes in model files that Blender's importers would crash at, or take for other numbers."""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path

from ...core.errors import MeshError

_HEAD_BYTES = 1 << 16
# Blender's reader of PLY ends the program at a line of 64 kB; each such line fills one of these blocks.
_LINE_BYTES = 1 << 15
_COMMA = re.compile(rb"^\s*(?:v|vertex)[ \t]+[^\n]*\d,\d", re.MULTILINE)
_ELEMENT = re.compile(rb"element\s+\w+\s+(\d{1,10})\s*")


def check_head(path: Path) -> None:
    """Refuse a file whose coordinates have decimal commas, or a PLY file that Blender crashes at.

    Raises:
        MeshError: it is one.
    """
    kind = path.suffix.lower()
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
        if kind in (".obj", ".stl") and _COMMA.search(head):
            raise MeshError(f"{path} has decimal commas in its coordinates", "export it with decimal points")
        if kind != ".ply":
            return
        header, end, _ = head.partition(b"end_header")
        counts = [_ELEMENT.fullmatch(line) for line in header.splitlines() if line.startswith(b"element")]
        if not end or not all(count and int(count[1]) < 1 << 31 for count in counts):
            raise MeshError(f"{path} is damaged: its header cannot be read", "export it again")
        file.seek(0)
        in_text = b"format ascii" in header
        blocks = iter(partial(file.read, _LINE_BYTES), b"")
        if in_text and any(b"\n" not in block and len(block) == _LINE_BYTES for block in blocks):
            raise MeshError(f"{path} has a line too long for Blender", "export it as binary PLY")
