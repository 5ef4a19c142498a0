"""A print into the text of a G-code file, in bulk."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from ..model import FloatArray, IntArray
from ..records import dataclass
from ..settings import PrintSettings
from ..settings.header_text import written
from ..toolpaths.move_times import layer_begins, move_seconds
from ..toolpaths.moves import Moves
from .lines import Lines
from .numbers import TextArray, coordinate_texts, feedrate_texts, five_decimals, whole_texts, word
from .program import PROGRESS, WIDTH_STEP, Program, joined, progress_lines, untimed_program

_CHUNK_ROWS = 1 << 13  # a chunk's words stay in the processor's cache
_MAX_COMMENT = 900
_STEPS_A_MM = 100_000  # of filament
_G1, _Z = word("G1"), word(" Z")
# Letters with a blank, and the numbers after them; the letter of `whole` stands in its table.
_SIZES = {"G1": 4, "x": 8, "Y": 2, "y": 8, "Z": 2, "z": 8, "whole": 8, "fraction": 8, "end": 8}
_LINE = np.dtype([(name, f"u{size}") for name, size in _SIZES.items()])
_USUAL_LINE = bytearray(np.array([(word("G1 X"), 0, word(" Y"), 0, 0, 0, 0, 0, word("\n"))], dtype=_LINE).tobytes())


@dataclass(frozen=True)
class _Tables:
    """Text by number, eight characters each, for the numbers of some lines.

    Attributes:
        coordinate: in steps of a thousandth.
        zero: place of 0 among them.
        whole: (4, W) mm of filament from 0 on behind the letters of both tools, then the same below 0.
        feedrate: mm/min from 0 on, behind their letter, with the line's end.
    """

    coordinate: TextArray
    zero: int
    whole: TextArray
    feedrate: TextArray


@dataclass(frozen=True)
class BegunText:
    """The part of a print's file that does not depend on its times and totals.

    Attributes:
        content: the program, see `untimed_program`.
        chunks: text of its lines and of what stands between them, some thousand lines at a time.
    """

    content: Program
    chunks: list[bytes]


def begin_text(moves: Moves, settings: PrintSettings) -> BegunText:
    """Begin the file's text, which takes most of its time, before the times and totals of the print are known.

    Raises:
        ValueError: see `counted_text`.
    """
    content = untimed_program(moves, settings)
    tables = _tables(content.lines, settings.printer_profile.tool_axes)
    places, texts = _with_widths(content)
    bounds = [*range(0, len(content.lines.tool), _CHUNK_ROWS), len(content.lines.tool)]
    ends = np.searchsorted(places, bounds[1:-1]).tolist()
    # More threads would only wait for each other: half of it is done by Python's own bytes.
    chunks = [
        _rendered(content.lines, tables, slice(*rows), places[slice(*own)], texts[slice(*own)])
        for rows, own in zip(pairwise(bounds), pairwise([0, *ends, len(texts)]), strict=True)
    ]
    return BegunText(content, chunks)


def counted_text(
    moves: Moves,
    settings: PrintSettings,
    header: list[str],
    begins: FloatArray | None = None,
    begun: BegunText | None = None,
) -> tuple[bytes, int]:
    """The whole file, see `program`, and how many of its lines are `G1`.

    Args:
        moves: the print, at least one row.
        settings: of the print; they are written into the header.
        header: more lines for the header, without a comment sign, such as "layers = 408".
        begins: `move_times.layer_begins` of the moves, if they are known.
        begun: `begin_text` of the moves, if it has been called.

    Raises:
        ValueError: no moves, or numbers that are not finite or too large for the file.
    """
    begun = begun or begin_text(moves, settings)
    if begins is None:
        begins = layer_begins(moves, move_seconds(moves, settings.printer_profile))
    content = begun.content
    first, last = joined(_header_lines(settings, header) + content.start), joined(content.end)
    others = b"".join([b"\n", first, *content.insertions, last]).count(b"\nG1 ")
    return b"".join(
        [first, *_with_progress(begun.chunks, progress_lines(begins, settings.printer_profile)), last]
    ), len(content.lines.tool) + others


def _with_widths(content: Program) -> tuple[IntArray, list[bytes]]:
    """The insertions as text, and comments where the width of the lines changes."""
    if not len(content.widths):
        return content.places, content.insertions
    texts = content.insertions + [b"; width %.3f\n" % width for width in (content.widths * WIDTH_STEP).tolist()]
    places = np.concatenate([content.places, content.width_places])
    order = np.argsort(places, kind="stable")
    return places[order], [texts[number] for number in order.tolist()]


def _with_progress(chunks: list[bytes], progress: list[bytes]) -> Iterator[bytes | memoryview]:
    """The chunks in pieces, without copies, with their `PROGRESS` replaced."""
    lines = iter(progress)
    for text in chunks:
        begin, end = 0, text.find(PROGRESS[0])
        while end >= 0:
            yield from (memoryview(text)[begin:end], next(lines))
            begin = end + len(PROGRESS)
            end = text.find(PROGRESS[0], begin)
        yield memoryview(text)[begin:]


def _tables(lines: Lines, axes: Sequence[str]) -> _Tables:
    whole = max(int(lines.steps.max(initial=0)), -int(lines.steps.min(initial=0))) // _STEPS_A_MM
    return _Tables(
        *coordinate_texts(int(lines.thousandths.min(initial=0)), int(lines.thousandths.max(initial=0))),
        whole_texts([f" {axis}{sign}" for sign in ("", "-") for axis in axes], whole),
        feedrate_texts(int(lines.feedrate.max(initial=0))),
    )


def _rendered(lines: Lines, tables: _Tables, rows: slice, places: IntArray, texts: list[bytes]) -> bytes:
    """Some lines as text: each is a row of words, from which zero bytes are deleted.

    Words that most lines have are written into all lines and then taken out of the others.

    Args:
        lines: of the print.
        tables: the texts of their numbers.
        rows: which of them.
        places: (I,) int64, ascending, before which lines other texts stand.
        texts: I of these.
    """
    padded: bytearray = _USUAL_LINE * (rows.stop - rows.start)
    text = np.frombuffer(padded, dtype=_LINE)
    thousandths, written, feeds = lines.thousandths[rows], lines.written[rows], lines.feeds[rows]
    for axis, name in enumerate(("x", "y")):
        text[name] = tables.coordinate.take(thousandths[:, axis] + tables.zero)
    text["whole"], text["fraction"] = _filament(lines.steps[rows], lines.tool[rows], tables)
    for named, names in ((written[:, 0], ("x",)), (written[:, 1], ("Y", "y")), (feeds, ("whole", "fraction"))):
        row = np.flatnonzero(~named)
        for name in names:
            text[name][row] = 0
    text["G1"][~written[:, 0]] = _G1
    row = np.flatnonzero(written[:, 2])
    text["Z"][row], text["z"][row] = _Z, tables.coordinate.take(thousandths[row, 2] + tables.zero)
    row = np.flatnonzero(lines.hastens[rows])
    text["end"][row] = tables.feedrate.take(lines.feedrate[rows][row])
    whole, begin = memoryview(padded), 0
    pieces: list[bytes | memoryview] = []
    for end, other in zip(((places - rows.start) * _LINE.itemsize).tolist(), texts, strict=True):
        pieces += (whole[begin:end], other)
        begin = end
    return b"".join([*pieces, whole[begin:]]).translate(None, b"\0")


def _filament(steps: IntArray, tool: IntArray, tables: _Tables) -> tuple[TextArray, TextArray]:
    """The filament's axis with the whole mm, and the fraction."""
    size = np.abs(steps)
    whole = size // _STEPS_A_MM
    size -= _STEPS_A_MM * whole
    whole += tables.whole.shape[1] * tool
    if steps.min(initial=0) < 0:
        whole += 2 * tables.whole.shape[1] * (steps < 0)
    return tables.whole.take(whole), five_decimals().take(size)


def _header_lines(settings: PrintSettings, header: list[str]) -> list[str]:
    values = [f"{name} = {written(str(value))}" for name, value in settings.as_dict().items()]
    printer = settings.printer_profile
    for_gpx = [] if printer.marlin else [f";@machine {printer.gpx_machine}", ";@flavor makerbot"]
    return [*for_gpx, *(_comment(text) for text in [*header, *values])]


def _comment(text: str) -> str:
    """A comment that neither converter stumbles over: ASCII, one line, no sign with a meaning of its own."""
    plain = text.encode("ascii", "replace").decode()[:_MAX_COMMENT]
    return "; " + "".join(sign if sign.isprintable() and sign not in "#@;()" else "?" for sign in plain)
