"""The numbers of the lines that move the nozzle, rounded as the file holds them."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model import BoolArray, IntArray
from ..parallel import CHUNK_ROWS
from ..records import dataclass
from ..settings.printer import PrinterProfile
from ..toolpaths.moves import Moves
from .numbers import BACKWARDS_LIMIT, FEEDRATE_LIMIT, FILAMENT_LIMIT


@dataclass(frozen=True)
class Lines:
    """The numbers of K lines `G1 X Y Z A|B F`; each line has at least one axis.

    Attributes:
        thousandths: (K, 3) int32, X, Y, Z in 0.001 mm, axis by axis in memory.
        written: (K, 3) bool, which of them the line names.
        steps: (K,) int64, filament in 0.00001 mm: the tool's counter, or what the line feeds if that is relative.
        feeds: (K,) bool, whether the line names the filament axis.
        tool: (K,) int64.
        feedrate: (K,) int32 mm/min.
        hastens: (K,) bool, whether the line names the feedrate, which otherwise stays what it was.
    """

    thousandths: NDArray[np.int32]
    written: BoolArray
    steps: IntArray
    feeds: BoolArray
    tool: IntArray
    feedrate: NDArray[np.int32]
    hastens: BoolArray


def filament_steps(moves: Moves, begin: tuple[float, float]) -> tuple[list[float], IntArray]:
    """Each tool's final counter in mm, and (M,) the active tool's counter in 0.00001 mm after each row.

    Args:
        moves: the print, at least one row.
        begin: mm, the counters before it.

    Raises:
        ValueError: more filament than the counters can hold.
    """
    is_first = moves.tool == 0
    counters = [
        start + np.cumsum(np.where(own, moves.filament, 0.0))
        for start, own in zip(begin, (is_first, ~is_first), strict=True)
    ]
    totals = [float(counter[-1]) for counter in counters]
    counter = np.where(is_first, counters[0], counters[1])
    counter *= 1e5
    steps = np.rint(counter, out=counter).astype(np.int64)
    if steps.max() >= FILAMENT_LIMIT or steps.min() <= -BACKWARDS_LIMIT:
        raise ValueError("the print needs more filament than the file's counters can hold")
    return totals, steps


def rounded_lines(moves: Moves, steps: IntArray, printer: PrinterProfile) -> tuple[Lines, IntArray]:
    """The lines to write, and (R,) the rows that get none, ascending.

    Args:
        moves: M rows.
        steps: (M,) see `Lines`.
        printer: that they are for.
    """
    fresh = after_break(moves.tool)
    thousandths = np.empty((3, len(fresh)), dtype=np.int32)
    for row in range(0, len(fresh), CHUNK_ROWS):
        here = slice(row, row + CHUNK_ROWS)
        scaled = np.multiply(moves.position[here].T, 1000, order="C")
        thousandths[:, here] = np.rint(scaled, out=scaled)
    written = np.repeat(fresh[None], 3, axis=0)
    written[:, 1:] |= thousandths[:, 1:] != thousandths[:, :-1]
    feeds = moves.filament != 0
    feedrate = np.minimum(moves.speed, printer.max_speed_mm_s[0])
    feedrate *= 60
    lifts = np.flatnonzero(written[2] & ~(written[0] | written[1]))
    feedrate[lifts] = np.minimum(feedrate[lifts], printer.max_speed_mm_s[2] * 60)
    feedrate = np.rint(feedrate, out=feedrate).clip(1, FEEDRATE_LIMIT - 1, out=feedrate).astype(np.int32)
    kept = written.any(axis=0)
    stands = np.flatnonzero(feeds & ~kept)
    # What feeds less than the file can tell, on the spot, is no line.
    kept[stands] = steps[stands] != (0 if printer.marlin else steps[stands - 1])
    left_out = np.flatnonzero(~kept)
    columns: list[NDArray[Any]] = [thousandths, written, steps, feeds, moves.tool, feedrate, fresh]
    lines = Lines(*(_without(column, left_out).T for column in columns))
    lines.hastens[1:] |= lines.feedrate[1:] != lines.feedrate[:-1]
    return lines, left_out


def _without(column: NDArray[Any], rows: IntArray) -> NDArray[Any]:
    """A column (…, M) without a few of its rows, copied block by block: mostly there is hardly one."""
    if not len(rows):
        return column
    edges = [-1, *rows.tolist(), column.shape[-1]]
    return np.concatenate([column[..., last + 1 : row] for last, row in pairwise(edges)], axis=-1)


def after_break(tool: IntArray) -> BoolArray:
    """(M,) rows before which other commands stand, so that nothing may be taken over from the row before."""
    fresh = np.ones(len(tool), dtype=bool)
    fresh[1:] = tool[1:] != tool[:-1]
    return fresh
