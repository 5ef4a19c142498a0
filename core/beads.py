"""From toolpath moves to the strands of plastic they lay down, the geometry of the predicted print."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .model import BoolArray, FloatArray, IntArray
from .toolpaths.moves import Moves

OVAL_FACTOR = math.sqrt(4.0 / math.pi)
"""A strand's full width and height as multiples of the extrusion width and the layer height.

With both diameters of an ellipse longer by this factor its area is width × height exactly, the cross-section that the
G-code extrudes. Strands overlap their neighbours by an eighth, above as beside, so no light leaks through a wall.
"""


@dataclass(frozen=True)
class Strands:
    """Polylines of extruded plastic: K strands with N points in all, in the order they are printed.

    Attributes:
        points: (N, 3) float64 mm, the strand's centre line, half a layer below the nozzle.
        start: (K + 1,) int64, where each strand's points start.
        tool: (K,) int64, 0 or 1.
        feature: (K,) int64, a `Feature`.
        layer: (K,) int64.
        width: (N,) float64 mm, extrusion width at each point.
        height: (K,) float64 mm, layer height.
    """

    points: FloatArray
    start: IntArray
    tool: IntArray
    feature: IntArray
    layer: IntArray
    width: FloatArray
    height: FloatArray

    def __len__(self) -> int:
        return len(self.tool)

    def selected(self, chosen: BoolArray) -> Strands:
        """Only the strands that `chosen` (K,) bool marks."""
        counts = np.diff(self.start)
        kept = np.repeat(chosen, counts)
        return Strands(
            points=self.points[kept],
            start=offsets(counts[chosen]),
            tool=self.tool[chosen],
            feature=self.feature[chosen],
            layer=self.layer[chosen],
            width=self.width[kept],
            height=self.height[chosen],
        )


def offsets(counts: IntArray) -> IntArray:
    """(K + 1,) int64 starts of K runs of the given lengths."""
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)


def strands(moves: Moves) -> Strands:
    """The strands that the moves lay down.

    Consecutive extruding rows of one tool, feature, layer and height make one strand; it starts where the nozzle
    stood before its first row. A row that extrudes without a move before it has nowhere to start from and is left out.
    """
    rows = np.flatnonzero(moves.extrudes)
    rows = rows[rows > 0]
    begins = np.ones(len(rows), dtype=bool)
    begins[1:] = np.diff(rows) > 1
    for column in (moves.tool, moves.feature, moves.layer, moves.height):
        values = column[rows]
        begins[1:] |= values[1:] != values[:-1]
    first = np.flatnonzero(begins)
    lead = rows[first]

    counts = np.diff(np.append(first, len(rows))) + 1
    start = offsets(counts)
    source = np.empty(len(rows) + len(first), dtype=np.int64)
    is_start = np.zeros(len(source), dtype=bool)
    is_start[start[:-1]] = True
    source[is_start] = lead - 1
    source[~is_start] = rows

    height = moves.height[lead]
    points = moves.position[source]
    points[:, 2] -= np.repeat(height / 2, counts)
    width = moves.width[source]
    width[is_start] = moves.width[lead]
    return Strands(points, start, moves.tool[lead], moves.feature[lead], moves.layer[lead], width, height)


def semi_axes(width: FloatArray, height: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Horizontal and vertical semi-axis, mm, of the oval whose area is width × height."""
    return width * (OVAL_FACTOR / 2), height * (OVAL_FACTOR / 2)


def volume_mm3(laid: Strands) -> FloatArray:
    """(K,) mm³ of plastic in each strand: length × width × height, the width at a point being that of its line."""
    lengths = np.zeros(len(laid.points))
    lengths[1:] = np.linalg.norm(np.diff(laid.points, axis=0), axis=1)
    lengths[laid.start[:-1]] = 0.0
    areas = laid.width * np.repeat(laid.height, np.diff(laid.start))
    if not len(laid):
        return np.zeros(0)
    return np.add.reduceat(lengths * areas, laid.start[:-1])
