"""What the program knows about the printer itself: reach, limits of its motion, axes of its nozzles."""

from __future__ import annotations

from dataclasses import dataclass

Triple = tuple[float, float, float]


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
        max_speed_change_mm_s: speed that X, Y, Z may change by at once in a corner.
        queue_moves: moves that the firmware sees ahead; it is always able to stop at the last of them.
        tool_axes: letter of each tool's filament axis.
    """

    name: str
    reach_min: Triple
    reach_max: Triple
    home: tuple[float, float]
    max_speed_mm_s: tuple[float, float, float, float]
    acceleration_mm_s2: tuple[float, float, float, float]
    max_speed_change_mm_s: Triple
    queue_moves: int
    tool_axes: tuple[str, str]


REPLICATOR_2X = PrinterProfile(
    name="MakerBot Replicator 2X",
    reach_min=(-105.0, -73.0, 0.0),
    reach_max=(105.0, 73.0, 150.0),
    home=(152.0, 72.0),
    max_speed_mm_s=(300.0, 300.0, 19.5, 1600.0 / 60.0),
    acceleration_mm_s2=(1000.0, 1000.0, 150.0, 2000.0),
    max_speed_change_mm_s=(15.0, 15.0, 10.0),
    queue_moves=16,
    tool_axes=("A", "B"),
)
