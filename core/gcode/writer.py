"""A print into the text of a G-code file for the Replicator 2X, in bulk."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model import BoolArray, FloatArray, IntArray
from ..pattern.chunks import in_threads
from ..settings import PrintSettings
from ..toolpaths.moves import Moves
from .numbers import WordArray, coordinate_words, feedrate_words, filament_words, word
from .program import WIDTH_STEP, Lines, Program, program
from .texts import written

_CHUNK_ROWS = 1 << 14  # a chunk's words stay in the processor's cache
_MAX_COMMENT = 900
_LINE_WORDS = 17
_G1_X, _G1, _Y, _Z, _NEWLINE = (word(text) for text in ("G1 X", "G1", " Y", " Z", "\n"))
_MARK = b"\1"  # after a line that something else follows
_NEWLINE_AND_MARK = word("\n\1")


def gcode_text(moves: Moves, settings: PrintSettings, header: list[str], begins: FloatArray | None = None) -> bytes:
    """The whole file: header, start sequence, one `G1` a move, tool changes, end sequence; see `counted_text`."""
    return counted_text(moves, settings, header, begins)[0]


def counted_text(
    moves: Moves, settings: PrintSettings, header: list[str], begins: FloatArray | None = None
) -> tuple[bytes, int]:
    """The whole file, see `program`, and how many of its lines are `G1`.

    Args:
        moves: the print, at least one row.
        settings: of the print; they are written into the header.
        header: more lines for the header, without a comment sign, such as "layers = 408".
        begins: `statistics.layer_begins` of the moves, if they are known.

    Raises:
        ValueError: no moves, or numbers that are not finite or too large for the file.
    """
    told = program(moves, settings, begins)
    axes = np.array([word(f" {axis}") for axis in settings.printer_profile.tool_axes], dtype=np.uint32)
    places, texts = _with_widths(told)
    body = _body(told.lines, axes, places, texts)
    text = b"".join([_joined(_header_lines(settings, header) + told.start), *body, _joined(told.end)])
    others = sum(line.startswith("G1 ") for lines in (told.start, *told.insertions, told.end) for line in lines)
    return text, len(told.lines.tool) + others


def _with_widths(told: Program) -> tuple[IntArray, list[bytes]]:
    """The insertions as text, and comments where the width of the lines changes."""
    texts = [_joined(lines) for lines in told.insertions]
    if not len(told.widths):
        return told.places, texts
    texts += [b"; width %.3f\n" % width for width in (told.widths * WIDTH_STEP).tolist()]
    places = np.concatenate([told.places, told.width_places])
    order = np.argsort(places, kind="stable")
    return places[order], [texts[number] for number in order.tolist()]


def _body(lines: Lines, axes: WordArray, places: IntArray, texts: list[bytes]) -> list[bytes]:
    """The lines as text with the other texts between them, in pieces."""
    count = len(lines.tool)
    distinct, first = np.unique(places, return_index=True)
    begin_end = pairwise([*first.tolist(), len(texts)])
    inserted = [b"".join(texts[begin:end]) for begin, end in begin_end]
    newline = np.full(count, _NEWLINE)
    newline[distinct[distinct > 0] - 1] = _NEWLINE_AND_MARK
    chunks = [slice(row, row + _CHUNK_ROWS) for row in range(0, count, _CHUNK_ROWS)]
    rendered = in_threads(lambda rows: _rendered(lines, axes, newline, rows), chunks)
    waiting = iter(inserted)
    pieces = [next(waiting)] if len(distinct) and distinct[0] == 0 else []
    for first_piece, *others in rendered:
        pieces.append(first_piece)
        for piece in others:
            pieces += [next(waiting), piece]
    return pieces


def _rendered(lines: Lines, axes: WordArray, newline: WordArray, rows: slice) -> list[bytes]:
    """Some lines as text, cut at the marks: a row of words each, zero bytes deleted."""
    thousandths, written, feeds = lines.thousandths[rows], lines.written[rows], lines.feeds[rows]
    words = np.zeros((len(feeds), _LINE_WORDS), dtype=np.uint32)
    for axis, letter in enumerate((_G1_X, _Y, _Z)):
        _place(words, 3 * axis, written[:, axis], letter, coordinate_words, thousandths[:, axis])
    words[~written[:, 0], 0] = _G1
    _place(words, 9, feeds, axes.take(lines.tool[rows]), filament_words, lines.steps[rows])
    hastens = np.flatnonzero(lines.hastens[rows])
    words[hastens, 14], words[hastens, 15] = feedrate_words(lines.feedrate[rows][hastens])
    words[:, 16] = newline[rows]
    return words.tobytes().translate(None, b"\0").split(_MARK)


def _place(
    words: WordArray,
    column: int,
    named: BoolArray,
    letter: np.uint32 | WordArray,
    number_words: Callable[[NDArray[Any]], tuple[WordArray, ...]],
    numbers: NDArray[Any],
) -> None:
    """Write a letter and a number into the lines that name it, into the words from a column on.

    What most lines name is written into all of them and taken out of the others.
    """
    if 2 * np.count_nonzero(named) > len(named):
        parts = letter, *number_words(numbers)
        for number, part in enumerate(parts, start=column):
            words[:, number] = part
        words[~named, column : column + len(parts)] = 0
    else:
        rows = np.flatnonzero(named)
        words[rows, column] = np.broadcast_to(letter, len(named))[rows]
        for number, part in enumerate(number_words(numbers[rows]), start=column + 1):
            words[rows, number] = part


def _header_lines(settings: PrintSettings, header: list[str]) -> list[str]:
    values = [f"{name} = {written(str(value))}" for name, value in settings.as_dict().items()]
    printer = settings.printer_profile
    for_gpx = [] if printer.marlin else [f";@machine {printer.gpx_machine}", ";@flavor makerbot"]
    return [*for_gpx, *(_comment(text) for text in [*header, *values])]


def _comment(text: str) -> str:
    """A comment that neither converter stumbles over: ASCII, one line, no sign with a meaning of its own."""
    plain = text.encode("ascii", "replace").decode()[:_MAX_COMMENT]
    return "; " + "".join(sign if sign.isprintable() and sign not in "#@;()" else "?" for sign in plain)


def _joined(lines: list[str]) -> bytes:
    return "\n".join([*lines, ""]).encode("ascii")
