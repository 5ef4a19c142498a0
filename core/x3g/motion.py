"""The rows of a track in the printer's own numbers: steps, step rates, distances and speeds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..model import BoolArray, FloatArray, IntArray
from ..records import dataclass
from ..settings.printer import PrinterProfile
from . import commands
from .commands import AXES, FILAMENT_AXES, MOVE, Command
from .track import Kind, Track

_US_PER_MINUTE = 60_000_000


@dataclass(frozen=True)
class _Deltas:
    """What each of R rows changes.

    Attributes:
        mm: (5, R) distance along each axis, not negative.
        steps: (5, R) each distance rounded by itself.
        signed_filament: (2, R) mm.
        moves: (R,) bool, rows that move an axis by a step at least.
    """

    mm: FloatArray
    steps: FloatArray
    signed_filament: FloatArray
    moves: BoolArray


def planned_moves(track: Track, printer: PrinterProfile) -> tuple[NDArray[np.void], BoolArray, dict[int, bytes]]:
    """The rows as commands.

    A row whose every axis stays within half a step has no command; the next one makes up for its way. What filament
    loses by rounding is carried to the next move and taken stock of at each tool change.

    Args:
        track: R rows.
        printer: that they are for.

    Returns:
        (R,) records `MOVE`; (R,) bool, which of them are commands of the file; the commands of the other kinds by row.
    """
    deltas = _deltas(track, printer)
    x, y, z, a, b = deltas.mm
    distance = np.sqrt(x * x + y * y + z * z)
    speed = _safe_feedrate(track.feedrate.astype(np.float64), deltas.mm, distance, printer)
    distance = np.where(distance > 0, distance, np.maximum(a, b))
    filament, special = _filament(track, deltas, printer)
    records = np.zeros(len(track.kind), dtype=MOVE)
    records["command"] = Command.MOVE
    records["relative"] = FILAMENT_AXES
    records["distance"] = distance
    records["speed"] = speed / 60 * 64
    for axis in range(3):
        records["steps"][:, axis] = np.rint(track.position[:, axis] / 1000 * printer.steps_per_mm[axis])
    records["steps"][:, 3:] = filament.T
    with np.errstate(divide="ignore", invalid="ignore"):
        interval = _US_PER_MINUTE * (distance / speed) / deltas.steps.max(axis=0)
        records["rate"] = np.where(deltas.moves, 1e6 / interval, 0)
    return records, deltas.moves, special


def _deltas(track: Track, printer: PrinterProfile) -> _Deltas:
    """What each row of the track changes."""
    rows = len(track.kind)
    moving = track.kind == Kind.MOVE
    mm, steps = np.zeros((AXES, rows)), np.zeros((AXES, rows))
    filament = np.zeros((2, rows))
    for axis in range(AXES):
        place = track.position[:, axis] / 1000 if axis < 3 else track.counter[:, axis - 3] / 100_000
        way = np.diff(place, prepend=0.0) * moving
        mm[axis] = np.abs(way)
        steps[axis] = np.rint(mm[axis] * printer.steps_per_mm[min(axis, 3)])
        if axis >= 3:
            filament[axis - 3] = way
    return _Deltas(mm, steps, filament, steps.max(axis=0) > 0)


def _safe_feedrate(feedrate: FloatArray, mm: FloatArray, distance: FloatArray, printer: PrinterProfile) -> FloatArray:
    """(R,) mm/min, slowed down so that no axis exceeds its own limit; that of filament where nothing else moves."""
    way = np.where(distance > 0, distance, np.maximum(mm[3], mm[4]))
    for axis in range(AXES):
        most = printer.max_speed_mm_s[min(axis, 3)] * 60
        with np.errstate(divide="ignore", invalid="ignore"):
            feedrate = np.where(feedrate * mm[axis] / way > most, most * way / mm[axis], feedrate)
    return feedrate


def _filament(track: Track, deltas: _Deltas, printer: PrinterProfile) -> tuple[IntArray, dict[int, bytes]]:
    """(2, R) signed steps of A and B, and the commands of the rows that are no planned moves.

    Between two tool changes the steps up to a row are the rounded sum of the ways up to it, less what was left over
    at the tool change. There the counter itself is rounded.
    """
    per_mm = printer.steps_per_mm[3]
    # Forward is negative on these axes.
    reached = -np.cumsum(np.where(deltas.moves, deltas.signed_filament, 0.0), axis=1) * per_mm
    stands = np.flatnonzero(track.kind == Kind.STAND)
    counter_steps = track.counter[stands] / 100_000 * per_mm
    special = {
        int(row): commands.set_position(_steps(track, int(row), printer))
        for row in np.flatnonzero(track.kind == Kind.SET_POSITION)
    }
    begin = np.zeros(2)  # what the sum of the section must be reduced by
    carried = np.zeros((2, len(stands) + 1))
    for number, row in enumerate(stands.tolist()):
        left_over = reached[:, row] - begin
        value = counter_steps[number] + left_over - np.rint(left_over)
        stood = np.rint(value)
        place = [*_steps(track, row, printer)[:3], *(-stood).astype(np.int64).tolist()]
        special[row] = commands.move_unplanned(place, step_interval(place, int(track.feedrate[row]), printer))
        begin = reached[:, row] - (value - stood)
        carried[:, number + 1] = begin
    section = np.cumsum(track.kind == Kind.STAND)
    sums = np.rint(reached - carried[:, section])
    sums[:, stands] = 0
    steps = np.diff(sums, axis=1, prepend=0).astype(np.int64)
    return steps, special


def _steps(track: Track, row: int, printer: PrinterProfile) -> list[int]:
    """X, Y, Z, A, B after a row in steps, each rounded by itself."""
    place = [*(track.position[row] / 1000).tolist(), *(-track.counter[row] / 100_000).tolist()]
    return [round(value * printer.steps_per_mm[min(axis, 3)]) for axis, value in enumerate(place)]


def step_interval(steps: list[int], feedrate: int, printer: PrinterProfile) -> int:
    """Microseconds between steps at which no axis that is away from its zero exceeds the feedrate."""
    away = [printer.steps_per_mm[min(axis, 3)] for axis in range(AXES) if steps[axis]]
    fastest = int(1e6 / (printer.steps_per_mm[0] * printer.max_speed_mm_s[0]))
    return max([fastest, *(int(_US_PER_MINUTE / (per_mm * feedrate)) for per_mm in away)])
