"""The commands of a program, followed one after the other into the rows that X3G is made from."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..gcode.lines import Lines
from ..gcode.program import Program
from ..model import IntArray
from ..records import dataclass
from ..settings.printer import PrinterProfile
from . import commands
from .commands import Action, Command

_US_PER_MINUTE = 60_000_000
_LETTERS = "XYZAB"

Whole = NDArray[np.int32] | IntArray


class Kind(IntEnum):
    """What a row of the track does."""

    MOVE = 0
    SET_POSITION = 1
    STAND = 2  # an unplanned move to where the nozzle is: the firmware shifts the carriage to the new nozzle


@dataclass(frozen=True)
class Track:
    """All that moves, R rows, and the other commands between them.

    Attributes:
        position: (R, 3) int64, X, Y, Z after the row in 0.001 mm.
        counter: (R, 2) int64, filament counters of A and B after the row in 0.00001 mm.
        feedrate: (R,) int64 mm/min.
        kind: (R,) uint8, a `Kind`.
        inserted: (row before which it stands, bytes), in order.
    """

    position: IntArray
    counter: IntArray
    feedrate: IntArray
    kind: NDArray[np.uint8]
    inserted: list[tuple[int, bytes]]


def follow(content: Program, name: str, printer: PrinterProfile) -> Track:
    """The track of a program.

    Args:
        content: the program.
        name: of the build, as the printer shows it.
        printer: that it is for.
    """
    follower = _Follower(name, printer)
    follower.obey(content.start)
    ends = [*content.places.tolist(), len(content.lines.tool)]
    follower.print_lines(content.lines, slice(0, ends[0]))
    for insertion, (begin, end) in zip(content.insertions, pairwise(ends), strict=True):
        follower.obey(insertion.decode("ascii").splitlines())
        follower.print_lines(content.lines, slice(begin, end))
    follower.obey(content.end)
    return follower.track()


class _Follower:
    """Keeps the state that the commands leave: where the axes are, feedrate and active tool."""

    def __init__(self, name: str, printer: PrinterProfile) -> None:
        self._name = name
        self._printer = printer
        self._place = [0, 0, 0, 0, 0]
        self._feedrate = 0
        self._tool = 0
        self._rows = 0
        self._parts: list[tuple[Whole, IntArray, Whole, Kind]] = []
        self._inserted: list[tuple[int, bytes]] = []
        self._handlers: dict[str, Callable[[dict[str, str]], None]] = {
            "G1": self._move,
            "G92": self._set_position,
            "G161": lambda words: self._home(Command.HOME_MINIMUM, words),
            "G162": lambda words: self._home(Command.HOME_MAXIMUM, words),
            "M18": lambda words: self._insert(commands.switch_off_axes(_mask(words))),
            "M72": lambda words: self._insert(commands.song(int(words["P"]))),
            "M73": self._progress,
            "M104": lambda words: self._heat(Action.NOZZLE_TEMPERATURE, words),
            "M109": lambda words: self._heat(Action.BED_TEMPERATURE, words),
            "M126": lambda words: self._insert(commands.fan(int(words["T"]), True)),
            "M127": lambda words: self._insert(commands.fan(int(words["T"]), False)),
            "M132": lambda words: self._insert(commands.recall_home(_mask(words))),
            "M133": lambda words: self._insert(commands.wait_for(Command.WAIT_FOR_TOOL, int(words["T"]))),
            "M134": lambda words: self._insert(commands.wait_for(Command.WAIT_FOR_BED, int(words["T"]))),
            "M135": self._change_tool,
            "M136": lambda _: None,  # the build begins and ends with its progress
            "M137": lambda _: None,
        }

    def obey(self, lines: list[str]) -> None:
        """Follow commands other than the print's own lines."""
        for line in lines:
            code, *words = line.split()
            if not code.startswith(";"):
                self._handlers[code]({word[0]: word[1:] for word in words})

    def print_lines(self, lines: Lines, rows: slice) -> None:
        """Follow lines of the print, all of them of the active tool."""
        count = rows.stop - rows.start
        if not count:
            return
        fed = np.maximum.accumulate(np.where(lines.feeds[rows], np.arange(count), -1))
        counter = np.empty((count, 2), dtype=np.int64, order="F")
        counter[:] = self._place[3:]
        counter[:, self._tool] = np.where(fed >= 0, lines.steps[rows].take(fed), counter[0, self._tool])
        self._append(lines.thousandths[rows], counter, lines.feedrate[rows], Kind.MOVE)

    def track(self) -> Track:
        """All rows so far."""
        position, counter, feedrate, kinds = zip(*self._parts, strict=True)
        counts = [len(part) for part in feedrate]
        # Axis by axis in memory, as they are read.
        places, counters = (np.empty((columns, self._rows), dtype=np.int64).T for columns in (3, 2))
        return Track(
            np.concatenate(position, out=places),
            np.concatenate(counter, out=counters),
            np.concatenate(feedrate).astype(np.int64),
            np.repeat(np.array(kinds, dtype=np.uint8), counts),
            self._inserted,
        )

    def _append(self, position: Whole, counter: IntArray, feedrate: Whole, kind: Kind) -> None:
        """Add rows of one kind; the last one is where the axes are then."""
        self._parts.append((position, counter, feedrate, kind))
        self._rows += len(feedrate)
        self._place = [*position[-1].tolist(), *counter[-1].tolist()]
        self._feedrate = int(feedrate[-1])

    def _append_here(self, kind: Kind) -> None:
        """Add a row that ends where the axes are."""
        place = np.array([self._place], dtype=np.int64)
        self._append(place[:, :3], place[:, 3:], np.array([self._feedrate], dtype=np.int64), kind)

    def _insert(self, command: bytes) -> None:
        self._inserted.append((self._rows, command))

    def _take(self, words: dict[str, str]) -> bool:
        """Take over the numbers of a line; returns whether it names an axis."""
        for axis, letter in enumerate(_LETTERS):
            if letter in words:
                self._place[axis] = round(float(words[letter]) * (1000 if axis < 3 else 100_000))
        self._feedrate = int(words.get("F", self._feedrate))
        return any(letter in words for letter in _LETTERS)

    def _move(self, words: dict[str, str]) -> None:
        if self._take(words):
            self._append_here(Kind.MOVE)

    def _set_position(self, words: dict[str, str]) -> None:
        self._take(words)
        self._append_here(Kind.SET_POSITION)

    def _home(self, command: Command, words: dict[str, str]) -> None:
        """The feedrate is that of the carriage, so each of two axes gets its share of it."""
        axes = [axis for axis in range(3) if _LETTERS[axis] in words]
        self._feedrate = int(words["F"])
        feedrate = min([float(self._feedrate), *(self._printer.home_feedrate_mm_min[axis] for axis in axes)])
        steps_per_mm = max(self._printer.steps_per_mm[axis] for axis in axes)
        interval = _US_PER_MINUTE * len(axes) ** 0.5 / (feedrate * steps_per_mm)
        self._insert(commands.homing(command, _mask(words), round(interval)))

    def _heat(self, action: Action, words: dict[str, str]) -> None:
        self._insert(commands.temperature(action, int(words["T"]), int(words["S"])))

    def _progress(self, words: dict[str, str]) -> None:
        """Show the progress; the build begins with 0 % and ends with 100 %."""
        percent = int(words["P"])
        if percent == 0:
            self._insert(commands.build_start(self._name))
        self._insert(commands.progress(percent))
        if percent == 0:
            self._insert(commands.change_tool(self._tool))
        if percent == 100:
            self._insert(commands.build_end())

    def _change_tool(self, words: dict[str, str]) -> None:
        """Change the tool, unless it is active, and stand there while the carriage shifts."""
        tool = int(words["T"])
        if tool == self._tool:
            return
        self._tool = tool
        self._insert(commands.change_tool(tool))
        self._append_here(Kind.STAND)


def _mask(words: dict[str, str]) -> int:
    """The bits of the axes that a line names."""
    return sum(1 << axis for axis, letter in enumerate(_LETTERS) if letter in words)
