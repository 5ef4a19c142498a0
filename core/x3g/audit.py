"""Faults of an X3G file: an inspection of the finished bytes, independent of the code that wrote them."""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..records import dataclass
from ..settings.printer import PrinterProfile
from .commands import Action, Command
from .reader import Commands

_TOLERANCE_MM = 0.05  # a few steps of rounding
_LENGTH_TOLERANCE_MM = 0.1
_STEP_MM = 0.02
_LONG_MM = 1.0  # shorter moves are too much rounded to measure their speed
_HOMED = 0b111
_ENABLES = 0b10000000  # of the axes that SWITCH_AXES names
_LARGEST_SECTION_MM2 = 1.5  # of a strand, wider and higher than any setting allows
_FILAMENT_MM2 = 2.405  # the section of 1.75 mm filament, the only one that fits these machines
# What changes the printer itself has no place in a print.
_FORBIDDEN = {Command.FACTORY_RESET: "resets the printer", Command.STORE_HOME: "overwrites the printer's home position"}


@dataclass(frozen=True)
class _Motion:
    """What the C commands of a file move.

    Attributes:
        row: (K,) int64, commands that move.
        place: (C, 3) mm after each command.
        way: (C, 3) mm.
        travels: (C,) bool, commands that move the nozzle by more than one step.
        fed: (C, 2) mm of filament of A and B, forward positive.
        strand: (C,) bool, commands that move the nozzle and feed filament.
    """

    row: IntArray
    place: FloatArray
    way: FloatArray
    travels: BoolArray
    fed: FloatArray
    strand: BoolArray


def audit(commands: Commands, printer: PrinterProfile, tower: FloatArray | None = None) -> list[str]:
    """Findings, one sentence each; none means that the file may be printed.

    Nothing extrudes cold, out of bounds, on the wrong axis, too much or while the filament is still pulled back; each
    tool change is followed by a move that does not extrude; heaters stay within their limits and are off at the end;
    the axes are homed first and held, moves say how long they are, and nothing changes the printer itself.

    Args:
        commands: of the file.
        printer: that it is for.
        tower: (2, 2) mm, least and greatest X, Y of the cleaning tower, where each tool must begin after a change;
            None to leave that out.
    """
    motion = _motion(commands, printer)
    findings = _frame(commands, motion)
    findings += _numbers(commands, motion, printer)
    findings += _outside(commands, motion, printer)
    findings += _wrong_axis(commands, motion, printer)
    findings += _temperatures(commands, motion, printer)
    return findings + _tool_changes(commands, motion, printer, tower)


def _motion(commands: Commands, printer: PrinterProfile) -> _Motion:
    """What the commands move, in mm."""
    way = commands.way
    per_mm = np.array(printer.steps_per_mm)
    level = way[:, :3] / per_mm[:3]
    fed = way[:, 3:] / -per_mm[3]
    # One step beside a retraction makes up for moves that were too short for the file.
    travels = (np.abs(way[:, :3]) > 1).any(axis=1)
    strand = travels & (fed.max(axis=1) > 0)
    place = commands.steps[:, :3] / per_mm[:3]
    return _Motion(np.flatnonzero(commands.moves), place, level, travels, fed, strand)


def _finding(fault: BoolArray, motion: _Motion, what: str) -> list[str]:
    """A sentence about all commands at fault, with the place of the first; nothing if there are none."""
    rows = np.flatnonzero(fault)
    if not len(rows):
        return []
    x, y, z = motion.place[rows[0]]
    times = "once" if len(rows) == 1 else f"{len(rows)} times"
    return [f"{what} {times}, first at X {x:.2f}, Y {y:.2f}, Z {z:.2f} (command {rows[0] + 1})"]


def _frame(commands: Commands, motion: _Motion) -> list[str]:
    """The build begins and ends, and no axis moves before it knows its place."""
    findings = []
    starts, ends = (np.flatnonzero(commands.code == code) for code in (Command.BUILD_START, Command.BUILD_END))
    if len(starts) != 1 or len(ends) != 1:
        findings.append(f"the build starts {len(starts)} times and ends {len(ends)} times instead of once")
    elif len(motion.row) and not starts[0] < motion.row[0] <= motion.row[-1] < ends[0]:
        findings.append("there are moves outside the build")
    homed = np.zeros(len(commands.code), dtype=np.int64)
    homing = np.flatnonzero(np.isin(commands.code, (Command.HOME_MINIMUM, Command.HOME_MAXIMUM)))
    homed[homing] = np.bitwise_or.accumulate(commands.argument(homing, 1)) & _HOMED
    at_home = np.maximum.accumulate(homed) == _HOMED
    lost = commands.moves & ~(at_home & commands.known.all(axis=1))
    findings += _finding(lost, motion, "an axis moves while nobody knows where it is")
    findings += _finding(_released(commands), motion, "an axis moves after its motor was let go")
    for command, harm in _FORBIDDEN.items():
        findings += _finding(commands.code == command, motion, f"a command {harm}")
    return findings


