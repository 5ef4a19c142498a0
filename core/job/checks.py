"""Checks that a print has to pass before it may become a file: reach, temperatures, numbers."""

from __future__ import annotations

import math

import numpy as np

from ..errors import MeshError, PrintError, SettingsError
from ..model import BoolArray, FloatArray, bounds
from ..paths import Feature
from ..settings import PrintSettings
from ..settings.printer import PrinterProfile
from ..toolpaths.moves import Moves

_ROUNDING_MM = 1e-6
_HINTS = {
    Feature.TOWER: "set tower_type to none or make the tower smaller",
    Feature.OOZE_SHIELD: "lower the distance of the ooze shield",
    Feature.BRIM: "make the brim narrower",
    Feature.RAFT: "make the raft smaller",
    Feature.SKIRT: "lower skirt_distance or set skirts to 0",
    Feature.SUPPORT: "turn the object, move it to the middle or switch support_enable off",
    Feature.SUPPORT_INTERFACE: "turn the object, move it to the middle or switch support_enable off",
}


def check(moves: Moves, settings: PrintSettings) -> None:
    """Raise the first error that forbids printing these moves, if there is any.

    Args:
        moves: the print.
        settings: of the print.

    Raises:
        PrintError: a number is not finite.
        MeshError: the print leaves the reach of the nozzles.
        SettingsError: a nozzle is too cold to print, or something is hotter or faster than the printer allows.
    """
    check_numbers(moves)
    check_reach(moves, settings.printer_profile)
    check_temperatures(moves, settings)
    check_filament_drive(settings)


def check_numbers(moves: Moves) -> None:
    """Every number of every move is finite, every speed above 0."""
    for column, what in (
        (moves.position, "a place"),
        (moves.filament, "an amount of filament"),
        (moves.speed, "a speed"),
    ):
        # What is not a number is neither the least nor the greatest, but in place of both.
        if column.size and not np.isfinite([column.min(), column.max()]).all():
            raise PrintError(
                f"a move has {what} that is not a number", "check the mesh and the settings for extreme values"
            )
    if len(moves.speed) and moves.speed.min() <= 0:
        raise PrintError("a move has no speed", "check the settings for extreme values")


def check_reach(moves: Moves, printer: PrinterProfile) -> None:
    """All strands inside the reach of both nozzles, all travels above the bed."""
    strand = moves.extrudes
    if not strand.any():
        return
    run = np.flatnonzero(np.append(True, moves.tool[1:] != moves.tool[:-1]))
    lows, highs = (
        np.stack([extreme.reduceat(column, run) for column in moves.position.T], axis=1)
        for extreme in (np.minimum, np.maximum)
    )
    least, most = (np.array(corner) for corner in (printer.reach_min, printer.reach_max))
    # Most prints travel no farther than they reach.
    if (lows < least - _ROUNDING_MM).any() or (highs > most + _ROUNDING_MM).any():
        low, high = bounds(moves.position, strand)
        if (low < least - _ROUNDING_MM).any() or (high > most + _ROUNDING_MM).any():
            raise _out_of_reach(moves, low, high, least, most)
    by_tool = moves.tool[run]
    for tool in np.unique(by_tool).tolist():
        low, high = lows[by_tool == tool].min(axis=0), highs[by_tool == tool].max(axis=0)
        bed_high = np.array(printer.bed_max)
        bed_high[0] = min(bed_high[0], printer.reach_x_max[tool])
        if low[2] < printer.bed_min[2]:
            raise MeshError(f"tool {tool} would run into the bed", "set center_on_bed")
        if high[2] > bed_high[2]:
            raise MeshError("the nozzle would be lifted too high", "lower z_hop or the height of the object")
        if (low < np.array(printer.bed_min)).any() or (high > bed_high).any():
            raise MeshError(f"tool {tool} would travel farther than it reaches", "move the object to the middle")


def _out_of_reach(moves: Moves, low: FloatArray, high: FloatArray, least: FloatArray, most: FloatArray) -> MeshError:
    """The error that says what leaves the reach: all, or something around the object; `low`, `high` bound strands."""
    outside: BoolArray = ((moves.position < least) | (moves.position > most)).any(axis=1) & moves.extrudes
    features = {Feature(feature) for feature in np.unique(moves.feature[outside])}
    surplus = [feature for feature in _HINTS if feature in features]
    allowed = " × ".join(f"{extent:.0f}" for extent in most - least)
    if surplus and features <= set(_HINTS):
        what = surplus[0].name.lower().replace("_", " ")
        return MeshError(f"the {what} leaves what both nozzles reach ({allowed} mm)", _HINTS[surplus[0]])
    size = " × ".join(f"{extent:.0f}" for extent in high - np.append(low[:2], 0.0))
    if (high - low <= most - least).all() and high[2] <= most[2]:
        return MeshError(
            f"the print of {size} mm lies beside what both nozzles reach ({allowed} mm)",
            "move it to the middle or set center_on_bed",
        )
    return MeshError(
        f"the print with its tower takes {size} mm, more than both nozzles reach ({allowed} mm)",
        "scale the object down or turn it",
    )


def check_temperatures(moves: Moves, settings: PrintSettings) -> None:
    """Nozzles that print are hot, and nothing gets hotter than the printer allows."""
    coldest_nozzle = settings.printer_profile.extrusion_temperature_c
    hottest_nozzle, hottest_bed = settings.printer_profile.max_temperature_c
    is_first, strands = moves.tool == 0, moves.extrudes
    for tool in [tool for tool, own in enumerate((is_first, ~is_first)) if (own & strands).any()]:
        usual, first = f"nozzle_temperature_{tool}", f"first_layer_temperature_{tool}"
        for name in (usual, first if getattr(settings, first) else usual):
            degrees = getattr(settings, name)
            if not coldest_nozzle <= degrees <= hottest_nozzle:
                hint = f"set it between {coldest_nozzle:g} and {hottest_nozzle:g} °C"
                raise SettingsError(f"{name} = {degrees:g} °C cannot print", hint)
    for name in ("bed_temperature", "first_layer_bed_temperature"):
        if getattr(settings, name) > hottest_bed:
            hint = f"set it to {hottest_bed:g} °C at most"
            raise SettingsError(f"{name} = {getattr(settings, name):g} °C is too hot", hint)


def check_filament_drive(settings: PrintSettings) -> None:
    """Filament is pulled back and fed again no faster than the printer can."""
    most = settings.printer_profile.max_speed_mm_s[3]
    for name in ("retract_speed", "deretract_speed"):
        if getattr(settings, name) > most:
            hint = f"set it to {math.floor(most)} mm/s at most"
            raise SettingsError(f"{name} = {getattr(settings, name):g} mm/s is more than the printer does", hint)
