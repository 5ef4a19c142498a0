"""An X3G file as tables: what the commands are, and where each one leaves the printer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..errors import PrintError
from ..model import BoolArray, FloatArray, IntArray
from ..records import dataclass
from .commands import AXES, MOVE, SIZES, Command

ByteArray = NDArray[np.uint8]
StepArray = NDArray[np.int32]

_SIZE = np.zeros(256, dtype=np.int64)
for _command, _size in SIZES.items():
    _SIZE[_command] = _size
_TEXT_STARTS = {Command.BUILD_START: 5, Command.MESSAGE: 5}
_MAX_TEXT = 256
_ALIKE = 4096  # commands of the same kind that are looked for at once
_POSITIONED = (Command.MOVE, Command.MOVE_UNPLANNED, Command.MOVE_TIMED, Command.SET_POSITION)
_UNKNOWING = (Command.HOME_MINIMUM, Command.HOME_MAXIMUM, Command.RECALL_HOME)
_MOST_STEPS = 2**30  # so that differences fit too
_MOST_COMMANDS = 5_000_000  # keeps the tables within some hundred MB
_HINT = "export the print again"


@dataclass(frozen=True)
class Commands:
    """A file of C commands.

    Attributes:
        data: (B,) uint8, the file.
        offset: (C,) int64, where each command starts.
        code: (C,) uint8, a `Command`.
        tool: (C,) int64, active after the command; -1 before the first one is chosen.
        steps: (C, 5) int32, X, Y, Z, A, B after the command; forward is negative on A and B.
        known: (C, 5) bool, whether it is known where an axis is; the steps of an unknown one mean nothing.
        distance: (C,) mm that a planned move says it is long, NaN for all others.
        speed: (C,) mm/s along a planned move, NaN for all others.
    """

    data: ByteArray
    offset: IntArray
    code: ByteArray
    tool: IntArray
    steps: StepArray
    known: BoolArray
    distance: FloatArray
    speed: FloatArray

    @property
    def moves(self) -> BoolArray:
        """(C,) bool, commands that move to a place."""
        return np.isin(self.code, _POSITIONED[:3])

    @property
    def way(self) -> StepArray:
        """(C, 5) int32 steps that a move changes the known axes by, 0 for other commands."""
        way = np.zeros_like(self.steps)
        way[1:] = np.diff(self.steps, axis=0)
        way[1:] *= self.moves[1:, None] & self.known[1:] & self.known[:-1]
        way[:1] = 0
        return way

    def argument(self, at: IntArray, byte: int) -> IntArray:
        """(K,) int64, the byte at this place of each of the commands `at`."""
        values: IntArray = self.data[self.offset[at] + byte].astype(np.int64)
        return values


def read_x3g(data: bytes) -> Commands:
    """Take an X3G file apart.

    Raises:
        PrintError: the file is empty, cut short, too long, or holds something that is no command.
    """
    content = np.frombuffer(data, dtype=np.uint8)
    offset = _command_offsets(content)
    code = content[offset]
    tool = _tools(content, offset, code)
    steps, known = _positions(content, offset, code)
    distance, speed = np.full(len(code), np.nan), np.full(len(code), np.nan)
    planned = np.flatnonzero(code == Command.MOVE)
    records = _records(content, offset[planned])
    with np.errstate(invalid="ignore"):  # a length that is no number is a finding of the audit
        distance[planned], speed[planned] = records["distance"], records["speed"] / 64
    return Commands(content, offset, code, tool, steps, known, distance, speed)


def _command_offsets(content: ByteArray) -> IntArray:
    """Where each command starts; commands of the same kind in a row are stepped over together."""
    if not len(content):
        raise PrintError("the X3G file is empty", _HINT)
    found: list[IntArray] = []
    here = total = 0
    while here < len(content):
        code = int(content[here])
        size = _size_at(content, here, code)
        if here + size > len(content):
            raise PrintError(f"the X3G file breaks off in the middle of a command at byte {here}", _HINT)
        count = 1 if code in _TEXT_STARTS or code == Command.TOOL_ACTION else _alike(content, here, size)
        found.append(here + size * np.arange(count, dtype=np.int64))
        here += size * count
        total += count
        if total > _MOST_COMMANDS:
            raise PrintError(f"the X3G file has more than {_MOST_COMMANDS} commands", "divide the print")
    return np.concatenate(found)


def _size_at(content: ByteArray, here: int, code: int) -> int:
    """Bytes of the command that begins at a place; raises PrintError where none does."""
    size = int(_SIZE[code])
    if not size:
        raise PrintError(f"the X3G file is damaged: byte {here} is no command ({code})", _HINT)
    if code == Command.TOOL_ACTION and here + size <= len(content):
        return size + int(content[here + 3])
    if code in _TEXT_STARTS:
        begin = here + _TEXT_STARTS[Command(code)]
        ends = np.flatnonzero(content[begin : begin + _MAX_TEXT] == 0)
        if not len(ends):
            raise PrintError(f"the X3G file is damaged: the text at byte {begin} has no end", _HINT)
        return begin - here + int(ends[0]) + 1
    return size


def _alike(content: ByteArray, here: int, size: int) -> int:
    """How many whole commands of this size and kind follow each other from here, some thousand at most."""
    whole = min((len(content) - here) // size, _ALIKE)
    others = np.flatnonzero(content[here : here + whole * size : size] != content[here])
    return int(others[0]) if len(others) else whole


def _records(content: ByteArray, offset: IntArray) -> NDArray[np.void]:
    """(K,) the planned moves that start there."""
    return content[offset[:, None] + np.arange(MOVE.itemsize)].reshape(-1).view(MOVE)


def _tools(content: ByteArray, offset: IntArray, code: ByteArray) -> IntArray:
    """(C,) the active tool after each command."""
    changes = np.flatnonzero(code == Command.CHANGE_TOOL)
    chosen = np.concatenate([[-1], content[offset[changes] + 1]]).astype(np.int64)
    if (chosen > 1).any():
        raise PrintError(f"the X3G file asks for tool {chosen.max()}, but there are only 0 and 1", _HINT)
    tools: IntArray = chosen[np.searchsorted(changes, np.arange(len(code)), side="right")]
    return tools


def _positions(content: ByteArray, offset: IntArray, code: ByteArray) -> tuple[StepArray, BoolArray]:
    """(C, 5) steps and whether they are known, after each command."""
    count = len(code)
    relative = np.zeros(count, dtype=np.int64)
    lost = np.zeros(count, dtype=np.int64)
    placed = np.flatnonzero(np.isin(code, _POSITIONED))
    targets = content[offset[placed, None] + np.arange(1, 1 + 4 * AXES)].reshape(-1).view("<i4").reshape(-1, AXES)
    for command in (Command.MOVE, Command.MOVE_TIMED):
        rows = np.flatnonzero(code == command)
        relative[rows] = content[offset[rows] + 25]
    for command in _UNKNOWING:
        rows = np.flatnonzero(code == command)
        lost[rows] = content[offset[rows] + 1]
    steps, known = np.zeros((count, AXES), dtype=np.int32), np.zeros((count, AXES), dtype=bool)
    is_placed = np.zeros(count, dtype=bool)
    is_placed[placed] = True
    for axis in range(AXES):
        shifts = is_placed & (relative >> axis & 1 == 1)
        sets = is_placed & ~shifts
        loses = lost >> axis & 1 == 1
        given = np.zeros(count, dtype=np.int64)
        given[placed] = targets[:, axis]
        place, known[:, axis] = _followed(given, shifts, sets, loses)
        if np.abs(place).max() >= _MOST_STEPS:
            raise PrintError("the X3G file is damaged: a position is beyond all bounds", _HINT)
        steps[:, axis] = place
    return steps, known


def _followed(given: IntArray, shifts: BoolArray, sets: BoolArray, loses: BoolArray) -> tuple[IntArray, BoolArray]:
    """One axis after each command: what was last set, and all shifts since."""
    sums = np.cumsum(np.where(shifts, given, 0))
    last = np.maximum.accumulate(np.where(sets | loses, np.arange(len(given)), -1))
    base = np.where(sets[last], given[last] - sums[last], 0)
    known = (last >= 0) & sets[last]
    return np.where(known, base + sums, 0), known