def _released(commands: Commands) -> BoolArray:
    """(C,) moves of an axis whose motor has been switched off since the axis was last homed or set to a place."""
    number = np.arange(len(commands.code))
    released = np.zeros(len(number), dtype=bool)
    switches = np.flatnonzero(commands.code == Command.SWITCH_AXES)
    switches = switches[commands.argument(switches, 1) & _ENABLES == 0]
    placed = np.flatnonzero(np.isin(commands.code, (Command.HOME_MINIMUM, Command.HOME_MAXIMUM, Command.SET_POSITION)))
    named = np.where(commands.code[placed] == Command.SET_POSITION, -1, commands.argument(placed, 1))
    for axis in range(commands.steps.shape[1]):
        off, on = np.full(len(number), -1), np.full(len(number), -1)
        let_go = switches[commands.argument(switches, 1) >> axis & 1 == 1]
        off[let_go] = let_go
        found = placed[named >> axis & 1 == 1]
        on[found] = found
        released |= (commands.way[:, axis] != 0) & (np.maximum.accumulate(off) > np.maximum.accumulate(on))
    return released


def _numbers(commands: Commands, motion: _Motion, printer: PrinterProfile) -> list[str]:
    """Moves are as long and as fast as they may be and as they say."""
    planned = commands.code == Command.MOVE
    way = np.sqrt(np.einsum("ij,ij->i", motion.way, motion.way))
    length = np.where(motion.travels, way, np.maximum(way, np.abs(motion.fed).max(axis=1)))
    with np.errstate(invalid="ignore", divide="ignore"):
        unsaid = planned & ~(np.isfinite(commands.distance) & (commands.distance > 0) & (commands.speed > 0))
        wrong = planned & ~unsaid & (np.abs(commands.distance - length) > _LENGTH_TOLERANCE_MM)
        # A retraction that goes on by a step at most is as long as its filament or as that step.
        wrong &= motion.travels | (np.abs(commands.distance - way) > _STEP_MM)
        every = np.concatenate([motion.way, motion.fed], axis=1)
        speed = np.abs(every) * (commands.speed / commands.distance)[:, None]
    most = np.array([*printer.max_speed_mm_s, printer.max_speed_mm_s[3]]) * 1.02
    fast = planned & (length > _LONG_MM) & (speed > most).any(axis=1)
    thick = motion.strand & (length > _LONG_MM)
    thick &= motion.fed.max(axis=1) * _FILAMENT_MM2 > _LARGEST_SECTION_MM2 * length
    return (
        _finding(unsaid, motion, "a move has no length or no speed")
        + _finding(wrong, motion, "a move is not as long as it says")
        + _finding(fast, motion, "an axis moves faster than it can")
        + _finding(thick, motion, "a strand gets more filament than any nozzle can lay")
    )


def _outside(commands: Commands, motion: _Motion, printer: PrinterProfile) -> list[str]:
    """Strands stay where both nozzles reach, moves within the printer."""
    low = np.array([printer.reach_min[0], min(printer.prime_y), 0.0]) - _TOLERANCE_MM
    high = np.array(printer.reach_max) + _TOLERANCE_MM
    # A strand has two ends; the first one is where the command before left the nozzle.
    before = np.concatenate([motion.place[:1], motion.place[:-1]])
    beyond = ((motion.place < low) | (motion.place > high) | (before < low) | (before > high)).any(axis=1)
    rightmost = np.array(printer.reach_x_max)[np.maximum(commands.tool, 0)] + _TOLERANCE_MM
    least, most = np.array(printer.bed_min) - _TOLERANCE_MM, np.array(printer.bed_max) + _TOLERANCE_MM
    off = (
        (motion.place[:, 0] > rightmost) | (motion.place < least).any(axis=1) | (motion.place[:, 1:] > most[1:]).any(1)
    )
    return _finding(motion.strand & beyond, motion, "a strand lies outside the reach of both nozzles") + _finding(
        commands.moves & off, motion, "a move leaves the printer's space"
    )


def _wrong_axis(commands: Commands, motion: _Motion, printer: PrinterProfile) -> list[str]:
    """Only the active tool's filament moves."""
    findings = []
    step = 1.5 / printer.steps_per_mm[3]  # at a tool change the counters may be rounded by one
    for tool, letter in enumerate(printer.tool_axes):
        wrong = (np.abs(motion.fed[:, tool]) > step) & (commands.tool != tool)
        findings += _finding(wrong, motion, f"filament axis {letter} moves while tool {tool} is not the active one")
    return findings


