"""Moves into the text of a G-code file for the Replicator 2X, in bulk."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..printer import REPLICATOR_2X
from ..settings import PrintSettings
from ..toolpaths.moves import Feature, Moves
from .numbers import (
    COORDINATE_LIMIT,
    FEEDRATE_LIMIT,
    FILAMENT_LIMIT,
    coordinate_words,
    feedrate_words,
    filament_words,
    word,
)
from .sequences import StartSequence, end_sequence, start_sequence, tool_change_lines

_CHUNK_ROWS = 1 << 15  # a chunk's words stay in the processor's cache
_MAX_COMMENT = 900
_LINE_WORDS = 18
_G1_X, _G1, _Y, _Z, _F, _NEWLINE = (word(text) for text in ("G1 X", "G1", " Y", " Z", " F", "\n"))
_AXIS = np.array([word(f" {axis}") for axis in REPLICATOR_2X.tool_axes], dtype=np.uint32)


@dataclass(frozen=True)
class _Lines:
    """The numbers of K lines `G1 X Y Z A|B F`; each line has at least one axis.

    Attributes:
        thousandths: (K, 3) int64, X, Y, Z in 0.001 mm.
        written: (K, 3) bool, which of them the line names.
        steps: (K,) int64, filament counter in 0.00001 mm.
        feeds: (K,) bool, whether the line names the filament axis.
        tool: (K,) int64.
        feedrate: (K,) int64 mm/min, 0 where it stays what it was.
    """

    thousandths: IntArray
    written: BoolArray
    steps: IntArray
    feeds: BoolArray
    tool: IntArray
    feedrate: IntArray


def gcode_text(moves: Moves, settings: PrintSettings, header: list[str]) -> bytes:
    """The whole file: header, start sequence, one `G1` a move, tool changes, end sequence.

    Moves that would change no number of the line before (shorter than the file's resolution) get no line. A tool
    that the moves first prime is left pulled back by that length after the start sequence.

    Args:
        moves: the print, at least one row.
        settings: of the print; they are written into the header.
        header: more lines for the header, without a comment sign, such as "layers = 408".

    Raises:
        ValueError: no moves, or numbers that are not finite or too large for the file.
    """
    _check(moves)
    start = _start(moves, settings)
    counters, steps = _filament_steps(moves, start.counters)
    fresh = _after_break(moves.tool)
    thousandths = np.rint(moves.position * 1000).astype(np.int64)
    lines, kept_before = _lines(moves, thousandths, steps, fresh)
    body = _body(lines, *_insertions(moves, kept_before))
    last_tool = int(moves.tool[-1])
    head = _header_lines(settings, header) + start.lines
    tail = end_sequence(settings, last_tool, counters[last_tool])
    return b"".join([_joined(head), *body, _joined(tail)])


def _check(moves: Moves) -> None:
    if not len(moves.tool):
        raise ValueError("there are no moves to write")
    for column in (moves.position, moves.filament, moves.speed):
        if not np.isfinite(column).all():
            raise ValueError("the moves hold a number that is not finite")
    if np.abs(moves.position).max() * 1000 >= COORDINATE_LIMIT - 1:
        raise ValueError("the moves leave the range of coordinates that the file can hold")


def _start(moves: Moves, settings: PrintSettings) -> StartSequence:
    first = int(moves.tool[0])
    others = tuple(int(tool) for tool in np.unique(moves.tool) if tool != first)
    extrudes = moves.extrudes
    front = float(moves.position[extrudes, 1].min()) if extrudes.any() else 0.0
    return start_sequence(settings, (*others, first), (_first_prime(moves, 0), _first_prime(moves, 1)), front)


def _first_prime(moves: Moves, tool: int) -> float:
    """Mm by which the moves expect the tool's filament to be pulled back before they first feed it."""
    fed = np.flatnonzero((moves.tool == tool) & (moves.filament != 0))
    if not len(fed) or moves.feature[fed[0]] != Feature.RETRACT:
        return 0.0
    return max(float(moves.filament[fed[0]]), 0.0)


def _filament_steps(moves: Moves, begin: tuple[float, float]) -> tuple[list[float], IntArray]:
    """Each tool's final counter in mm, and (M,) the active tool's counter in 0.00001 mm after each row."""
    second = moves.tool == 1
    totals = [begin[tool] + np.cumsum(np.where(second == bool(tool), moves.filament, 0.0)) for tool in (0, 1)]
    steps = np.rint(np.where(second, totals[1], totals[0]) * 1e5).astype(np.int64)
    if np.abs(steps).max() >= FILAMENT_LIMIT:
        raise ValueError("the print needs more filament than the file's counters can hold")
    return [float(total[-1]) for total in totals], steps


def _after_break(tool: IntArray) -> BoolArray:
    """(M,) rows before which other commands stand, so that nothing may be taken over from the row before."""
    fresh = np.ones(len(tool), dtype=bool)
    fresh[1:] = tool[1:] != tool[:-1]
    return fresh


def _lines(moves: Moves, thousandths: IntArray, steps: IntArray, fresh: BoolArray) -> tuple[_Lines, IntArray]:
    """The lines to write, and (M,) how many of them stand before each row."""
    written = np.repeat(fresh[:, None], 3, axis=1)
    written[1:] |= thousandths[1:] != thousandths[:-1]
    feeds = moves.filament != 0
    kept = written.any(axis=1) | feeds
    kept_before = np.cumsum(kept) - kept
    top_speed = REPLICATOR_2X.max_speed_mm_s[0]
    feedrate = np.rint(np.minimum(moves.speed, top_speed) * 60).astype(np.int64).clip(1, FEEDRATE_LIMIT - 1)[kept]
    changed = fresh[kept]
    changed[1:] |= feedrate[1:] != feedrate[:-1]
    lines = _Lines(
        thousandths[kept], written[kept], steps[kept], feeds[kept], moves.tool[kept], np.where(changed, feedrate, 0)
    )
    return lines, kept_before


def _insertions(moves: Moves, kept_before: IntArray) -> tuple[IntArray, list[bytes]]:
    """What stands between the lines: a comment and the progress at each layer, the tool changes.

    Returns:
        (I,) int64 the line before which each text stands, ascending, and the texts.
    """
    layer_starts = np.ones(len(moves.layer), dtype=bool)
    layer_starts[1:] = moves.layer[1:] != moves.layer[:-1]
    tool_starts = _after_break(moves.tool)
    tool_starts[0] = False
    rows = np.flatnonzero(layer_starts | tool_starts)
    progress = _progress(moves)[rows]
    texts = []
    shown = 0
    for row, percent in zip(rows.tolist(), progress.tolist(), strict=True):
        lines = [f"; layer {moves.layer[row]}"] if layer_starts[row] else []
        if layer_starts[row] and percent > shown:
            lines.append(f"M73 P{percent}")
            shown = percent
        lines += tool_change_lines(int(moves.tool[row])) if tool_starts[row] else []
        texts.append(_joined(lines))
    return kept_before[rows], texts


def _progress(moves: Moves) -> IntArray:
    """(M,) share in % of the print's time that has passed before each row, 0 to 99; accelerations left out."""
    way = np.zeros(len(moves.tool))
    step = np.diff(moves.position, axis=0)
    way[1:] = np.sqrt(np.einsum("ij,ij->i", step, step))
    seconds: FloatArray = np.maximum(way, np.where(way == 0, np.abs(moves.filament), 0)) / np.maximum(moves.speed, 1e-3)
    passed = np.cumsum(seconds) - seconds
    total = passed[-1] + seconds[-1]
    return (passed * (100 / total) if total > 0 else passed).astype(np.int64).clip(0, 99)


def _body(lines: _Lines, places: IntArray, texts: list[bytes]) -> list[bytes]:
    """The lines as text with the other texts between them, in pieces."""
    count = len(lines.tool)
    text = b"".join(_rendered(lines, slice(row, row + _CHUNK_ROWS)) for row in range(0, count, _CHUNK_ROWS))
    line_ends = np.flatnonzero(np.frombuffer(text, dtype=np.uint8) == ord("\n")) + 1
    offsets = np.concatenate([[0], line_ends])[places].tolist()
    pieces = [text[: offsets[0]]]
    for insertion, begin, end in zip(texts, offsets, [*offsets[1:], len(text)], strict=True):
        pieces += [insertion, text[begin:end]]
    return pieces


def _rendered(lines: _Lines, rows: slice) -> bytes:
    """Some lines as text: a row of words each, zero bytes deleted."""
    written = lines.written[rows]
    words = np.zeros((len(written), _LINE_WORDS), dtype=np.uint32)
    words[:, 0] = np.where(written[:, 0], _G1_X, _G1)
    for axis, letter in enumerate((None, _Y, _Z)):
        named = np.flatnonzero(written[:, axis])
        if letter is not None:
            words[named, 3 * axis] = letter
        words[named, 3 * axis + 1], words[named, 3 * axis + 2] = coordinate_words(lines.thousandths[rows, axis][named])
    named = np.flatnonzero(lines.feeds[rows])
    words[named, 9] = _AXIS[lines.tool[rows][named]]
    for column, part in enumerate(filament_words(lines.steps[rows][named]), start=10):
        words[named, column] = part
    named = np.flatnonzero(lines.feedrate[rows])
    words[named, 14] = _F
    words[named, 15], words[named, 16] = feedrate_words(lines.feedrate[rows][named])
    words[:, 17] = _NEWLINE
    return words.tobytes().translate(None, b"\0")


def _header_lines(settings: PrintSettings, header: list[str]) -> list[str]:
    values = [f"{name} = {value}" for name, value in settings.as_dict().items()]
    return [";@machine r2x", ";@flavor makerbot", *(_comment(text) for text in [*header, *values])]


def _comment(text: str) -> str:
    """A comment that neither converter stumbles over: ASCII, one line, no sign with a meaning of its own."""
    plain = text.encode("ascii", "replace").decode()[:_MAX_COMMENT]
    return "; " + "".join(sign if sign.isprintable() and sign not in "#@;()" else "?" for sign in plain)


def _joined(lines: list[str]) -> bytes:
    return "".join(line + "\n" for line in lines).encode("ascii")
