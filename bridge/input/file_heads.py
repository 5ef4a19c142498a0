"""Model files that Blender's importers would crash at, not understand, or take for other numbers."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from ...core.errors import MeshError

_HEAD_BYTES = 1 << 16
# Blender's reader of PLY ends the program at a line of 64 kB; each such line fills one of these blocks.
_LINE_BYTES = 1 << 15
_COMMA = re.compile(rb"^\s*(?:v|vertex)[ \t]+[^\n]*\d,\d", re.MULTILINE | re.IGNORECASE)
_MARKS = (b"\xef\xbb\xbfv", b"\xff\xfe", b"\xfe\xff")  # before a vertex, which would be lost; UTF-16
_FACET_WORD = re.compile(rb"facet|vertex", re.IGNORECASE)
_STL_HEAD, _STL_FACET_BYTES = 84, 50
_ELEMENT = re.compile(rb"element\s+\w+\s+(\d{1,10})\s*")


def check_head(path: Path) -> None:
    """Refuse a file with decimal commas or old line ends, or a PLY file that Blender crashes at.

    Raises:
        MeshError: it is one.
    """
    kind = path.suffix.lower()
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
        if kind in (".obj", ".stl") and _COMMA.search(head.replace(b"\r", b"\n")):
            raise MeshError(f"{path} has decimal commas in its coordinates", "export it with decimal points")
        if kind == ".obj" and head.startswith(_MARKS):
            raise MeshError(f"{path} begins with a byte order mark", "save it as UTF-8 without one")
        if kind in (".obj", ".ply") and b"\r" in head and b"\n" not in head:
            raise MeshError(f"{path} has line ends that Blender cannot read", "save it with those of Unix or Windows")
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


@contextmanager
def legible(path: Path) -> Iterator[Path]:
    """An STL file, or a copy while the block lasts: in text, Blender reads small letters and line feeds only."""
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
        binary = _STL_HEAD + _STL_FACET_BYTES * int.from_bytes(head[80:84], "little") == path.stat().st_size
        words = set(_FACET_WORD.findall(head))
        old = b"\r" in head and b"\n" not in head
        if binary or not (old or words - {b"facet", b"vertex"}):
            yield path
            return
        with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
            copy = Path(folder) / path.name
            file.seek(0)
            with copy.open("wb") as text:
                text.writelines(
                    block.lower().replace(b"\r", b"\n") for block in iter(partial(file.read, _HEAD_BYTES), b"")
                )
            yield copy