def _temperatures(commands: Commands, motion: _Motion, printer: PrinterProfile) -> list[str]:
    """Heaters stay within their limits, are hot before they are needed, and off at the end."""
    findings: list[str] = []
    heaters = [(f"tool {tool}", Action.NOZZLE_TEMPERATURE, tool, Command.WAIT_FOR_TOOL) for tool in (0, 1)]
    heaters.append(("the bed", Action.BED_TEMPERATURE, 0, Command.WAIT_FOR_BED))
    for heater, (name, action, tool, wait) in enumerate(heaters):
        is_bed = action == Action.BED_TEMPERATURE
        rows, targets = _targets(commands, action, tool)
        limit = printer.max_temperature_c[1 if is_bed else 0]
        if len(targets) and targets.max() > limit:
            findings.append(f"{name} is heated to {targets.max()} °C, more than the {limit:g} °C that it can stand")
        if len(targets) and targets[-1] > 0:
            findings.append(f"{name} is still heated to {targets[-1]} °C at the end of the file")
        used = motion.strand if is_bed else motion.fed[:, heater] != 0
        if is_bed and not targets.any():
            continue  # printed on a cold bed on purpose
        ready = _ready(commands, rows, targets, 1 if is_bed else printer.extrusion_temperature_c, wait, tool)
        what = "a strand is laid before the bed is warm" if is_bed else f"{name} moves its filament while it is cold"
        findings += _finding(used & ~ready, motion, what)
    return findings


def _targets(commands: Commands, action: Action, tool: int) -> tuple[IntArray, IntArray]:
    """The commands that set a heater's target, and the targets in °C."""
    rows = np.flatnonzero(commands.code == Command.TOOL_ACTION)
    rows = rows[(commands.argument(rows, 2) == action) & (commands.argument(rows, 3) == 2)]
    rows = rows[(commands.argument(rows, 1) == tool) | (action == Action.BED_TEMPERATURE)]
    return rows, commands.argument(rows, 4) + 256 * commands.argument(rows, 5)


def _ready(commands: Commands, rows: IntArray, targets: IntArray, least: float, wait: Command, tool: int) -> BoolArray:
    """(C,) whether the heater is known to be hot: waited for at a high enough target, and not turned down since."""
    number = np.arange(len(commands.code))
    target = np.concatenate([[0], targets])[np.searchsorted(rows, number, side="right")]
    waits = np.flatnonzero(commands.code == wait)
    waits = waits[commands.argument(waits, 1) == tool]  # those that wait for too little count as cold themselves
    waited = np.full(len(number), -1)
    waited[waits] = waits
    cold: IntArray = np.maximum.accumulate(np.where(target < least, number, -1))
    return np.asarray((target >= least) & (np.maximum.accumulate(waited) > cold))


def _tool_changes(commands: Commands, motion: _Motion, printer: PrinterProfile, tower: FloatArray | None) -> list[str]:
    """The move after a tool change feeds nothing, no strand begins pulled back, and each tool begins at the tower."""
    changed = np.zeros(len(commands.code), dtype=bool)
    changed[1:] = (commands.tool[1:] != commands.tool[:-1]) & (commands.tool[:-1] >= 0)
    next_move = _following(np.flatnonzero(changed), motion.row)
    at_once = np.zeros(len(changed), dtype=bool)
    at_once[next_move] = (np.abs(motion.fed[next_move]) > _TOLERANCE_MM).any(axis=1) | motion.strand[next_move]
    findings = _finding(at_once, motion, "the move after a tool change, which shifts the nozzles, feeds filament")
    for tool in (0, 1):
        counter = np.cumsum(motion.fed[:, tool])
        before = counter - motion.fed[:, tool]
        pulled_back = np.maximum.accumulate(np.maximum(before, 0)) - before > _TOLERANCE_MM
        starved = motion.strand & (commands.tool == tool) & pulled_back
        findings += _finding(starved, motion, f"a strand of tool {tool} begins while its filament is pulled back")
    if tower is None:
        return findings
    first = _following(np.flatnonzero(changed), np.flatnonzero(motion.strand))
    begin = motion.place[first] - motion.way[first]
    priming_line = begin[:, 1] <= max(printer.prime_y) + _TOLERANCE_MM
    low, high = tower - _TOLERANCE_MM, tower + _TOLERANCE_MM
    elsewhere = np.zeros(len(changed), dtype=bool)
    elsewhere[first] = ((begin[:, :2] < low[0]) | (begin[:, :2] > high[1])).any(axis=1) & ~priming_line
    return findings + _finding(elsewhere, motion, "a tool does not begin at the cleaning tower after a change")


def _following(rows: IntArray, candidates: IntArray) -> IntArray:
    """For each row the first candidate after it; rows after the last candidate have none."""
    index = np.searchsorted(candidates, rows)
    following: IntArray = candidates[index[index < len(candidates)]]
    return following
