"""An X3G file back into moves, within the resolution of whole motor steps."""

from __future__ import annotations

import numpy as np

from ..errors import PrintError
from ..model import BoolArray, FloatArray
from ..settings import PrintSettings
from ..settings.printer import PrinterProfile, printer_names, printer_profile
from ..toolpaths.recovered import UNKNOWN, ReadPrint, recovered_moves
from .reader import Commands, read_x3g

_LONGEST_GAP = 0.6  # mm; a step of filament makes a quarter of a millimeter of a usual line
_STEP_MM = 0.02  # places that whole steps make are this near
_TRAVELS = 2.0  # times as fast as the lines before and after: a move that goes between them


def moves_of_x3g(data: bytes, name: str, settings: PrintSettings | None = None) -> ReadPrint:
    """Read a file. It does not say what its lines are for, so all are taken as outer walls.

    The lines along the front edge that prime the nozzles are left out, as they are from G-code of this program.

    Args:
        data: the file.
        name: of the print.
        settings: of the print; if they are not known, the defaults for the printer whose motors make its moves as long
            as the file says they are.

    Raises:
        PrintError: it is damaged, or lays down no plastic.
    """
    found = read_x3g(data)
    settings = settings or PrintSettings(printer=_printer_of(found))
    rows = np.flatnonzero(found.moves & found.known[:, :3].all(axis=1))
    per_mm = np.array(settings.printer_profile.steps_per_mm)
    position = found.steps[rows, :3] / per_mm[:3]
    fed = -found.way[rows, 3:].sum(axis=1) / per_mm[3]
    speed = np.nan_to_num(found.speed[rows], nan=60.0)
    printed = slice(_priming_end(position, fed, settings.printer_profile), None)
    rows, position, fed, speed = rows[printed], position[printed], fed[printed], speed[printed]
    if not len(rows):
        raise PrintError("the file lays down no plastic", "choose the X3G file of a print")
    step = np.diff(position, axis=0, prepend=position[:1])
    way = np.sqrt(np.einsum("ij,ij->i", step, step))
    fed = _spread(fed, way, step[:, 2] == 0, speed)
    feature = np.full(len(rows), UNKNOWN)
    steps = (float(1 / per_mm[0]), float(1 / per_mm[3]))
    tool = np.maximum(found.tool[rows], 0)
    return ReadPrint(name, settings, recovered_moves(position, tool, fed, speed, feature, settings, steps))


def _printer_of(found: Commands) -> str:
    """The printer whose steps fit the lengths that moves are said to have; a file does not name it."""
    way = found.way[:, :3] * ~(found.way[:, 3:] != 0).any(axis=1, keepdims=True)
    told = np.isfinite(found.distance) & way.any(axis=1)
    usual = PrintSettings().printer
    names = sorted(
        (name for name in printer_names() if printer_profile(name).marlin is None), key=lambda name: name != usual
    )
    off = []
    for name in names if told.any() else ():
        step = way[told] / np.array(printer_profile(name).steps_per_mm[:3])
        length = np.sqrt(np.einsum("ij,ij->i", step, step))
        off.append(float(np.median(np.abs(found.distance[told] / length - 1.0))))
    return names[int(np.argmin(off))] if off else usual


def _priming_end(position: FloatArray, fed: FloatArray, printer: PrinterProfile) -> int:
    """The row after the last line that primes a nozzle, 0 where there is none."""
    ends = np.array(printer.prime_x)
    x = np.abs(position[:, 0])
    near = np.abs(position[:, 1, None] - printer.prime_y).min(axis=1) < _STEP_MM
    primes = near[1:] & (fed[1:] > 0) & (np.abs(x[:-1] - ends[0]) < _STEP_MM) & (np.abs(x[1:] - ends[1]) < _STEP_MM)
    found = np.flatnonzero(primes)
    return int(found[-1]) + 2 if len(found) else 0


def _spread(fed: FloatArray, way: FloatArray, level: BoolArray, speed: FloatArray) -> FloatArray:
    """(M,) filament of each move, where short moves between those that feed get their share of whole steps."""
    idle = (fed == 0) & (way > 0) & level
    arc, total = np.cumsum(way), np.cumsum(fed)
    place = np.arange(len(fed))
    before = np.maximum.accumulate(np.where(idle, 0, place))
    after = np.minimum.accumulate(np.where(idle, len(fed) - 1, place)[::-1])[::-1]
    gap = idle & (fed[before] > 0) & (fed[after] > 0) & (way[after] > 0) & level[after]
    gap &= arc[after] - arc[before] - way[after] <= _LONGEST_GAP
    gap &= speed < _TRAVELS * np.maximum(speed[before], speed[after])
    even = np.interp(arc, arc[~gap], total[~gap])
    spread: FloatArray = np.diff(np.where(gap, even, total), prepend=0.0)
    return spread
