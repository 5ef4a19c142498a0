"""What the printer is told, before it becomes text or X3G: numbers of the lines, and the commands between them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model import BoolArray, FloatArray, IntArray
from ..pattern.chunks import in_chunks
from ..printer import PrinterProfile
from ..settings import PrintSettings
from ..statistics import layer_begins, layer_changes, move_seconds
from ..toolpaths.moves import Feature, Moves
from .marlin import fed_by_each
from .numbers import COORDINATE_LIMIT, FEEDRATE_LIMIT, FILAMENT_LIMIT
from .sequences import StartSequence, end_sequence, start_sequence, tool_change_lines
from .standby import standby_commands

# Lines of the idle nozzle by row, before the row and after its tool change.
IdleCommands = tuple[dict[int, list[str]], dict[int, list[str]]]

WIDTH_STEP = 0.002
"""mm; widths of lines are told so finely."""


@dataclass(frozen=True)
class Lines:
    """The numbers of K lines `G1 X Y Z A|B F`; each line has at least one axis.

    Attributes:
        thousandths: (K, 3) int64, X, Y, Z in 0.001 mm.
        written: (K, 3) bool, which of them the line names.
        steps: (K,) int64, filament in 0.00001 mm: the tool's counter, or what the line feeds if that is relative.
        feeds: (K,) bool, whether the line names the filament axis.
        tool: (K,) int64.
        feedrate: (K,) int64 mm/min.
        hastens: (K,) bool, whether the line names the feedrate, which otherwise stays what it was.
    """

    thousandths: IntArray
    written: BoolArray
    steps: IntArray
    feeds: BoolArray
    tool: IntArray
    feedrate: IntArray
    hastens: BoolArray


@dataclass(frozen=True)
class Program:
    """A print as commands: start, lines with other commands between them, end.

    Attributes:
        start: commands before the first line.
        lines: one for each move that changes a number.
        places: (I,) int64, ascending, the line before which each insertion stands.
        insertions: comments, progress and tool changes.
        width_places: (W,) int64, ascending, lines from which on lines of plastic have another width.
        widths: (W,) that width in steps of `WIDTH_STEP`; before the first it is the usual one.
        end: commands after the last line.
    """

    start: list[str]
    lines: Lines
    places: IntArray
    insertions: list[list[str]]
    width_places: IntArray
    widths: IntArray
    end: list[str]


def program(moves: Moves, settings: PrintSettings, begins: FloatArray | None = None) -> Program:
    """Round the moves to the numbers of the file and put the commands around them.

    Moves that would change no number of the line before (shorter than the file's resolution) get no line. A tool
    that the moves first prime is left pulled back by that length after the start sequence.

    Args:
        moves: the print, at least one row.
        settings: of the print.
        begins: `statistics.layer_begins` of the moves, if they are known.

    Raises:
        ValueError: no moves, or numbers that are not finite or too large for the file.
    """
    _check(moves)
    start = _start(moves, settings)
    counters, steps = _filament_steps(moves, start.counters)
    printer = settings.printer_profile
    if printer.marlin:
        steps = fed_by_each(steps, moves.tool)
        moves = replace(moves, position=moves.position + np.array([*printer.marlin.origin, 0.0]))
    lines, kept_before = _lines(moves, steps, printer)
    idle: IdleCommands = ({}, {})
    if begins is None or settings.standby_temperature_delta:
        seconds = move_seconds(moves, printer)
        begins = layer_begins(moves, seconds)
        if settings.standby_temperature_delta:
            idle = standby_commands(moves, seconds, settings)
    places, insertions = _insertions(moves, kept_before, begins, idle, printer)
    last_tool = int(moves.tool[-1])
    end = end_sequence(settings, last_tool, counters[last_tool])
    widens, widths = _width_changes(moves, settings.extrusion_width)
    return Program(start.lines, lines, places, insertions, kept_before[widens], widths, end)


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
    others = (1 - first,) if (moves.tool != first).any() else ()
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


def _lines(moves: Moves, steps: IntArray, printer: PrinterProfile) -> tuple[Lines, IntArray]:
    """The lines to write, and (M,) how many of them stand before each row."""
    fresh = _after_break(moves.tool)
    top_speed = printer.max_speed_mm_s[0]

    def chunk(row: IntArray) -> tuple[NDArray[Any], ...]:
        """The columns of some rows that follow each other, and which of them are kept."""
        here = slice(int(row[0]), int(row[-1]) + 1)
        thousandths = np.rint(moves.position[max(here.start - 1, 0) : here.stop] * 1000).astype(np.int64)
        written = np.repeat(fresh[here, None], 3, axis=1)
        # The first row of all has none before it; it is fresh anyway.
        written[max(1 - here.start, 0) :] |= thousandths[1:] != thousandths[:-1]
        thousandths = thousandths[-len(row) :]
        feeds = moves.filament[here] != 0
        feedrate = np.rint(np.minimum(moves.speed[here], top_speed) * 60).astype(np.int64).clip(1, FEEDRATE_LIMIT - 1)
        kept = written[:, 0] | written[:, 1] | written[:, 2] | feeds
        return thousandths, written, feeds, feedrate, kept

    *columns, kept = in_chunks(chunk, np.arange(len(moves.tool)))
    columns += [steps, moves.tool, fresh.copy()]
    if not kept.all():
        columns = [column[kept] for column in columns]
    thousandths, written, feeds, feedrate, steps, tool, changed = columns
    changed[1:] |= feedrate[1:] != feedrate[:-1]
    return Lines(thousandths, written, steps, feeds, tool, feedrate, changed), np.cumsum(kept) - kept


def _insertions(
    moves: Moves, kept_before: IntArray, begins: FloatArray, idle: IdleCommands, printer: PrinterProfile
) -> tuple[IntArray, list[list[str]]]:
    """What stands between the lines: comments at layers and features, the progress at each layer, the tool changes.

    Args:
        moves: the print.
        kept_before: (M,) how many lines stand before each row.
        begins: s that pass before each layer, and the total.
        idle: see `standby_commands`.
        printer: that it is for.

    Returns:
        (I,) int64 the line before which each insertion stands, ascending, and their lines.
    """
    layer_starts = layer_changes(moves.layer)
    tool_starts = _after_break(moves.tool)
    tool_starts[0] = False
    feature_starts = _feature_starts(moves)
    starts = layer_starts | tool_starts | feature_starts
    starts[list(idle[0])] = True
    rows = np.flatnonzero(starts)
    percents = iter(_percents(begins))
    insertions = []
    shown = 0
    for row in rows.tolist():
        lines = list(idle[0].get(row, []))
        if layer_starts[row]:
            lines.append(f"; layer {moves.layer[row]}")
            percent = next(percents)
            if percent > shown:
                lines.append(f"M73 P{percent}")
                shown = percent
        lines += tool_change_lines(int(moves.tool[row]), printer) if tool_starts[row] else []
        lines += idle[1].get(row, [])
        if feature_starts[row]:
            lines.append("; " + Feature(moves.feature[row]).name.lower().replace("_", " "))
        insertions.append(lines)
    return kept_before[rows], insertions


def _width_changes(moves: Moves, usual: float) -> tuple[IntArray, IntArray]:
    """Rows from which on the width is another one, and these widths in steps.

    From the filament alone, whose lengths are rounded as those of the moves are, the width of a short move cannot be
    told exactly.
    """
    rows = np.flatnonzero(moves.extrudes)
    widths = np.rint(moves.width[rows] / WIDTH_STEP).astype(np.int64)
    changes = np.flatnonzero(np.diff(widths, prepend=round(usual / WIDTH_STEP)))
    return rows[changes], widths[changes]


def _percents(begins: FloatArray) -> list[int]:
    """The share of the time that has passed when each layer begins; a print is never done before its end."""
    share = begins[:-1] / begins[-1] if begins[-1] > 0 else begins[:-1]
    percents: list[int] = (share * 100).astype(np.int64).clip(0, 99).tolist()
    return percents


def _feature_starts(moves: Moves) -> BoolArray:
    """(M,) rows that extrude for another feature than those before them."""
    rows = np.flatnonzero(moves.extrudes)
    starts = np.zeros(len(moves.feature), dtype=bool)
    starts[rows] = np.diff(moves.feature[rows], prepend=-1) != 0
    return starts
