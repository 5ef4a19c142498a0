"""What differs on Windows and macOS, imitated."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np
from dualcolor.core import pipeline
from dualcolor.core.gcode.reader import read_gcode
from dualcolor.core.settings import PrintSettings
from dualcolor.core.x3g.reader import read_x3g
from dualcolor.core.x3g.writer import x3g_bytes
from dualcolor.tests.printing import gcode_text
from dualcolor.tests.solids import lathe, picture

SETTINGS = PrintSettings(support_enable=True, pattern="wave_offset", infill_pattern="gyroid")
MUSHROOM = [(0.0, 0.0), (8.0, 0.0), (5.0, 4.0), (9.0, 5.0), (7.0, 9.0), (0.0, 9.0)]


def shortened(make: Callable) -> Callable:
    """A maker of arrays that gives whole numbers 32 bits where only Python's own numbers say which type is meant."""

    @functools.wraps(make)
    def made(*args, **more):
        array = make(*args, **more)
        typed = "dtype" in more or any(isinstance(each, (np.ndarray, np.generic, type)) for each in args)
        return array if typed or array.dtype != np.int64 else array.astype(np.int32)

    return made


def printed() -> list[bytes]:
    tone = np.random.default_rng(1).random((16, 64))
    result = pipeline.generate(lathe(MUSHROOM, textures=(picture(tone),)), SETTINGS)
    files = [gcode_text(result.moves, SETTINGS, [], result.layer_begins), x3g_bytes(result.moves, SETTINGS, "a")]
    read_gcode(files[0], "a")
    read_x3g(files[1])
    return files


def test_whole_numbers_of_32_bits(monkeypatch):
    """So they are in NumPy 1 on Windows unless a type is given; prints are the same to the last byte."""
    expected = printed()
    for name in ("arange", "full"):
        monkeypatch.setattr(np, name, shortened(getattr(np, name)))
    assert np.arange(3).dtype == np.int32
    assert printed() == expected
