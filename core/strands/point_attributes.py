"""What is known of every point of the strands: for their colors, and for showing a print move by move."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model import FloatArray, IntArray
from ..paths import Feature
from ..pattern.wave import WavedOutlines
from ..toolpaths.moves import Moves
from .strands import Strands

NO_TONE = -1.0
_CELL = 1e-4  # mm; places that are nearer are the same
_BITS = 22  # of a coordinate in cells, enough for beds of 400 mm


def point_attributes(moves: Moves, tone: FloatArray | None = None) -> Callable[[Strands], dict[str, NDArray[Any]]]:
    """A function that gives the attributes of some strands of the moves: by name, (N,) values, one for every point.

    `move` is the number of its move within the layer, counting those that extrude; `speed` is in mm/s, `unsupported`
    in mm; `tone` is what was asked for there, `NO_TONE` where nothing was.

    Args:
        moves: the print.
        tone: (M,) of each row, see `tone_of_moves`.
    """
    number = _number_in_layer(moves)
    asked = np.full(len(number), NO_TONE) if tone is None else tone
    return lambda laid: {
        "move": number[laid.row],
        "speed": moves.speed[laid.row],
        "unsupported": laid.unsupported,
        "tone": asked[laid.row],
    }


def moves_of_layers(moves: Moves) -> IntArray:
    """(L,) how many moves of each layer extrude."""
    return np.bincount(moves.layer[moves.extrudes])


def tone_of_moves(outlines: WavedOutlines, moves: Moves, first_layer: int = 0) -> FloatArray:
    """(M,) the tone asked for where each row of the outer wall ends, `NO_TONE` for all others.

    Rows are recognized by where they end. What ends elsewhere, as a wall does that is closed at its seam, has the tone
    of the row before.

    Args:
        outlines: the waved outer wall.
        moves: the print.
        first_layer: of the moves that prints the first of the outlines; those below are a raft.
    """
    tone = np.full(len(moves.tool), NO_TONE)
    rows = np.flatnonzero(moves.feature == Feature.OUTER_WALL)
    if not len(rows) or not len(outlines.tone):
        return tone
    level = np.repeat(outlines.layer, np.diff(outlines.start)) + first_layer
    known = _key(outlines.points, level)
    order = np.argsort(known, kind="stable")
    wanted = _key(moves.position[rows, :2], moves.layer[rows])
    at = order[np.minimum(np.searchsorted(known[order], wanted), len(order) - 1)]
    found = known[at] == wanted
    latest = np.maximum.accumulate(np.where(found, np.arange(len(rows)), 0))
    tone[rows] = np.where(found[latest], outlines.tone[at[latest]], NO_TONE)
    return tone


def _number_in_layer(moves: Moves) -> IntArray:
    """(M,) how many extruding rows of its layer come before each row."""
    extrudes = moves.extrudes
    before: IntArray = np.cumsum(extrudes) - extrudes
    counts = np.bincount(moves.layer[extrudes], minlength=int(moves.layer.max()) + 1)
    # Layers are printed one after the other; what comes before a layer is all below it.
    first = np.full(len(counts), np.iinfo(np.int64).max)
    np.minimum.at(first, moves.layer[extrudes], before[extrudes])
    number: IntArray = np.maximum(before - first[moves.layer], 0)
    return number


def _key(points: FloatArray, layer: IntArray) -> IntArray:
    cell = np.rint(points / _CELL).astype(np.int64) + (1 << (_BITS - 1))
    return np.asarray((layer << _BITS | cell[:, 0]) << _BITS | cell[:, 1])
