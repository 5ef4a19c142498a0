"""What is fuzzed: readers of files that others may have made, each with a few sound files to start from."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from io import BytesIO
from pathlib import Path

import numpy as np
from dualcolor.core.calibration.photograph import read_photograph
from dualcolor.core.calibration.sweep import read_sweep
from dualcolor.core.calibration.table import read_table
from dualcolor.core.companions import companions
from dualcolor.core.gcode.reader import read_gcode
from dualcolor.core.pipeline import DualColorPrint, generate
from dualcolor.core.settings import PrintSettings
from dualcolor.core.settings.presets import PRESETS, read_preset, read_settings, settings_json
from dualcolor.core.settings.printer import PRINTERS, printer_profile, read_profile
from dualcolor.core.strands.strands import strands
from dualcolor.core.x3g.audit import audit
from dualcolor.core.x3g.moves import moves_of_x3g
from dualcolor.core.x3g.reader import read_x3g
from dualcolor.core.x3g.writer import x3g_bytes
from dualcolor.tests.printing import gcode_text
from dualcolor.tests.solids import box
from PIL import Image

FOREIGN = b"""; external perimeter
G21
G90
M83
G1 Z0.2 F7800
T0
G1 X10 Y10 F6000
G1 X20 Y10 E0.5 F1800
G1 X20.5 Y20. E.5
G92 E0
;TYPE:SKIN
G1 X10 Y20 E0.5 (text)
G0 Z0.4
T1
G91
G1 X1 Y-1 E0.05
G90
M117 done
G1 X10 Y10 E0.4
"""


GLTF = b'{"buffers": [{"uri": "a.bin"}, {"byteLength": 3}], "images": [{"uri": "a b.png"}], "asset": {}}'


@dataclass(frozen=True)
class Target:
    """A reader.

    Attributes:
        read: is given the bytes of a file; only a PrintError may come out.
        seeds: sound files.
        words: that mean something in such a file.
    """

    read: Callable[[bytes], object]
    seeds: tuple[bytes, ...]
    words: tuple[bytes, ...]


@cache
def targets() -> dict[str, Target]:
    """All of them by name."""
    result = generate(box((0, 0, 0), (5, 5, 1.2)), PrintSettings(support_enable=True))
    numbers = (b"0", b"-1", b"1e999", b"NaN", b"-Infinity", b"1e-320", b"9" * 40, b"true", b"null", b'""', b"[]", b"{}")
    numbers += (b"[" * 5000, b'{"a":' * 3000)
    gcode = (b"G1", b"G92", b"G91", b"G90", b"M135 T1", b"T0", b"X", b"A", b"E", b"F0", b"Z-1", b"G1 X1e9",
             b"nan", b"1e5", b"-", b".", b"9" * 30, b"; layer 3", b"; width 0.4", b"(", b"\n")  # fmt: skip
    x3g = (*(bytes([code]) for code in range(129, 160)), b"\xff" * 4, b"\0\0\0\x80", b"\xff\xff\xff\x7f")
    presets = tuple(path.read_bytes() for path in sorted(PRESETS.glob("*/*.json")))
    return {
        "gcode": Target(_read_gcode, (gcode_text(result.moves, result.settings, []), FOREIGN), (*gcode, *numbers)),
        "x3g": Target(_read_x3g, (x3g_bytes(result.moves, result.settings, "part"),), x3g),
        "preset": Target(_in_a_file(".json", _read_preset), presets, numbers),
        "settings": Target(_in_a_file(".json", _read_settings), (settings_json(PrintSettings()).encode(),), numbers),
        "header": Target(_in_a_file(".gcode", _read_settings), (_header(result),), (b" = ", b"; ", *numbers)),
        "printer": Target(_in_a_file(".json", read_profile), _files(PRINTERS), (b"[1]", b'"A"', *numbers)),
        "table": Target(_in_a_file(".json", read_table), (*_files(PRESETS / "calibration"), _table()), numbers),
        "sweep": Target(
            _in_a_file(".npz", read_sweep), (_archive(),), (b"PK\3\4", b"\x93NUMPY", b"<f8", b"|O", b"about")
        ),
        "companions": Target(_in_a_file(".gltf", companions), (GLTF,), (b'"uri":', b'"a%00.bin"', *numbers)),
        "photograph": Target(
            _in_a_file(".png", read_photograph), _pictures(), (b"IHDR", b"IDAT", b"\xff\xc0", b"II*\0", b"\xff" * 4)
        ),
    }


def _read_gcode(data: bytes) -> object:
    return strands(read_gcode(data, "part").moves)


def _read_x3g(data: bytes) -> object:
    audit(read_x3g(data), printer_profile("replicator_2x"))
    return strands(moves_of_x3g(data, "part").moves)


def _read_preset(path: Path) -> object:
    return PrintSettings().changed(read_preset(path).settings)


def _read_settings(path: Path) -> object:
    return PrintSettings().changed(read_settings(path))


def _in_a_file(suffix: str, read: Callable[[Path], object]) -> Callable[[bytes], object]:
    folder = Path(tempfile.mkdtemp(prefix="fuzz"))

    def of_bytes(data: bytes) -> object:
        path = folder / f"file{suffix}"
        path.write_bytes(data)
        return read(path)

    return of_bytes


def _header(result: DualColorPrint) -> bytes:
    return gcode_text(result.moves, result.settings, [])[:6000]


def _files(folder: Path) -> tuple[bytes, ...]:
    return tuple(path.read_bytes() for path in sorted(folder.rglob("*.json")))


def _table() -> bytes:
    rows = [[0.1, 0.3, 0.7], [0.1, 0.2, 0.6]]
    about = {"settings": {}, "reflectance": {"Black": 0.03, "White": 0.7}, "source": "test"}
    values = {"format": "dualcolor tone table", "version": 1, "about": about, "tone": [0, 0.5, 1], "slant_deg": [0, 30]}
    return json.dumps(values | {"reflectance": rows, "noise": rows}).encode()


def _pictures() -> tuple[bytes, ...]:
    """Small pictures of several kinds."""
    values = np.random.default_rng(1).integers(0, 256, (9, 12, 3)).astype(np.uint8)
    found = []
    for kind in ("PNG", "JPEG", "TIFF", "WEBP", "BMP", "GIF"):
        held = BytesIO()
        Image.fromarray(values).save(held, kind)
        found.append(held.getvalue())
    return tuple(found)


def _archive() -> bytes:
    held = BytesIO()
    about = {"settings": {}, "reflectance": {"Black": 0.03, "White": 0.7}, "source": "test"}
    readings = {"angle_deg": np.zeros(1), "tone": np.linspace(0, 1, 3), "reflectance": np.ones((3, 1))}
    np.savez(held, about=json.dumps(about), slant_deg=0.0, block="phi", noise=np.ones((3, 1)), **readings)
    return held.getvalue()
