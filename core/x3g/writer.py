"""A print into the bytes of an X3G file, from the same numbers that the G-code has."""

from __future__ import annotations

from ..gcode.program import program
from ..model import FloatArray
from ..settings import PrintSettings
from ..toolpaths.moves import Moves
from .motion import planned_moves
from .track import follow


def x3g_bytes(moves: Moves, settings: PrintSettings, name: str = "", begins: FloatArray | None = None) -> bytes:
    """The whole file, equal to what GPX makes of the G-code: the same commands in the same order.

    Args:
        moves: the print, at least one row.
        settings: of the print.
        name: that the printer shows for the build; GPX takes the file's.
        begins: `move_times.layer_begins` of the moves, if they are known.

    Raises:
        ValueError: no moves, or numbers that are not finite or too large for the file.
    """
    told = program(moves, settings, begins)
    shown = "".join(sign if sign.isprintable() else "?" for sign in name)
    track = follow(told, shown, settings.printer_profile)
    records, kept, special = planned_moves(track, settings.printer_profile)
    # A row's own command stands after those inserted before it; sorting keeps the order of equals.
    others = sorted([*track.inserted, *special.items()], key=lambda place: place[0])
    pieces: list[bytes] = []
    done = 0
    for row, command in others:
        pieces += [records[done:row][kept[done:row]].tobytes(), command]
        done = row
    pieces.append(records[done:][kept[done:]].tobytes())
    return b"".join(pieces)
