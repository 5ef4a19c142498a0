"""A G-code file back into moves: our own for any printer, and those of slicers that write the same commands."""

from __future__ import annotations

import re

import numpy as np

from ..errors import PrintError, SettingsError
from ..model import BoolArray, FloatArray, IntArray
from ..paths import Feature
from ..settings import PrintSettings
from ..settings.header_text import read_back
from ..toolpaths.recovered import UNKNOWN, ReadPrint, recovered_moves
from .comments import FEATURE_NAMES
from .words import LETTERS, Words, read_words

_STEPS = (0.001, 0.00001)  # mm, of positions and filament in the file
_HINT = "export the print again"
_WIDTH = re.compile(r"width \d{1,2}\.\d{1,6}")
# Part of a comment in small letters → what the following lines are for. The names of our own features come first.
_NAMES = {name: feature for feature, name in FEATURE_NAMES.items() if feature > Feature.RETRACT}
_FOREIGN = {
    "external perimeter": Feature.OUTER_WALL,
    "wall-outer": Feature.OUTER_WALL,
    "perimeter": Feature.INNER_WALL,
    "wall-inner": Feature.INNER_WALL,
    "bridge infill": Feature.BRIDGE,
    "solid infill": Feature.SKIN,
    "type:skin": Feature.SKIN,
    "infill": Feature.INFILL,
    "type:fill": Feature.INFILL,
    "skirt": Feature.SKIRT,
    "wipe tower": Feature.TOWER,
    "prime-tower": Feature.TOWER,
    "support": Feature.SUPPORT,
}


def read_gcode(data: bytes, name: str) -> ReadPrint:
    """Read a file: moves G0 and G1, counters (G92), tools (M135 or T), filament on A and B or on E.

    Args:
        data: the file.
        name: of the print unless the file names it.

    Raises:
        PrintError: it is damaged, or has commands that this program does not know how to follow.
    """
    words = read_words(data)
    if words.are("G", 2, 3).any():
        raise PrintError("the G-code file has arcs (G2, G3)", "let the slicer write straight moves only")
    if words.are("G", 20).any():
        raise PrintError("the G-code file is in inches (G20)", "let the slicer write millimeters")
    layer_lines = [line for line, text in words.comments if text.startswith("layer ")]
    if layer_lines and b"@machine " in data[:200] and not words.are("M", 137).any():
        raise PrintError("the G-code file breaks off before the end of the print", _HINT)
    settings, title = _header(words.comments[: 10 * len(PrintSettings.__dataclass_fields__)])
    moving, sets = words.are("G", 0, 1), words.are("G", 92)
    relative = _switched(words.are("G", 91), words.are("G", 90))
    relative_fed = relative | _switched(words.are("M", 83), words.are("M", 82))
    column = {letter: words.values[:, number] for number, letter in enumerate(LETTERS)}
    position = np.stack([_followed(column[axis], moving, sets, relative) for axis in "XYZ"], axis=1)
    if marlin := settings.printer_profile.marlin:
        position -= [*marlin.origin, 0.0]  # to where our own coordinates begin, in the middle of the bed
    fed = np.zeros(len(moving))
    for axis in "ABE":
        counter = _followed(column[axis], moving, sets, relative_fed if axis == "E" else relative)
        fed[1:] += np.diff(counter) * moving[1:]
    fed[np.abs(fed) < 1e-7] = 0.0
    speed = _latest(column["F"], moving) / 60
    rows = np.flatnonzero(moving & (words.line > (layer_lines[0] if layer_lines else 0)))
    feature = _features(words)[rows]
    stated = _widths(words, settings.extrusion_width)[rows] if layer_lines else None
    moves = recovered_moves(
        position[rows], _tool(words)[rows], fed[rows], speed[rows], feature, settings, _STEPS, stated
    )
    return ReadPrint(title or name, settings, moves)


def _header(comments: list[tuple[int, str]]) -> tuple[PrintSettings, str]:
    """The settings and the object's name that comments "name = value" give."""
    given = dict(text.split(" = ", 1) for _, text in comments if " = " in text)
    known = {name: read_back(given[name].strip()) for name in PrintSettings.__dataclass_fields__ if name in given}
    try:
        return PrintSettings().changed(known), given.get("object", "")
    except SettingsError:  # a slicer that uses one of our names for something else
        return PrintSettings(), given.get("object", "")


def _switched(on: BoolArray, off: BoolArray) -> BoolArray:
    """(C,) whether the latest of two kinds of commands is the first one."""
    latest = np.maximum.accumulate(np.where(on | off, np.arange(len(on)), 0))
    return np.asarray(on[latest])


def _followed(given: FloatArray, moving: BoolArray, sets: BoolArray, relative: BoolArray) -> FloatArray:
    """(C,) mm, where an axis is after each command; 0 before the first."""
    named = ~np.isnan(given)
    shift = named & moving & relative
    place = named & (sets | (moving & ~relative))
    sums = np.cumsum(np.where(shift, given, 0.0))
    last = np.maximum.accumulate(np.where(place, np.arange(len(given)), -1))
    base = np.where(last >= 0, np.where(place, given, 0.0)[last] - sums[last], 0.0)
    after: FloatArray = base + sums
    return after


def _latest(given: FloatArray, counted: BoolArray) -> FloatArray:
    """(C,) the last value given by a counted command, 60 before the first."""
    named = counted & ~np.isnan(given)
    last = np.maximum.accumulate(np.where(named, np.arange(len(given)), -1))
    latest: FloatArray = np.where(last >= 0, np.where(named, given, 0.0)[last], 60.0)
    return latest


def _tool(words: Words) -> IntArray:
    """(C,) the active tool."""
    chosen = np.where(words.letter == ord("T"), words.number, words.values[:, LETTERS.index("T")])
    changes = (words.letter == ord("T")) | words.are("M", 108, 135)
    named = np.flatnonzero(changes & ~np.isnan(chosen))
    if not np.isin(chosen[named], (0, 1)).all():
        raise PrintError("the G-code file uses a tool that the printer does not have", "use the tools 0 and 1 only")
    tools = np.concatenate([[0], chosen[named].astype(np.int64)])
    active: IntArray = tools[np.searchsorted(named, np.arange(len(changes)), side="right")]
    return active


def _features(words: Words) -> IntArray:
    """(C,) what the latest comment before each command says that lines are for."""
    lines, kinds = [0], [UNKNOWN]
    seen: dict[str, int] = {}
    for line, text in words.comments:
        if text not in seen:
            seen[text] = _feature_of(text.lower())
        if seen[text] != UNKNOWN:
            lines.append(line)
            kinds.append(seen[text])
    feature: IntArray = np.array(kinds)[np.searchsorted(lines, words.line, side="left") - 1]
    return feature


def _widths(words: Words, usual: float) -> FloatArray:
    """(C,) mm, the width that the latest comment before each command gives to lines, `usual` before the first."""
    stated = [(line, float(text[6:])) for line, text in words.comments if _WIDTH.fullmatch(text)]
    lines, widths = np.array([(0, usual), *stated]).T
    width: FloatArray = widths[np.searchsorted(lines, words.line, side="left") - 1]
    return width


def _feature_of(text: str) -> int:
    """The `Feature` that a comment in small letters names, else `UNKNOWN`."""
    if text in _NAMES:
        return int(_NAMES[text])
    if "=" in text or len(text) > 60:
        return UNKNOWN
    return next((int(feature) for part, feature in _FOREIGN.items() if part in text), UNKNOWN)
