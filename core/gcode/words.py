"""The words of a G-code file as tables, parsed in bulk."""

from __future__ import annotations

import re
import warnings

import numpy as np
from numpy.typing import NDArray

from ..errors import PrintError
from ..files import MOST_PRINT_BYTES
from ..model import FloatArray, IntArray
from ..records import dataclass

LETTERS = "XYZABEFT"
_COLUMN = np.full(256, -1, dtype=np.int64)
for _number, _letter in enumerate(LETTERS):
    _COLUMN[ord(_letter)] = _number
_CHUNK_BYTES = 1 << 22
_MOST_LINES = 8_000_000  # keeps the tables within a gigabyte
_HINT = "export the print again"
_NOT_WORDS = re.compile(rb";[^\n]*|\([^)\n]*\)|\bM(?:70|117|118)\b[^\n]*")
_COMMENT = re.compile(rb";[^\n]*")
_BLANK, _NEWLINE, _LETTER, _DIGIT, _STRANGE = range(5)
_KIND = np.full(256, _STRANGE, dtype=np.uint8)
_KIND[list(b" \t\r")] = _BLANK
_KIND[ord("\n")] = _NEWLINE
_KIND[ord("A") : ord("Z") + 1] = _LETTER
_KIND[list(b"0123456789.+-")] = _DIGIT
_LETTERS_TO_BLANKS = bytes(32 if 65 <= value <= 90 else value for value in range(256))


@dataclass(frozen=True)
class Words:
    """A file of C commands.

    Attributes:
        line: (C,) int64, the line of each, from 1.
        letter: (C,) uint8, of the command: G, M or T as a character code.
        number: (C,) float64, of the command.
        values: (C, 8) float64, of the words `LETTERS`, NaN where the line has none; the bare T's own is there too.
        comments: line and text of each comment.
    """

    line: IntArray
    letter: NDArray[np.uint8]
    number: FloatArray
    values: FloatArray
    comments: list[tuple[int, str]]

    def are(self, letter: str, *numbers: int) -> NDArray[np.bool_]:
        """(C,) commands that are one of these."""
        return np.asarray((self.letter == ord(letter)) & np.isin(self.number, numbers))


def read_words(data: bytes) -> Words:
    """Parse the text, some MB at a time.

    Raises:
        PrintError: the file is empty, too long, broken off, or a line of it is no G-code.
    """
    if not data.strip():
        raise PrintError("the G-code file is empty", _HINT)
    lines = data.count(b"\n") + 1
    if len(data) > MOST_PRINT_BYTES or lines > _MOST_LINES:
        raise PrintError(f"the G-code file is too long: {len(data) / 1e6:.0f} MB, {lines} lines", "divide the print")
    parts = []
    comments: list[tuple[int, str]] = []
    begin, line = 0, 1
    while begin < len(data):
        end = data.find(b"\n", begin + _CHUNK_BYTES) + 1 or len(data)
        chunk = data[begin:end]
        parts.append(_parsed(chunk, line))
        comments += _comments(chunk, line)
        line += chunk.count(b"\n")
        begin = end
    line_of, letter, number, values = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Words(line_of, letter, number, values, comments)


def _parsed(chunk: bytes, first_line: int) -> tuple[IntArray, NDArray[np.uint8], FloatArray, FloatArray]:
    """Line, letter, number and values of the commands in a piece of the file."""
    text = b"\n" + _NOT_WORDS.sub(b"", chunk).upper() + b"\n"
    sign = np.frombuffer(text, dtype=np.uint8)
    kind = _KIND[sign]
    before = kind[:-1]
    # A word is a letter after a blank, then perhaps a number; nothing else stands on a line.
    wrong = kind[1:] == _STRANGE
    wrong |= (kind[1:] == _LETTER) & (before >= _LETTER)
    wrong |= (kind[1:] == _DIGIT) & (before < _LETTER)
    if wrong.any():
        raise _damaged(text, int(np.argmax(wrong)) + 1, first_line)
    at = np.flatnonzero((kind == _LETTER) | (kind == _NEWLINE))
    is_end = kind[at] == _NEWLINE
    line = np.cumsum(is_end)[~is_end] - 1
    at = at[~is_end]
    has_number = kind[at + 1] == _DIGIT
    number = np.full(len(at), np.nan)
    number[has_number] = _numbers(text, int(has_number.sum()), at[has_number], first_line)
    leads = np.ones(len(at), dtype=bool)
    leads[1:] = line[1:] != line[:-1]
    lead = np.flatnonzero(leads)
    odd = ~np.isin(sign[at[lead]], list(b"GMT")) | ~has_number[lead]
    if odd.any():
        raise _damaged(text, int(at[lead[np.argmax(odd)]]), first_line)
    values = np.full((len(lead), len(LETTERS)), np.nan)
    column = _COLUMN[sign[at]]
    named = np.flatnonzero(column >= 0)
    values[(np.cumsum(leads) - 1)[named], column[named]] = number[named]
    return line[lead] + first_line, sign[at[lead]], number[lead], values


def _numbers(text: bytes, count: int, at: IntArray, first_line: int) -> FloatArray:
    """(K,) the numbers after letters at `at` (K,) in the text; raises PrintError where one is none."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # for text that is not a number; the count shows it
        try:
            numbers = np.fromstring(text.translate(_LETTERS_TO_BLANKS), dtype=np.float64, sep=" ")
        except ValueError:
            numbers = np.zeros(0)
    if len(numbers) != count or not np.isfinite(numbers).all():
        for place in at.tolist():
            word = re.match(rb"[^ \t\r\n]*", text[place + 1 : place + 60])
            if word and not re.fullmatch(rb"[+-]?(\d{1,30}(\.\d{0,30})?|\.\d{1,30})", word[0]):
                raise _damaged(text, place, first_line)
        raise PrintError("the G-code file is damaged: some of its numbers cannot be read", _HINT)
    return np.asarray(numbers)


def _damaged(text: bytes, place: int, first_line: int) -> PrintError:
    """The error that quotes the line around a place in the text."""
    line = first_line + text.count(b"\n", 0, place) - 1
    shown = text[text.rfind(b"\n", 0, place) + 1 :].split(b"\n", 1)[0][:40]
    plain = "".join(sign if sign.isprintable() else "?" for sign in shown.decode("ascii", "replace"))
    return PrintError(f"the G-code file is damaged: line {line} reads '{plain}'", _HINT)


def _comments(chunk: bytes, first_line: int) -> list[tuple[int, str]]:
    """Line and text of each comment in a piece of the file."""
    found = list(_COMMENT.finditer(chunk))
    if not found:
        return []
    ends = np.flatnonzero(np.frombuffer(chunk, dtype=np.uint8) == ord("\n"))
    lines = (np.searchsorted(ends, [match.start() for match in found]) + first_line).tolist()
    texts = (match[0].strip(b"; \t\r").decode("utf-8", "replace") for match in found)
    return list(zip(lines, texts, strict=True))
