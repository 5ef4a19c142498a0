"""The print as commands, before they become text or X3G: lines, and the commands between them."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..paths import Feature
from ..records import dataclass
from ..settings import PrintSettings
from ..settings.printer import PrinterProfile
from ..settings.temperatures import starting_temperatures
from ..toolpaths.move_times import layer_begins, layer_changes, move_seconds
from ..toolpaths.moves import Moves
from .after_first_layer import after_first_layer
from .comments import feature_comments, layer_comments
from .fan import fan_commands
from .lines import Lines, after_break, filament_steps, rounded_lines
from .marlin import fed_by_each
from .numbers import COORDINATE_LIMIT
from .row_commands import RowCommands
from .sequences import StartSequence, end_sequence, start_sequence, tool_change_lines
from .standby import standby, standby_commands

WIDTH_STEP = 0.002
"""mm, resolution of the widths in comments."""

PROGRESS = b"\1\n"
"""A line, at each layer, that stands for its progress until the times are known; no other line has this sign."""


@dataclass(frozen=True)
class Program:
    """A print as commands: start, lines with other commands between them, end.

    Attributes:
        start: commands before the first line.
        lines: one for each move that changes a number.
        places: (I,) int64, ascending, the line before which each insertion stands.
        insertions: comments, progress and tool changes, lines of text each.
        width_places: (W,) int64, ascending, lines from which on lines of plastic have another width.
        widths: (W,) that width in steps of `WIDTH_STEP`; before the first it is the usual one.
        end: commands after the last line.
    """

    start: list[str]
    lines: Lines
    places: IntArray
    insertions: list[bytes]
    width_places: IntArray
    widths: IntArray
    end: list[str]


def program(moves: Moves, settings: PrintSettings, begins: FloatArray | None = None) -> Program:
    """The whole program, see `untimed_program`.

    Args:
        moves: the print, at least one row.
        settings: of the print.
        begins: `move_times.layer_begins` of the moves, if they are known.

    Raises:
        ValueError: no moves, or numbers that are not finite or too large for the file.
    """
    content = untimed_program(moves, settings)
    if begins is None:
        begins = layer_begins(moves, move_seconds(moves, settings.printer_profile))
    lines = iter(progress_lines(begins, settings.printer_profile))
    insertions = [text.replace(PROGRESS, next(lines)) if PROGRESS in text else text for text in content.insertions]
    return replace(content, insertions=insertions)


def progress_lines(begins: FloatArray, printer: PrinterProfile) -> list[bytes]:
    """By layer, the line with the share of the time that has passed when it begins; empty where that is no greater.

    Args:
        begins: s that pass before each layer, and the total.
        printer: one with Marlin's commands is also told how many minutes are left, from the first layer on.
    """
    rest = [b" R%d" % math.ceil(left / 60) if printer.marlin else b"" for left in (begins[-1] - begins[:-1]).tolist()]
    share = begins[:-1] / begins[-1] if begins[-1] > 0 else begins[:-1]
    percents = (share * 100).astype(np.int64).clip(0, 99).tolist()  # a print is never done before its end
    steps = zip(pairwise([-1 if printer.marlin else 0, *percents]), rest, strict=True)
    return [b"M73 P%d%s\n" % (percent, left) if percent > before else b"" for (before, percent), left in steps]


def untimed_program(moves: Moves, settings: PrintSettings) -> Program:
    """Round the moves to the numbers of the file and put the commands around them; the progress is only marked.

    Moves that would change no number of the line before (shorter than the file's resolution) get no line. A tool
    that the moves first prime is left pulled back by that length after the start sequence.

    Args:
        moves: the print, at least one row.
        settings: of the print.

    Raises:
        ValueError: no moves, or numbers that are not finite or too large for the file.
    """
    _check(moves)
    extrudes = moves.extrudes
    start = _start(moves, extrudes, settings)
    counters, steps = filament_steps(moves, start.counters)
    printer = settings.printer_profile
    if printer.marlin:
        steps = fed_by_each(steps, moves.tool)
        moves = replace(moves, position=moves.position + np.array([*printer.marlin.origin, 0.0]))
    lines, left_out = rounded_lines(moves, steps, printer)
    heating = _heating(moves, settings)
    strands = np.flatnonzero(extrudes)
    rows, insertions = _insertions(moves, strands, heating, printer)
    last_tool = int(moves.tool[-1])
    end = end_sequence(settings, last_tool, counters[last_tool])
    widens, widths = _width_changes(moves, strands, settings.extrusion_width)
    places, width_places = (some - np.searchsorted(left_out, some) for some in (rows, widens))
    return Program(start.lines, lines, places, insertions, width_places, widths, end)


def _heating(moves: Moves, settings: PrintSettings) -> RowCommands:
    """All commands of heaters and fan between the moves."""
    resting, parts = None, []
    if settings.standby_temperature_delta:
        resting = standby(moves, move_seconds(moves, settings.printer_profile), settings)
        parts.append(standby_commands(moves, resting, settings))
    parts += [after_first_layer(moves, settings, resting), fan_commands(moves, settings)]
    return RowCommands.joined(parts)


def _check(moves: Moves) -> None:
    """Raise ValueError where the file cannot hold the moves, see `untimed_program`."""
    if not len(moves.tool):
        raise ValueError("there are no moves to write")
    # What is not a number is neither the least nor the greatest, but in place of both.
    extremes = [(column.min(), column.max()) for column in (moves.position, moves.filament, moves.speed)]
    if not np.isfinite(extremes).all():
        raise ValueError("the moves hold a number that is not finite")
    if np.abs(extremes[0]).max() * 1000 >= COORDINATE_LIMIT - 1:
        raise ValueError("the moves leave the range of coordinates that the file can hold")


def _start(moves: Moves, extrudes: BoolArray, settings: PrintSettings) -> StartSequence:
    """The start sequence, for the tools that the print uses; `extrudes` (M,) as of its moves."""
    first = int(moves.tool[0])
    hot = starting_temperatures(settings, moves.tool, moves.layer)
    hot[first] = hot.pop(first)  # it is primed last
    front = float(np.where(extrudes, moves.position[:, 1], np.inf).min()) if extrudes.any() else 0.0
    return start_sequence(settings, hot, (_first_prime(moves, 0), _first_prime(moves, 1)), front)


def _first_prime(moves: Moves, tool: int) -> float:
    """How far the tool's filament is pulled back, mm, when the moves first feed it."""
    feeds = (moves.tool == tool) & (moves.filament != 0)
    first = int(feeds.argmax())
    if not feeds[first] or moves.feature[first] != Feature.RETRACT:
        return 0.0
    return max(float(moves.filament[first]), 0.0)


def _insertions(
    moves: Moves, strands: IntArray, heating: RowCommands, printer: PrinterProfile
) -> tuple[IntArray, list[bytes]]:
    """Insertions between the lines: comments at layers and features, marks for the progress, tool changes.

    Args:
        moves: the print.
        strands: (E,) rows that lay down a strand.
        heating: see `_heating`.
        printer: that it is for.

    Returns:
        (I,) int64 the row before which each insertion stands, ascending, and their text.
    """
    layer_starts = layer_changes(moves.layer)
    tool_starts = after_break(moves.tool)
    tool_starts[0] = False
    feature = moves.feature[strands]
    feature_starts = np.zeros(len(layer_starts), dtype=bool)
    feature_starts[strands[np.append(True, feature[1:] != feature[:-1])[: len(feature)]]] = True
    others = layer_starts | tool_starts
    others[list(heating.before)] = True
    rows = np.flatnonzero(others | feature_starts)
    kinds = feature_comments(printer)
    insertions = [kinds[number] for number in moves.feature[rows].tolist()]
    place = np.flatnonzero(others[rows])
    top = moves.position[np.append(strands, -1)[np.searchsorted(strands, rows[place])], 2]
    travels = _travels_ahead(moves, np.flatnonzero(tool_starts), printer)
    for number, row, height in zip(place.tolist(), rows[place].tolist(), top.tolist(), strict=True):
        lines = list(heating.before.get(row, []))
        if layer_starts[row]:
            lines += [*layer_comments(int(moves.layer[row]), height, printer), PROGRESS[:-1].decode()]
        if tool_starts[row]:
            lines += [*travels.get(row, []), *tool_change_lines(int(moves.tool[row]), printer)]
        lines += heating.after.get(row, [])
        insertions[number] = joined(lines) + (insertions[number] if feature_starts[row] else b"")
    return rows, insertions


def _travels_ahead(moves: Moves, changes: IntArray, printer: PrinterProfile) -> dict[int, list[str]]:
    """By row, the travel with which it begins, to be made before the tool changes there, if it is one.

    Marlin shifts the carriage at once, so that the other nozzle, which may drip, comes to where the last one is: better
    over the tower than over what was printed last. Klipper shifts it with the row itself, at the same height.

    Args:
        moves: in the printer's coordinates.
        changes: (C,) rows with which another tool begins.
        printer: that they are for.
    """
    rows = changes[moves.filament[changes] == 0] if printer.marlin else changes[:0]
    feedrate = np.minimum(moves.speed[rows], printer.max_speed_mm_s[0]) * 60
    places = zip(rows.tolist(), moves.position[rows].tolist(), feedrate.tolist(), strict=True)
    return {row: [f"G1 X{x:.3f} Y{y:.3f} Z{z:.3f} F{feed:.0f}"] for row, (x, y, z), feed in places}


def _width_changes(moves: Moves, strands: IntArray, usual: float) -> tuple[IntArray, IntArray]:
    """Rows from which on the width is another one, and these widths in steps.

    From the filament alone, whose lengths are rounded as those of the moves are, the width of a short move cannot be
    computed exactly.
    """
    width = moves.width[strands]
    # Most neighbors have the very same width.
    changes = np.flatnonzero(np.append(True, width[1:] != width[:-1]))[: len(strands)]
    steps = np.rint(width[changes] / WIDTH_STEP).astype(np.int64)
    is_new = np.diff(steps, prepend=round(usual / WIDTH_STEP)) != 0
    return strands[changes[is_new]], steps[is_new]


def joined(lines: list[str]) -> bytes:
    """Lines as text, with the last one's end."""
    return "\n".join([*lines, ""]).encode("ascii")
