"""What the program knows about a printer: reach, limits of its motion, axes of its nozzles, start and end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from functools import cache
from pathlib import Path
from typing import Any, get_args, get_type_hints

from ..errors import SettingsError
from ..files import read_json
from ..records import dataclass

Pair = tuple[float, float]
Triple = tuple[float, float, float]
Four = tuple[float, float, float, float]
# Facts are data: another machine with this firmware is one more file here.
_HINT = "copy another file of that folder and change its numbers"
_MOST = 1e9  # no fact is larger; NaN fails the comparison too
PRINTERS = Path(__file__).resolve().parent.parent.parent / "presets" / "printer"


@dataclass(frozen=True)
class MarlinCommands:
    """The commands of a printer with Marlin or Klipper firmware; others get MakerBot's dialect.

    In the lines {bed}, {nozzle_0} and {nozzle_1} stand for temperatures, at the start those of the first layer, 0 for a
    nozzle that the print does not use; {tool} stands for the number of a tool. At the start {warm_up_0} and {warm_up_1}
    are `warm_up_c`, or what a nozzle needs if that is less, and {acceleration} is that of X and Y.

    Attributes:
        origin: mm, X and Y of the bed's center in the printer's own coordinates.
        start: lines before the nozzles are primed; extrusion has to be relative after them (M83).
        tool_change: lines that switch to a tool.
        end: lines after the print.
    """

    origin: Pair
    start: tuple[str, ...]
    tool_change: tuple[str, ...]
    end: tuple[str, ...]


@dataclass(frozen=True)
class PrinterProfile:
    """A printer with two nozzles. Coordinates are those of the active nozzle, origin at the bed's center.

    Attributes:
        name: as the user knows it.
        gpx_machine: what GPX and the header of a G-code file call it.
        reach_min: mm, least X, Y, Z that both nozzles reach safely.
        reach_max: mm, greatest X, Y, Z that both nozzles reach safely.
        home: mm, X and Y where the end stops leave the carriage.
        max_speed_mm_s: of X, Y, Z and of the filament.
        acceleration_mm_s2: of X, Y, Z and of the filament.
        max_speed_change_mm_s: instant change of speed allowed in a corner, of X, Y, Z and the filament.
        queue_moves: moves that the firmware sees ahead; it is always able to stop at the last of them.
        tool_axes: letter of each tool's filament axis.
        nozzle_distance_mm: by which the firmware shifts the carriage at a tool change.
        steps_per_mm: of X, Y, Z and of the filament, as GPX converts them.
        home_feedrate_mm_min: greatest of X, Y, Z towards their end stops.
        bed_min: mm, least X, Y, Z that a nozzle may go to.
        bed_max: mm, greatest X, Y, Z that a nozzle may go to.
        reach_x_max: mm, greatest X that the carriage reaches with each tool.
        max_temperature_c: of a nozzle and of the bed.
        extrusion_temperature_c: below this no filament can be pushed through a nozzle.
        homing_mm_min: feedrates of the start sequence: X and Y, Z fast, Z slowly.
        travel_mm_min: feedrate of the start sequence and of the nozzle shift at a tool change.
        lift_mm_min: feedrate of Z in the start and the end sequence.
        warm_up_c: of the nozzles while the bed heats: warm, but nothing drips yet.
        prime_x: mm, |X| where a priming line starts and ends; tool 0 on the right half, tool 1 on the left.
        prime_y: mm, Y of the priming lines, and another one farther in front for prints that reach the first.
        marlin: its own lines if the firmware is Marlin or Klipper; None for MakerBot's dialect and X3G.
    """

    name: str
    gpx_machine: str
    reach_min: Triple
    reach_max: Triple
    home: Pair
    max_speed_mm_s: Four
    acceleration_mm_s2: Four
    max_speed_change_mm_s: Four
    queue_moves: int
    tool_axes: tuple[str, str]
    nozzle_distance_mm: float
    steps_per_mm: Four
    home_feedrate_mm_min: Triple
    bed_min: Triple
    bed_max: Triple
    reach_x_max: Pair
    max_temperature_c: Pair
    extrusion_temperature_c: float
    homing_mm_min: Triple
    travel_mm_min: int
    lift_mm_min: int
    warm_up_c: float
    prime_x: Pair
    prime_y: Pair
    marlin: MarlinCommands | None = None


def printer_names() -> tuple[str, ...]:
    """Names of the printers that have a file, in alphabetical order."""
    return tuple(sorted(path.stem for path in PRINTERS.glob("*.json")))


@cache
def printer_profile(name: str) -> PrinterProfile:
    """The printer of that name in `presets/printer`, read once.

    Raises:
        SettingsError: see `read_profile`.
    """
    return read_profile(PRINTERS / f"{name}.json")


def read_profile(path: Path) -> PrinterProfile:
    """The printer in a file.

    Raises:
        SettingsError: the file cannot be read, lacks a fact, or holds one that is unknown or not of the right kind.
    """
    try:
        facts = dict(read_json(path)["printer"])
    except OSError as problem:
        raise SettingsError(f"the printer {path.stem} cannot be read", problem.strerror or "") from None
    except (KeyError, TypeError, ValueError):
        raise SettingsError(f"the printer {path.stem} is not a printer file", _HINT) from None
    marlin = facts.pop("marlin", None)
    values = _values(PrinterProfile, facts, path, optional="marlin")
    if marlin is not None:
        values["marlin"] = MarlinCommands(**_values(MarlinCommands, marlin, path))
    return PrinterProfile(**values)


def _values(kind: type, facts: dict[str, Any], path: Path, optional: str = "") -> dict[str, Any]:
    """The facts as the dataclass takes them."""
    declared = {fact.name for fact in fields(kind)} - {optional}
    if not isinstance(facts, dict):
        raise SettingsError(f"the printer {path.stem} is not a printer file", _HINT)
    if odd := sorted(set(facts) ^ declared):
        named = ", ".join(name[:40] for name in odd[:5])
        raise SettingsError(f"the printer {path.stem} lacks a fact or has one too many: {named}", _HINT)
    kinds = get_type_hints(kind)
    for name, fact in facts.items():
        if not _fits(fact, kinds[name]):
            raise SettingsError(f"{name} of the printer {path.stem} is not of the right kind", f"it is {fact!r:.60}")
    return {name: tuple(fact) if isinstance(fact, list) else fact for name, fact in facts.items()}


def _fits(fact: Any, kind: Any) -> bool:
    """Whether a value from a file has the declared type: a text, a number, or a list of the right length of them."""
    parts: Sequence[Any] = get_args(kind)
    if parts and parts[-1] is Ellipsis:
        return isinstance(fact, list) and all(_fits(part, parts[0]) for part in fact)
    if parts:
        return (
            isinstance(fact, list)
            and len(fact) == len(parts)
            and all(_fits(part, of) for part, of in zip(fact, parts, strict=True))
        )
    if kind is float:
        return isinstance(fact, (int, float)) and not isinstance(fact, bool) and abs(fact) < _MOST
    return type(fact) is kind
