"""Small prints for the tests of what is made from moves."""

from __future__ import annotations

import numpy as np
from dualcolor.core.gcode.writer import counted_text
from dualcolor.core.model import FloatArray
from dualcolor.core.paths import Feature
from dualcolor.core.settings import PrintSettings
from dualcolor.core.statistics.breakdown import tool_change_rows
from dualcolor.core.toolpaths.move_times import move_seconds
from dualcolor.core.toolpaths.moves import Moves

TRAVEL, RETRACT, OUTER_WALL, TOWER = Feature.TRAVEL, Feature.RETRACT, Feature.OUTER_WALL, Feature.TOWER


def table(*rows: tuple) -> Moves:
    """Moves from rows (x, y, z, tool, feature, layer, speed, filament)."""
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    x, y, z, tool, feature, layer, speed, filament = columns
    strand = (filament > 0) & (feature != RETRACT)
    return Moves(
        position=np.column_stack([x, y, z]).astype(float),
        tool=tool.astype(np.int64),
        feature=feature.astype(np.int64),
        layer=layer.astype(np.int64),
        width=np.where(strand, 0.4, 0.0),
        height=np.where(strand, 0.25, 0.0),
        speed=speed.astype(float),
        filament=filament.astype(float),
    )


def rosette(layers: int, points: int) -> Moves:
    """Waved circles with a small tower, one tool a layer, retracted and lifted at each tool change."""
    rows: list[tuple] = []
    angle = np.linspace(0, 2 * np.pi, points)
    radius = 20 + 0.375 * np.cos(angle * 40)
    circle = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    for layer in range(layers):
        tool, z = layer % 2, 0.25 * (layer + 1)
        rows.append((30, 0, z + 0.4, tool, TRAVEL, layer, 150, 0))
        rows.append((30, 0, z, tool, TRAVEL, layer, 19.5, 0))
        if layer:
            rows.append((30, 0, z, tool, RETRACT, layer, 25, 4.0))
        rows.append((30, 8, z, tool, TOWER, layer, 60, 0.33))
        rows.append((30, 0, z, tool, TOWER, layer, 60, 0.33))
        rows.append((*circle[0], z, tool, TRAVEL, layer, 150, 0))
        rows += [(x, y, z, tool, OUTER_WALL, layer, 30, 0.0041) for x, y in circle[1:]]
        rows.append((*circle[-1], z, tool, RETRACT, layer, 25, -4.0))
        rows.append((*circle[-1], z + 0.4, tool, TRAVEL, layer, 19.5, 0))
    return table(*rows)


def gcode_text(moves: Moves, settings: PrintSettings, header: list[str], begins: FloatArray | None = None) -> bytes:
    """The whole G-code file of some moves, without the count of its lines."""
    return counted_text(moves, settings, header, begins)[0]


def lengths(moves: Moves) -> np.ndarray:
    """(M,) mm that each row goes."""
    return np.linalg.norm(np.diff(moves.position, axis=0, prepend=moves.position[:1]), axis=1)


def print_time(moves: Moves, settings: PrintSettings) -> dict[str, float]:
    """Seconds that the print moves, see `move_seconds`; heating and priming left out.

    Args:
        moves: the print.
        settings: of the print; its printer sets the limits.

    Returns:
        `total`; `tool_change`, all that is not extruded between the last strand of one tool and the first of the
        next; `tower`, the strands of the cleaning tower. All in s.
    """
    seconds = move_seconds(moves, settings.printer_profile)
    return {
        "total": float(seconds.sum()),
        "tool_change": float(seconds[tool_change_rows(moves)].sum()),
        "tower": float(seconds[moves.feature == Feature.TOWER].sum()),
    }
