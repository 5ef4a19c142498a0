"""Closed outlines of all layers as flat arrays, each segment with the face and the UVs that it was cut from."""

from __future__ import annotations

from dataclasses import fields
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model import BoolArray, FloatArray, IntArray
from ..parallel import CHUNK_ROWS
from ..ragged import ahead, following, preceding, runs, starts, sums
from ..records import dataclass


@dataclass(frozen=True)
class Outlines:
    """M closed loops with N points in all; a loop does not repeat its first point.

    Segment i runs from point i to the next point of its loop and lies in one face, so what it carries from the
    surface is linear along it and never jumps at a UV seam.

    Attributes:
        points: (N, 2) float64 mm.
        start: (M + 1,) int64, where each loop's points start.
        layer: (M,) int64, not decreasing.
        face: (N,) int64, the face that segment i was cut from.
        carried: (N, 2, C) float64, u, v and, where the mesh has any, vertex tone at both ends of segment i.
    """

    points: FloatArray
    start: IntArray
    layer: IntArray
    face: IntArray
    carried: FloatArray

    @property
    def count(self) -> IntArray:
        """(M,) points of each loop."""
        return np.diff(self.start)

    @property
    def loop(self) -> IntArray:
        """(N,) the loop of each point."""
        return np.repeat(np.arange(len(self.layer)), self.count)

    @property
    def following(self) -> IntArray:
        """(N,) index of the next point of the same loop."""
        return following(self.start)

    @property
    def ends(self) -> FloatArray:
        """(N, 2) mm, where each segment ends."""
        return ahead(self.points, self.start)

    @cached_property
    def signed_area(self) -> FloatArray:
        """(M,) mm², positive for counter-clockwise loops; not to be written to."""
        # Relative to a point of the loop itself, so that a far-away loop loses no digits.
        x, y = self.points.T - np.repeat(self.points[self.start[:-1]].T, self.count, axis=1)
        area: FloatArray = sums(x * ahead(y, self.start) - y * ahead(x, self.start), self.start) / 2
        area.flags.writeable = False
        return area

    def selected(self, keep: BoolArray) -> Outlines:
        """Only the loops that `keep` (M,) marks."""
        if keep.all():
            return self
        return self._of(np.flatnonzero(np.repeat(keep, self.count)), self.count[keep], self.layer[keep])

    def reduced(self, keep: BoolArray, point: BoolArray, count: IntArray, in_place: bool = False) -> Outlines:
        """The loops that `keep` (M,) marks, with only the points that `point` (N,) marks: `count` (M,) of each loop.

        With `in_place`, the arrays of these loops are used for those, which saves memory and time.
        """
        if keep.all() and point.all():
            return self
        if not keep.any():
            return self.between(0, 0)
        kept = np.flatnonzero(np.repeat(keep, self.count) & point)
        return self._of(kept, count[keep], self.layer[keep], in_place)

    def _of(self, point: IntArray, count: IntArray, layer: IntArray, in_place: bool = False) -> Outlines:
        """Loops made of some of the points, `count` (M,) each; see `reduced`."""
        rows = _moved_up if in_place else _taken
        points, face, carried = (rows(column, point) for column in (self.points, self.face, self.carried))
        return Outlines(points, starts(count), layer, face, carried)

    def between(self, first: int, last: int) -> Outlines:
        """The loops from `first` to the one before `last`, as views."""
        points = slice(self.start[first], self.start[last])
        start = self.start[first : last + 1] - self.start[first]
        return Outlines(self.points[points], start, self.layer[first:last], self.face[points], self.carried[points])

    def reversed(self, turn: BoolArray) -> Outlines:
        """The same loops, those that `turn` (M,) marks the other way round."""
        if not turn.any():
            return self
        turned = np.repeat(turn, self.count)
        index = np.arange(len(self.points))
        mirrored = (self.start[:-1] + self.start[1:] - 1)[self.loop] - index
        point = np.where(turned, mirrored, index)
        # Reversed point k is old point n-1-k; the segment that leaves it is the one that used to arrive there.
        arriving = np.where(turned, preceding(self.start)[point], index)
        carried = self.carried.take(arriving, axis=0)
        carried[turned] = carried[turned, ::-1]
        return Outlines(self.points.take(point, axis=0), self.start, self.layer, self.face.take(arriving), carried)

    def runs(self, keep: BoolArray) -> list[Outlines]:
        """The loops that `keep` (M,) marks, as views: one for each run of consecutive loops."""
        return [self.between(first, end) for first, end in runs(keep)]

    @staticmethod
    def joined(parts: list[Outlines]) -> Outlines:
        """All loops of several tables, ordered by layer."""
        layer = np.concatenate([part.layer for part in parts])
        if (layer[1:] < layer[:-1]).any():
            # Copied in runs of loops that stay together, which is several times as fast as point by point.
            first = starts(np.array([len(part.layer) for part in parts]))
            order = np.argsort(layer, kind="stable")
            owner = np.searchsorted(first, order, side="right") - 1
            begin = np.flatnonzero((np.diff(order, prepend=-2) != 1) | (np.diff(owner, prepend=-1) != 0))
            own = owner[begin]
            low = order[begin] - first[own]
            runs = zip(own.tolist(), low.tolist(), (low + np.diff(begin, append=len(order))).tolist(), strict=True)
            parts = [parts[number].between(one, other) for number, one, other in runs]
        names = (column.name for column in fields(Outlines) if column.name != "start")
        whole = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
        return Outlines(start=starts(np.concatenate([part.count for part in parts])), **whole)


def _taken(column: NDArray[Any], rows: IntArray) -> NDArray[Any]:
    """Some rows of a column; this is several times as fast as indexing where each row holds a few numbers."""
    return column.take(rows, axis=0)


def _moved_up(column: NDArray[Any], rows: IntArray) -> NDArray[Any]:
    """The same, in place, of increasing numbers of rows."""
    for begin in range(0, len(rows), CHUNK_ROWS):
        some = rows[begin : begin + CHUNK_ROWS]
        if some[-1] >= begin + len(some):  # else nothing before them is left out
            column[begin : begin + len(some)] = column.take(some, axis=0)
    return column[: len(rows)]


def interpolated(ends: FloatArray, share: FloatArray) -> FloatArray:
    """(N, …) values interpolated between both ends of segments (N, 2, …), at a share (N,) of the way, at most 1."""
    share = np.clip(share, 0, 1)[:, None]
    return np.asarray(ends[:, 0] + share * (ends[:, 1] - ends[:, 0]))
