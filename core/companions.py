"""Files that a model file needs beside itself: materials of .obj, buffers of .gltf, and the pictures that they name."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any
from urllib.parse import unquote

_MATERIALS = re.compile(rb"mtllib[ \t]+([^\r\n]{1,500})")
_PICTURES = re.compile(rb"(?:map_\w+|bump|disp|decal|norm|refl)[ \t]+([^\r\n]{1,500})", re.IGNORECASE)
_MOST_STATEMENTS = 1000  # that are looked at in a file
_GLB_HEAD_BYTES = 20  # of the file, 12, and of its first chunk, which is JSON


def companions(path: Path) -> list[Path]:
    """The files that a model file names, which may not exist; none of a file that cannot be read."""
    kind = path.suffix.lower()
    try:
        if kind == ".obj":
            materials = [path.with_suffix(".mtl"), *_beside(path, _MATERIALS)]  # Blender looks for the first one anyway
            found = [each for each in materials if os.path.isfile(each)]
            return materials + [picture for each in found for picture in _beside(each, _PICTURES)]
        if kind in (".gltf", ".glb"):
            return [path.parent / unquote(uri) for uri in _uris(_description(path, kind))]
    except (OSError, ValueError, TypeError, AttributeError, RecursionError):
        pass  # damaged: whoever opens it tells what is wrong
    return []


def _beside(path: Path, statement: re.Pattern[bytes]) -> Iterator[Path]:
    """The files that statements name: options may stand before a name, and blanks within it."""
    for found in islice(statement.finditer(path.read_bytes()), _MOST_STATEMENTS):
        words = found[1].decode("utf-8", "surrogateescape").replace("\\", "/").split(" ")
        for first in range(len(words)):
            for last in (first + 1, len(words)):
                yield path.parent / " ".join(words[first:last]).strip(' \t"')


def _description(path: Path, kind: str) -> Any:
    """The JSON of a glTF file."""
    if kind == ".gltf":
        return json.loads(path.read_bytes())
    with path.open("rb") as file:
        head = file.read(_GLB_HEAD_BYTES)
        length = int.from_bytes(head[12:16], "little")
        return json.loads(file.read(min(length, os.path.getsize(path))))


def _uris(description: Any) -> Iterator[str]:
    """Of all buffers and pictures that lie in files of their own."""
    for each in (entry for part in ("buffers", "images") for entry in description.get(part, [])):
        uri = each.get("uri", "data:")
        if not uri.startswith("data:"):
            yield uri
