"""Where the time and the plastic of a print go, and what it costs."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np

from ..model import BoolArray, FloatArray
from ..paths import Feature
from ..settings import PrintSettings
from ..settings.temperatures import bed_temperature, starting_temperatures
from ..toolpaths.move_times import move_seconds
from ..toolpaths.moves import Moves

# Rules of thumb for an enclosed printer in a room of this temperature; they only tell how long to wait for the start.
ROOM_C = 22.0
BED_C_PER_S = 0.15
NOZZLE_C_PER_S = 1.5


def time_report(
    moves: Moves, settings: PrintSettings, single_color: float | None = None, seconds: FloatArray | None = None
) -> dict[str, Any]:
    """All times of the report, in s.

    Args:
        moves: the print.
        settings: of the print.
        single_color: s that the same object takes in one color, if known; see `single_color_seconds`.
        seconds: (M,) `move_seconds` of the moves, if they are known.

    Returns:
        `total`; `tool_change`, all that is not extruded between the last strand of one tool and the first of the next;
        `tower`, the strands of the cleaning tower; `features`, which add up to the total: the strands of each feature,
        `tool_change`, and other travels and retractions as `travel` and `retract`; `heating`, which is not part of the
        total; `single_color`, and `ratio`, the total over that.
    """
    seconds = move_seconds(moves, settings.printer_profile) if seconds is None else seconds
    changing = tool_change_rows(moves)
    steady = np.bincount(moves.feature, np.where(changing, 0.0, seconds), minlength=len(Feature))
    features = {feature.name.lower(): float(steady[feature]) for feature in Feature if steady[feature] > 0}
    total, change = float(seconds.sum()), float(seconds[changing].sum())
    report: dict[str, Any] = {
        "total": total,
        "tool_change": change,
        "tower": features.get("tower", 0.0),
        "features": features | {"tool_change": change},
        "heating": heating_seconds(moves, settings),
    }
    if single_color is not None:
        report |= {"single_color": single_color, "ratio": total / single_color if single_color > 0 else 1.0}
    return report


def heating_seconds(moves: Moves, settings: PrintSettings) -> float:
    """About how long the printer heats before it prints: the bed first, then all nozzles that are used at once."""
    hottest = max(starting_temperatures(settings, moves.tool, moves.layer).values(), default=0.0)
    bed = max(bed_temperature(settings, 0) - ROOM_C, 0.0) / BED_C_PER_S
    return bed + max(hottest - (settings.printer_profile.warm_up_c if bed > 0 else ROOM_C), 0.0) / NOZZLE_C_PER_S


def filament_report(moves: Moves, settings: PrintSettings) -> dict[str, Any]:
    """Filament of each tool and what it costs.

    Returns:
        The keys of `filament_use`; `tool0_cost`, `tool1_cost` and `cost` in the currency of `filament_cost`;
        `features_g`, grams by feature, retractions and priming left out; `tower_share` and `support_share` of that.
    """
    report: dict[str, Any] = dict(filament_use(moves, settings))
    for tool in (0, 1):
        report[f"tool{tool}_cost"] = report[f"tool{tool}_g"] / 1000 * settings.filament_cost
    report["cost"] = report["tool0_cost"] + report["tool1_cost"]
    row = moves.feature + len(Feature) * moves.tool
    fed = np.bincount(row, np.where(moves.extrudes, moves.filament, 0.0), minlength=2 * len(Feature))
    by_feature = settings.filament_sections @ fed.reshape(2, -1) * settings.filament_density / 1000
    features = {feature.name.lower(): float(by_feature[feature]) for feature in Feature if by_feature[feature] > 0}
    total = float(by_feature.sum())
    report["features_g"] = features
    for kind in ("tower", "support"):
        weight = sum(grams for name, grams in features.items() if name.startswith(kind))
        report[f"{kind}_share"] = weight / total if total > 0 else 0.0
    return report


def swap_cost(moves: Moves, seconds: FloatArray, alike: Moves, settings: PrintSettings) -> dict[str, Any]:
    """What it costs to leave parts of the outer wall to the other tool within the layer.

    Args:
        moves: the print.
        seconds: (M,) `move_seconds` of the moves.
        alike: the same print with each layer's wall by the layer's own tool.
        settings: of the print.

    Returns:
        `tool_changes`, how many more there are; `tool_changes_in_layers`, how many do not come with a new layer;
        `tool_change_time_s`, how much longer it all takes.
    """
    changes = np.diff(moves.tool) != 0
    return {
        "tool_changes": int(changes.sum() - (np.diff(alike.tool) != 0).sum()),
        "tool_changes_in_layers": int((changes & (np.diff(moves.layer) == 0)).sum()),
        "tool_change_time_s": float(seconds.sum() - move_seconds(alike, settings.printer_profile).sum()),
    }


def stretches(moves: Moves, seconds: FloatArray) -> tuple[Moves, FloatArray]:
    """The print in few rows, for sums: consecutive rows of one tool, layer and feature become one.

    Args:
        moves: the print.
        seconds: (M,) `move_seconds` of the moves.

    Returns:
        S rows with the filament that each stretch takes, all else as in its last row; (S,) s that it takes.
    """
    begins = np.ones(len(moves.tool), dtype=bool)
    extrudes = moves.extrudes
    begins[1:] = extrudes[1:] != extrudes[:-1]
    for column in (moves.tool, moves.layer, moves.feature):
        begins[1:] |= column[1:] != column[:-1]
    first = np.flatnonzero(begins)
    last = np.append(first[1:], len(begins))[: len(first)] - 1
    # Axis by axis, as the table is in memory.
    rows = Moves(*(getattr(moves, column.name).T.take(last, axis=-1).T for column in fields(Moves)))
    return replace(rows, filament=np.add.reduceat(moves.filament, first)), np.add.reduceat(seconds, first)


def filament_use(moves: Moves, settings: PrintSettings) -> dict[str, float]:
    """Filament that each tool feeds in the end, retractions balanced: `tool0_mm`, `tool1_mm`, `tool0_g`, `tool1_g`."""
    fed = np.bincount(moves.tool, moves.filament, minlength=2)
    grams = fed * settings.filament_sections * settings.filament_density / 1000
    return {f"tool{tool}_{unit}": float(of[tool]) for unit, of in (("mm", fed), ("g", grams)) for tool in (0, 1)}


def tool_change_rows(moves: Moves) -> BoolArray:
    """(M,) rows without a strand between the last strand of one tool and the first of the other."""
    inside = np.zeros(len(moves.tool), dtype=bool)
    idle = np.flatnonzero(~moves.extrudes)
    switched = np.flatnonzero(moves.tool[1:] != moves.tool[:-1]) + 1
    if len(switched) and len(idle):
        inside[switched] = inside[switched - 1] = True
        run = np.cumsum(np.diff(idle, prepend=idle[0]) > 1)
        changes = np.zeros(run[-1] + 1, dtype=bool)
        changes[run[inside[idle]]] = True
        inside[:] = False
        inside[idle] = changes[run]
    return inside
