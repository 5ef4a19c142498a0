"""From toolpath moves to the strands of plastic they lay down, the geometry of the predicted print."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..ragged import ranges
from ..records import dataclass
from ..toolpaths.moves import Moves
from .spans import unsupported_distance

_SAME_PLACE = 1e-3  # mm, of an end and a beginning; a file has no finer coordinates
_PIECE = 0.25  # mm between the points of a line over air, at least where it begins to be
_TOUCHING = 0.01  # mm; lines side by side are a half width away from one between them, give or take the last digit
_ROUNDING = 0.02  # of a piece: lengths of round numbers are cut alike whatever their last digit
_SAG_OF_1_MM = (3 * 1040 * 9.81 * 1.0 * 1e-12 / (128 * 1e4)) ** (1 / 3) * 1e3  # see `sag_depth`


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
        rows = ranges(self.start[which], counts)
        return Strands(
            points=self.points[rows],
            start=offsets(counts),
            tool=self.tool[which],
            feature=self.feature[which],
            layer=self.layer[which],
            width=self.width[rows],
            height=self.height[which],
            roundness=self.roundness[rows],
            unsupported=self.unsupported[rows],
            row=self.row[rows],
        )


def offsets(counts: IntArray) -> IntArray:
    """(K + 1,) int64 starts of K runs of the given lengths."""
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)


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
    kind = (moves.tool[lead], moves.feature[lead], moves.layer[lead])
    source[is_start] = lead
    return Strands(points, start, *kind, width, height, np.zeros(len(points)), np.zeros(len(points)), source)


def settled(laid: Strands, sag: float) -> Strands:
    """The strands as they lie when they have cooled: on material an oval, over air rounder and lower.

    A point is over air where its center line lies outside the strands of the layer below (`unsupported_distance`).
    There the strand becomes a circle by the time nothing of it is above them any more, and sinks as `sag_depth` says.
    Both follow from a distance that has no jumps, so the strand has none either. Long lines over air get more points.
    What a line gains in length by sinking it loses in width: its volume stays.

    Args:
        laid: strands as the nozzle went.
        sag: mm, the most that any strand sinks.
    """
    if not len(laid):
        return laid
    dense, left = _subdivided(laid)
    free = unsupported_distance(dense.points, dense.start, dense.layer, dense.width)
    over_air = free > _TOUCHING
    # A line that rests on material needs no points between its ends, one that is round all over only every second.
    wanted = (left == 0) | (_or_next_to(over_air) & ((left % 2 == 0) | _or_next_to(free < dense.width / 2)))
    rows = np.flatnonzero(wanted)
    start = np.concatenate([[0], np.cumsum(wanted)])[dense.start]
    points, width, free = dense.points[rows], dense.width[rows], free[rows]
    roundness = _eased(free / (width / 2))
    flat = _steps(points)
    points[:, 2] -= sag_depth(free, sag)
    sunk = _steps(points)
    lengthened = sunk > flat
    lengthened[start[:-1]] = False
    width[lengthened] *= flat[lengthened] / sunk[lengthened]
    return replace(
        dense, points=points, start=start, width=width, roundness=roundness, unsupported=free, row=dense.row[rows]
    )


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
    of = np.cumsum(is_start)[source[first]] - 1
    parts = Strands(
        points=laid.points[source],
        start=np.append(first, len(source)),
        tool=laid.tool[of],
        feature=laid.feature[of],
        layer=laid.layer[of],
        width=laid.width[source],
        height=laid.height[of],
        roundness=laid.roundness[source],
        unsupported=laid.unsupported[source],
        row=laid.row[source],
    )
    return parts, level[np.minimum(source[first] + 1, len(level) - 1)] / max(levels - 1, 1)


def sag_depth(free: FloatArray, most: float) -> FloatArray:
    """How far a strand sinks, mm, where it is `free` mm away from what carries it; at most `most` mm.

    A thread of length L = 2·free between two supports hangs as a parabola of depth s under the tension
    T = ρ·g·A·L² / (8·s), and that tension draws a viscous thread, T = 3·μ·A·(rate of strain), where the strain is
    8/3·(s/L)². So s³ = 3·ρ·g·t·L⁴ / (128·μ) after the time t for which it stays soft: the depth grows with L^(4/3).
    ABS just out of the nozzle (ρ = 1040 kg/m³, μ = 10 kPa·s, soft for about a second) sinks 0.6 mm in a span of 10 mm,
    and 0.03 mm in one of 1 mm. The limit stands for what this leaves out: neighbors in the same layer that the strand
    sticks to, and the nozzle's pull.
    """
    if most <= 0:
        return np.zeros(len(free))
    depth: FloatArray = most * np.tanh(_SAG_OF_1_MM * (2 * free) ** (4 / 3) / most)
    return depth


def semi_axes(
    width: FloatArray, height: FloatArray, roundness: FloatArray | float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Horizontal and vertical semi-axis, mm, of the oval or circle whose area is width × height."""
    radius = np.sqrt(width * height / math.pi)
    stretch = (width / height) ** ((1.0 - roundness) / 2)
    return radius * stretch, radius / stretch


def _subdivided(laid: Strands) -> tuple[Strands, IntArray]:
    """The strands with points between those that are far apart, and (N,) how many steps are left to an old one."""
    lengths = _steps(laid.points)
    lengths[laid.start[:-1]] = 0.0
    pieces = np.maximum(np.ceil(lengths / _PIECE - _ROUNDING), 1).astype(np.int64)
    source = np.repeat(np.arange(len(pieces)), pieces)
    ends = np.cumsum(pieces)
    left = ends[source] - 1 - np.arange(len(source))
    points = laid.points[source]
    new = np.flatnonzero(left)
    of = source[new]
    points[new] -= (left[new] / pieces[of])[:, None] * (points[new] - laid.points[of - 1])
    dense = replace(laid, points=points, start=np.concatenate([[0], ends])[laid.start], width=laid.width[source],
                    row=laid.row[source])  # fmt: skip
    return dense, left


def _steps(points: FloatArray) -> FloatArray:
    """(N,) mm from the point before, 0 for the first."""
    lengths = np.zeros(len(points))
    step = np.diff(points, axis=0)
    lengths[1:] = np.sqrt(np.einsum("ij,ij->i", step, step))
    return lengths


def _or_next_to(marked: BoolArray) -> BoolArray:
    """(N,) points that are marked or have a marked neighbor."""
    spread = marked.copy()
    spread[1:] |= marked[:-1]
    spread[:-1] |= marked[1:]
    return spread


def _eased(share: FloatArray) -> FloatArray:
    """From 0 to 1 without a bend at either end."""
    clipped = np.clip(share, 0.0, 1.0)
    eased: FloatArray = clipped * clipped * (3.0 - 2.0 * clipped)
    return eased
