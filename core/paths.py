"""The lines to extrude: what walls, fill, supports and all around the object end in before they are put in order."""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from .model import BoolArray, FloatArray, IntArray
from .ragged import ranges, starts
from .records import dataclass


class Feature(IntEnum):
    """What a line of the print is for."""

    TRAVEL = 0
    RETRACT = 1
    OUTER_WALL = 2
    INNER_WALL = 3
    SKIN = 4
    INFILL = 5
    TOWER = 6
    SKIRT = 7
    SUPPORT = 8
    SUPPORT_INTERFACE = 9
    BRIM = 10
    RAFT = 11
    OOZE_SHIELD = 12
    BRIDGE = 13


@dataclass(frozen=True)
class Paths:
    """Polylines to extrude, of all layers, in no order yet. K paths with N points in all.

    Attributes:
        points: (N, 2) float64 mm; a closed path does not repeat its first point.
        start: (K + 1,) int64, where each path's points start.
        layer: (K,) int64.
        feature: (K,) int64, a `Feature`.
        island: (K,) int64, which connected region of its layer a path belongs to; printed together.
        closed: (K,) bool.
        width: (N,) float64 mm, of the line that leaves each point.
        swapped: (K,) bool, printed by the other tool than its layer's; None where no path is.
    """

    points: FloatArray
    start: IntArray
    layer: IntArray
    feature: IntArray
    island: IntArray
    closed: BoolArray
    width: FloatArray
    swapped: BoolArray | None = None

    @staticmethod
    def empty() -> Paths:
        """No path at all."""
        none = np.zeros(0, dtype=np.int64)
        return Paths(np.zeros((0, 2)), np.zeros(1, dtype=np.int64), none, none, none, none.astype(bool), np.zeros(0))

    @staticmethod
    def alike(
        points: FloatArray,
        start: IntArray,
        layer: IntArray,
        *,
        feature: Feature,
        island: IntArray | int,
        closed: bool,
        width: FloatArray | float,
    ) -> Paths:
        """Paths of one feature, all closed or all open, perhaps of one island or width; all else as the attributes."""
        count = len(layer)
        return Paths(
            points=points,
            start=np.asarray(start, dtype=np.int64),
            layer=np.asarray(layer, dtype=np.int64),
            feature=np.full(count, int(feature), dtype=np.int64),
            island=np.asarray(np.broadcast_to(island, count), dtype=np.int64),
            closed=np.full(count, closed),
            width=width if isinstance(width, np.ndarray) else np.full(len(points), width),
        )

    @property
    def first_layer(self) -> Paths:
        """The paths of layer 0, as views; the layers must not decrease."""
        count = int(np.searchsorted(self.layer, 1))
        points = slice(0, self.start[count])
        return Paths(
            points=self.points[points],
            start=self.start[: count + 1],
            layer=self.layer[:count],
            feature=self.feature[:count],
            island=self.island[:count],
            closed=self.closed[:count],
            width=self.width[points],
            swapped=None if self.swapped is None else self.swapped[:count],
        )

    def selected(self, keep: BoolArray) -> Paths:
        """The paths that `keep` (K,) marks."""
        count: IntArray = np.diff(self.start)[keep]
        point = ranges(self.start[:-1][keep], count)
        return Paths(
            points=self.points.take(point, axis=0),
            start=starts(count),
            layer=self.layer[keep],
            feature=self.feature[keep],
            island=self.island[keep],
            closed=self.closed[keep],
            width=self.width[point],
            swapped=None if self.swapped is None else self.swapped[keep],
        )

    @staticmethod
    def joined(parts: list[Paths]) -> Paths:
        """All paths of several tables in one."""
        parts = [part for part in parts if len(part.layer)] or [Paths.empty()]
        if len(parts) == 1:
            return parts[0]
        counts = np.concatenate([np.diff(part.start) for part in parts])
        return Paths(
            points=np.concatenate([part.points for part in parts]),
            start=starts(counts),
            layer=np.concatenate([part.layer for part in parts]),
            feature=np.concatenate([part.feature for part in parts]),
            island=np.concatenate([part.island for part in parts]),
            closed=np.concatenate([part.closed for part in parts]),
            width=np.concatenate([part.width for part in parts]),
            swapped=Paths._swapped(parts),
        )

    @staticmethod
    def _swapped(parts: list[Paths]) -> BoolArray | None:
        if all(part.swapped is None for part in parts):
            return None
        none = (np.zeros(len(part.layer), dtype=bool) for part in parts)
        columns = [own if part.swapped is None else part.swapped for part, own in zip(parts, none, strict=True)]
        swapped: BoolArray = np.concatenate(columns)
        return swapped


def way_ahead(points: FloatArray, last: IntArray) -> FloatArray:
    """(N,) mm from each point (N, 2) of open lines to the next of its line, 0 at the `last` (K,) of each."""
    way = np.zeros(len(points))
    way[:-1] = np.hypot(*np.diff(points, axis=0).T)
    way[last] = 0.0
    return way
