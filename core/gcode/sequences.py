"""The fixed parts of the file: start, tool change and end, in the commands that GPX and MakerBot's parser share."""

from __future__ import annotations

from ..records import dataclass
from ..settings import PrintSettings
from ..settings.printer import PrinterProfile
from ..settings.temperatures import bed_temperature
from .fan import fan_off
from .marlin import marlin_end, marlin_start, marlin_tool_change

PRIME_WIDTH_MM = 1.0
PRIME_SIDE = (1.0, -1.0)
PRIME_SPEED_MM_S = 30.0
CLEARANCE_MM = 2.0


@dataclass(frozen=True)
class StartSequence:
    """The text before the first move and the state it leaves.

    Attributes:
        lines: the commands.
        counters: mm, position of each tool's filament axis afterwards; any number if extrusion is relative.
    """

    lines: list[str]
    counters: tuple[float, float]


def tool_change_lines(tool: int, printer: PrinterProfile) -> list[str]:
    """Switch the active nozzle; the firmware shifts the carriage together with the next move."""
    if printer.marlin:
        return marlin_tool_change(printer.marlin, tool)
    return [f"G1 F{printer.travel_mm_min}", f"M135 T{tool}"]


def start_sequence(
    settings: PrintSettings, hot: dict[int, float], retracted: tuple[float, float], front: float
) -> StartSequence:
    """Heat, home and draw one priming line with each tool along the front edge.

    Args:
        settings: of the print.
        hot: °C of the tools that the print uses, in the order of priming; the last one starts the print.
        retracted: mm of filament that each tool is left pulled back.
        front: mm, least Y of the print; the priming lines keep away from it.
    """
    printer = settings.printer_profile
    near, far = printer.prime_y
    priming_y = near if front >= near + CLEARANCE_MM else far
    lines = marlin_start(printer.marlin, settings, hot) if printer.marlin else _heat_and_home(settings, hot)
    counters = [0.0, 0.0]
    for tool in hot:
        fed = _prime_amount(settings, tool)
        lines += tool_change_lines(tool, printer)
        lines += _prime_lines(settings, tool, fed, retracted[tool], priming_y)
        counters[tool] = fed - retracted[tool]
    return StartSequence(lines, (counters[0], counters[1]))


def end_sequence(settings: PrintSettings, tool: int, counter: float) -> list[str]:
    """Pull the filament back, lower the bed all the way, home, switch everything off and end the build.

    Args:
        settings: of the print.
        tool: the active one.
        counter: mm, position of its filament axis.
    """
    printer = settings.printer_profile
    if printer.marlin:
        return marlin_end(printer.marlin, settings, tool)
    axis = printer.tool_axes[tool]
    return [
        f"G1 {axis}{counter - settings.retract_length:.5f} F{settings.retract_speed * 60:.0f}",
        "M18 A B",
        *fan_off(settings),
        f"G1 Z{printer.bed_max[2]:.3f} F{printer.lift_mm_min}",  # clear of the tallest print
        f"G162 X Y F{printer.homing_mm_min[0]:.0f}",
        "M18 X Y Z",
        "M109 S0 T0",
        "M104 S0 T0",
        "M104 S0 T1",
        "M73 P100",
        "M72 P1",
        "M137",
    ]


def _heat_and_home(settings: PrintSettings, hot: dict[int, float]) -> list[str]:
    """A heater that stays off is not waited for: GPX warns of it."""
    bed = bed_temperature(settings, 0)
    printer = settings.printer_profile
    level, down, touch = (f"F{feedrate:.0f}" for feedrate in printer.homing_mm_min)
    warm_up = [f"M104 S{min(printer.warm_up_c, hot[tool]):.0f} T{tool}" for tool in sorted(hot)]
    heat_up = [f"M104 S{hot[tool]:.0f} T{tool}" for tool in sorted(hot)]
    homing = [
        f"G162 X Y {level}",
        f"G161 Z {down}",
        "G92 X0 Y0 Z-5 A0 B0",
        f"G1 Z0 {down}",
        f"G161 Z {touch}",
        "M132 X Y Z A B",
        "G92 X{:g} Y{:g} Z0 A0 B0".format(*printer.home),
    ]
    wait_left_front = [
        f"G1 Z10.000 F{printer.lift_mm_min}",
        f"G1 X{printer.reach_min[0]:.3f} Y{printer.prime_y[0]:.3f} F{printer.travel_mm_min}",
    ]
    return [
        "M136",
        "M73 P0",
        f"M109 S{bed:.0f} T0",
        *warm_up,
        *homing,
        *wait_left_front,
        *(["M134 T0"] if round(bed) else []),
        *heat_up,
        *(f"M133 T{tool}" for tool in sorted(hot) if round(hot[tool])),
    ]


def _prime_amount(settings: PrintSettings, tool: int) -> float:
    """Mm of filament in the priming line, as the file writes it."""
    outer, inner = settings.printer_profile.prime_x
    length = outer - inner
    volume = length * PRIME_WIDTH_MM * settings.first_layer_height
    return round(volume / settings.filament_sections[tool], 5)


def _prime_lines(settings: PrintSettings, tool: int, fed: float, retracted: float, y: float) -> list[str]:
    """One priming line at Y = `y`: `fed` mm of filament, of which `retracted` mm are pulled back at its end."""
    printer = settings.printer_profile
    axis, travel, lift = printer.tool_axes[tool], f"F{printer.travel_mm_min}", f"F{printer.lift_mm_min}"
    (middle_x, middle_y), before = (printer.marlin.origin, 0.0) if printer.marlin else ((0.0, 0.0), fed)
    start_x, end_x = (middle_x + PRIME_SIDE[tool] * x for x in printer.prime_x)
    height = settings.first_layer_height
    pull_back = [f"G1 {axis}{before - retracted:.5f} F{settings.retract_speed * 60:.0f}"] if retracted > 0 else []
    return [
        f"G1 X{start_x:.3f} Y{middle_y + y:.3f} {travel}",
        f"G1 Z{height:.3f} {lift}",
        f"G1 X{end_x:.3f} {axis}{fed:.5f} F{_prime_speed(settings) * 60:.0f}",
        *pull_back,
        f"G1 Z{height + CLEARANCE_MM:.3f} {lift}",
    ]


def _prime_speed(settings: PrintSettings) -> float:
    """Mm/s along the priming line, no faster than its plastic melts."""
    speed = min(settings.first_layer_speed, PRIME_SPEED_MM_S)
    if settings.max_volumetric_speed > 0:
        speed = min(speed, settings.max_volumetric_speed / (PRIME_WIDTH_MM * settings.first_layer_height))
    return speed
