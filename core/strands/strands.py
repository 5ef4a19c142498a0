"""The strands of plastic that toolpath moves lay down: the geometry of the predicted print."""

from __future__ import annotations

import math

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..ragged import ranges, starts
from ..records import dataclass
from ..toolpaths.moves import Moves

_SAME_PLACE = 1e-3  # mm, of an end and a beginning; a file has no finer coordinates


@dataclass(frozen=True)
class Strands:
    """Polylines of extruded plastic: K strands with N points in all, in the order they are printed.

    Attributes:
        points: (N, 3) float64 mm, the strand's center line, half a layer below the nozzle.
        start: (K + 1,) int64, where each strand's points start.
        tool: (K,) int64, 0 or 1.
        feature: (K,) int64, a `Feature`.
        layer: (K,) int64.
        width: (N,) float64 mm, extrusion width at each point.
        height: (K,) float64 mm, layer height.
        roundness: (N,) float64, 0 an oval as much wider than high as `width` to `height`, 1 a
            circle of the same area.
        unsupported: (N,) float64 mm, how far the center line lies outside what carries it.
        row: (N,) int64, the move that ends at or after each point; a strand's first point has that of its second.
    """

    points: FloatArray
    start: IntArray
    tool: IntArray
    feature: IntArray
    layer: IntArray
    width: FloatArray
    height: FloatArray
    roundness: FloatArray
    unsupported: FloatArray
    row: IntArray

    def __len__(self) -> int:
        return len(self.tool)

    def selected(self, chosen: BoolArray) -> Strands:
        """Only the strands that `chosen` (K,) bool marks."""
        return self.gathered(np.flatnonzero(chosen))

    def gathered(self, which: IntArray) -> Strands:
        """The strands of the given numbers, in that order."""
        counts = np.diff(self.start)[which]
        return self._rearranged(which, ranges(self.start[which], counts), starts(counts))

    def _rearranged(self, which: IntArray, point: IntArray, start: IntArray) -> Strands:
        """Strands with what these have by strand from `which`, and by point from `point`."""
        return Strands(
            points=self.points[point],
            start=start,
            tool=self.tool[which],
            feature=self.feature[which],
            layer=self.layer[which],
            width=self.width[point],
            height=self.height[which],
            roundness=self.roundness[point],
            unsupported=self.unsupported[point],
            row=self.row[point],
        )


def strands(moves: Moves) -> Strands:
    """The strands that the moves lay down, as if all of them rested on material; see `settled`.

    Extruding rows of one tool, feature, layer and height that go on where the last one ended make one strand; it starts
    where the nozzle stood before its first row. A row that extrudes without a move before it has nowhere to start from
    and is left out.
    """
    rows = np.flatnonzero(moves.extrudes)
    rows = rows[rows > 0]
    begins = np.ones(len(rows), dtype=bool)
    jump = moves.position.take(rows[1:] - 1, axis=0) - moves.position.take(rows[:-1], axis=0)
    begins[1:] = (np.abs(jump) > _SAME_PLACE).any(axis=1)
    for column in (moves.tool, moves.feature, moves.layer, moves.height):
        values = column[rows]
        begins[1:] |= values[1:] != values[:-1]
    first = np.flatnonzero(begins)
    lead = rows[first]

    counts = np.diff(np.append(first, len(rows))) + 1
    start = starts(counts)
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
    kind = (moves.tool[lead], moves.feature[lead], moves.layer[lead])
    source[is_start] = lead
    return Strands(points, start, *kind, width, height, np.zeros(len(points)), np.zeros(len(points)), source)


def split_by_roundness(laid: Strands, levels: int) -> tuple[Strands, FloatArray]:
    """Cut strands where their roundness passes from one of a few levels to the next; the parts share that point.

    Args:
        laid: K strands.
        levels: how many there are from 0 to 1, both included.

    Returns:
        The parts, P of them, and (P,) the roundness that stands for each.
    """
    if not len(laid):
        return laid, np.zeros(0)
    level = np.zeros(len(laid.points), dtype=np.int64)  # of the segment that ends at each point
    level[1:] = np.rint((laid.roundness[1:] + laid.roundness[:-1]) / 2 * (levels - 1))
    is_start = np.zeros(len(level), dtype=bool)
    is_start[laid.start[:-1]] = True
    level[is_start] = level[np.minimum(laid.start[:-1] + 1, len(level) - 1)]
    # A point where the level changes is written twice, as an end and as a beginning.
    joint = np.zeros(len(level), dtype=bool)
    joint[:-1] = (level[1:] != level[:-1]) & ~is_start[1:] & ~is_start[:-1]
    source = np.repeat(np.arange(len(level)), 1 + joint)
    begins = is_start[source]
    begins[1:] |= source[1:] == source[:-1]
    first = np.flatnonzero(begins)
    parts = laid._rearranged(np.cumsum(is_start)[source[first]] - 1, source, np.append(first, len(source)))
    return parts, level[np.minimum(source[first] + 1, len(level) - 1)] / max(levels - 1, 1)


def semi_axes(
    width: FloatArray, height: FloatArray, roundness: FloatArray | float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Horizontal and vertical semi-axis, mm, of the oval or circle whose area is width × height."""
    radius = np.sqrt(width * height / math.pi)
    stretch = (width / height) ** ((1.0 - roundness) / 2)
    return radius * stretch, radius / stretch
