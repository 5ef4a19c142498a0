"""What the program knows about the printer itself: reach, limits of its motion, axes of its nozzles."""

from __future__ import annotations

import json
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

Triple = tuple[float, float, float]
# Facts are data: another machine with this firmware is one more file here.
PRINTERS = Path(__file__).resolve().parent.parent / "presets" / "printer"


@dataclass(frozen=True)
class PrinterProfile:
    """A printer with two nozzles. Coordinates are those of the active nozzle, origin at the bed's centre.

    Attributes:
        name: as the user knows it.
        reach_min: mm, least X, Y, Z that both nozzles reach safely.
        reach_max: mm, greatest X, Y, Z that both nozzles reach safely.
        home: mm, X and Y where the end stops leave the carriage.
        max_speed_mm_s: of X, Y, Z and of the filament.
        acceleration_mm_s2: of X, Y, Z and of the filament.
        max_speed_change_mm_s: speed that X, Y, Z and the filament may change by at once in a corner.
        queue_moves: moves that the firmware sees ahead; it is always able to stop at the last of them.
        tool_axes: letter of each tool's filament axis.
        nozzle_distance_mm: that the carriage shifts by at a tool change.
        steps_per_mm: of X, Y, Z and of the filament, as GPX converts them.
        home_feedrate_mm_min: greatest of X, Y, Z towards their end stops.
        bed_min: mm, least X, Y, Z of the bed.
        bed_max: mm, greatest X, Y, Z of the bed.
        reach_x_max: mm, greatest X that the carriage reaches with each tool.
        max_temperature_c: of a nozzle and of the bed.
    """

    name: str
    reach_min: Triple
    reach_max: Triple
    home: tuple[float, float]
    max_speed_mm_s: tuple[float, float, float, float]
    acceleration_mm_s2: tuple[float, float, float, float]
    max_speed_change_mm_s: tuple[float, float, float, float]
    queue_moves: int
    tool_axes: tuple[str, str]
    nozzle_distance_mm: float
    steps_per_mm: tuple[float, float, float, float]
    home_feedrate_mm_min: Triple
    bed_min: Triple
    bed_max: Triple
    reach_x_max: tuple[float, float]
    max_temperature_c: tuple[float, float]


def read_profile(name: str) -> PrinterProfile:
    """The printer of that name in `presets/printer`.

    Raises:
        ValueError: the file lacks a fact, or holds one that is unknown or not of the right kind.
    """
    facts = json.loads((PRINTERS / f"{name}.json").read_text(encoding="utf-8"))["printer"]
    if set(facts) != {declared.name for declared in fields(PrinterProfile)}:
        raise ValueError(f"the printer {name} does not have exactly the facts of a PrinterProfile")
    values: dict[str, Any] = {key: tuple(fact) if isinstance(fact, list) else fact for key, fact in facts.items()}
    for key, value in values.items():
        kind = str if key in ("name", "tool_axes") else (int, float)
        if not all(isinstance(part, kind) for part in (value if isinstance(value, tuple) else (value,))):
            raise ValueError(f"{key} of the printer {name} is not of the right kind")
    return PrinterProfile(**values)


REPLICATOR_2X = read_profile("replicator_2x")
