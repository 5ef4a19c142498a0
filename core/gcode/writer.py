"""A print into the text of a G-code file for the Replicator 2X, in bulk."""

from __future__ import annotations

import numpy as np

from ..model import IntArray
from ..settings import PrintSettings
from ..toolpaths.moves import Moves
from .numbers import WordArray, coordinate_words, feedrate_words, filament_words, word
from .program import Lines, program

_CHUNK_ROWS = 1 << 15  # a chunk's words stay in the processor's cache
_MAX_COMMENT = 900
_LINE_WORDS = 18
_G1_X, _G1, _Y, _Z, _F, _NEWLINE = (word(text) for text in ("G1 X", "G1", " Y", " Z", " F", "\n"))


def gcode_text(moves: Moves, settings: PrintSettings, header: list[str]) -> bytes:
    """The whole file: header, start sequence, one `G1` a move, tool changes, end sequence; see `program`.

    Args:
        moves: the print, at least one row.
        settings: of the print; they are written into the header.
        header: more lines for the header, without a comment sign, such as "layers = 408".

    Raises:
        ValueError: no moves, or numbers that are not finite or too large for the file.
    """
    told = program(moves, settings)
    axes = np.array([word(f" {axis}") for axis in settings.printer_profile.tool_axes], dtype=np.uint32)
    body = _body(told.lines, axes, told.places, [_joined(lines) for lines in told.insertions])
    return b"".join([_joined(_header_lines(settings, header) + told.start), *body, _joined(told.end)])


def _body(lines: Lines, axes: WordArray, places: IntArray, texts: list[bytes]) -> list[bytes]:
    """The lines as text with the other texts between them, in pieces."""
    count = len(lines.tool)
    text = b"".join(_rendered(lines, axes, slice(row, row + _CHUNK_ROWS)) for row in range(0, count, _CHUNK_ROWS))
    line_ends = np.flatnonzero(np.frombuffer(text, dtype=np.uint8) == ord("\n")) + 1
    offsets = np.concatenate([[0], line_ends])[places].tolist()
    pieces = [text[: offsets[0]]]
    for insertion, begin, end in zip(texts, offsets, [*offsets[1:], len(text)], strict=True):
        pieces += [insertion, text[begin:end]]
    return pieces


def _rendered(lines: Lines, axes: WordArray, rows: slice) -> bytes:
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
    words[named, 9] = axes[lines.tool[rows][named]]
    for column, part in enumerate(filament_words(lines.steps[rows][named]), start=10):
        words[named, column] = part
    named = np.flatnonzero(lines.hastens[rows])
    words[named, 14] = _F
    words[named, 15], words[named, 16] = feedrate_words(lines.feedrate[rows][named])
    words[:, 17] = _NEWLINE
    return words.tobytes().translate(None, b"\0")


def _header_lines(settings: PrintSettings, header: list[str]) -> list[str]:
    values = [f"{name} = {value}" for name, value in settings.as_dict().items()]
    return [
        f";@machine {settings.printer_profile.gpx_machine}",
        ";@flavor makerbot",
        *(_comment(text) for text in [*header, *values]),
    ]


def _comment(text: str) -> str:
    """A comment that neither converter stumbles over: ASCII, one line, no sign with a meaning of its own."""
    plain = text.encode("ascii", "replace").decode()[:_MAX_COMMENT]
    return "; " + "".join(sign if sign.isprintable() and sign not in "#@;()" else "?" for sign in plain)


def _joined(lines: list[str]) -> bytes:
    return "".join(line + "\n" for line in lines).encode("ascii")
