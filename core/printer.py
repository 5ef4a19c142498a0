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


REPLICATOR_2X = PrinterProfile(
    name="MakerBot Replicator 2X",
    reach_min=(-105.0, -73.0, 0.0),
    reach_max=(105.0, 73.0, 150.0),
    home=(152.0, 72.0),
    max_speed_mm_s=(300.0, 300.0, 19.5, 1600.0 / 60.0),
    acceleration_mm_s2=(1000.0, 1000.0, 150.0, 2000.0),
    max_speed_change_mm_s=(15.0, 15.0, 10.0, 20.0),
    queue_moves=16,
    tool_axes=("A", "B"),
    nozzle_distance_mm=35.0,
    steps_per_mm=(88.888889, 88.888889, 400.0, 96.27520187033367),
    home_feedrate_mm_min=(2500.0, 2500.0, 1100.0),
    bed_min=(-123.0, -76.0, 0.0),
    bed_max=(123.0, 76.0, 155.0),
    reach_x_max=(152.0, 117.0),
    max_temperature_c=(280.0, 130.0),
)
