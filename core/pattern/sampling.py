"""Where the waves sit: samples carried from layer to layer by projection and relaxation (paper, Algorithm 1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..settings import PrintSettings
from ..slicing.outlines import following, ranges, starts
from .contours import Contours, long_enough, on_loop
from .grid import PointGrid, nearest

# Spacings are compared with this slack, mm, so that rounding does not prune an exact fit.
SLACK = 1e-9


@dataclass(frozen=True)
class Samples:
    """One sample for each whole wave, on all layers.

    Attributes:
        arc: (S,) mm, place on the contours (see `Contours.arc`), increasing.
        loop: (S,) int64, its contour.
        start: (M + 1,) int64, where each contour's samples start; a contour too short for the pattern has none.
    """

    arc: FloatArray
    loop: IntArray
    start: IntArray

    def spacing(self, lines: Contours) -> FloatArray:
        """(S,) mm along the contour from each sample to the next one of its loop."""
        return _spacing(self.arc - lines.arc_start[self.loop], self.start, lines.length)


class Projector:
    """Nearest places on the contours of a layer, within the projection threshold."""

    def __init__(self, lines: Contours, threshold: float) -> None:
        """Prepare the search on all layers of `lines`; `threshold` in mm."""
        self.lines = lines
        self.threshold = threshold
        step = lines.length / np.maximum(np.diff(lines.start), 1)
        # A place lies at most half a step from a point, so that the cell has to be that much larger.
        self.loop = lines.loop
        self.grid = PointGrid(lines.points, lines.layer[self.loop], threshold + float(step.max(initial=0.0)) / 2)
        self.ahead = following(lines.start)
        self.behind = np.empty_like(self.ahead)
        self.behind[self.ahead] = np.arange(len(self.ahead))

    def project(self, query: FloatArray, layer: IntArray) -> tuple[FloatArray, FloatArray]:
        """Nearest place on the contours of `layer` (Q,) for each query point (Q, 2).

        Returns:
            (Q,) arc and (Q,) distance in mm, infinite where nothing lies within the threshold.
        """
        found, group = self.grid.candidates(query, layer)
        this = np.repeat(np.arange(len(query)), np.diff(group))
        away = self.lines.points[found] - query[this]
        where, filled = nearest(away[:, 0] ** 2 + away[:, 1] ** 2, group)
        arc, distance = np.zeros(len(query)), np.full(len(query), np.inf)
        point = found[where[filled]] if len(found) else np.zeros(0, dtype=np.int64)
        for first in (point, self.behind[point]):
            place, gap = self._on_segment(query[filled], first)
            closer = gap < distance[filled]
            arc[filled] = np.where(closer, place, arc[filled])
            distance[filled] = np.minimum(gap, distance[filled])
        distance[distance > self.threshold] = np.inf
        return arc, distance

    def _on_segment(self, query: FloatArray, first: IntArray) -> tuple[FloatArray, FloatArray]:
        tail, head = self.lines.points[first], self.lines.points[self.ahead[first]]
        along = head - tail
        length2 = np.maximum((along**2).sum(axis=1), 1e-18)
        share = np.clip(((query - tail) * along).sum(axis=1) / length2, 0, 1)
        away = tail + share[:, None] * along - query
        arc = self.lines.arc[first] + share * np.sqrt(length2)
        return on_loop(arc, self.loop[first], self.lines.arc_start), np.hypot(away[:, 0], away[:, 1])


def sample(lines: Contours, projector: Projector, settings: PrintSettings) -> Samples:
    """Place samples on every layer from the bottom to the top (paper, Algorithm 1).

    Projection is sequential by nature; within a layer all loops and samples are treated at once.

    Args:
        lines: contours of all layers.
        projector: made for the same contours.
        settings: wavelength and relaxation are used; spacings stay in [λ, 2λ).
    """
    usable = long_enough(lines.length, settings)
    layers = int(lines.layer.max(initial=-1)) + 1
    first_loop = np.searchsorted(lines.layer, np.arange(layers + 1))
    parts: list[FloatArray] = []
    arc = np.zeros(0)
    for layer in range(layers):
        loops = slice(first_loop[layer], first_loop[layer + 1])
        if len(arc):
            place, distance = projector.project(_points_at(lines, arc), np.full(len(arc), layer))
            arc = place[np.isfinite(distance)]
        arc = _settled(arc, lines.arc_start[loops.start : loops.stop + 1], usable[loops], settings)
        parts.append(arc)
    every = np.concatenate(parts) if parts else arc
    loop = np.searchsorted(lines.arc_start, every, side="right") - 1
    return Samples(every, loop, starts(np.bincount(loop, minlength=len(lines.layer))))


def _points_at(lines: Contours, arc: FloatArray) -> FloatArray:
    before, after, share = lines.locate(arc)
    return np.asarray(lines.points[before] + share[:, None] * (lines.points[after] - lines.points[before]))


def _settled(arc: FloatArray, arc_start: FloatArray, usable: BoolArray, settings: PrintSettings) -> FloatArray:
    """Relax, prune, fill and relax again the samples of one layer; `arc_start` is that of its loops and their end."""
    length = np.diff(arc_start)
    loop = np.clip(np.searchsorted(arc_start, arc, side="right") - 1, 0, max(len(length) - 1, 0))
    keep = usable[loop] if len(length) else np.zeros(len(arc), dtype=bool)
    loop = loop[keep]
    local = np.mod(arc[keep] - arc_start[loop], length[loop])
    local, loop = _sorted(local, loop)
    local, loop = _relaxed(local, loop, length, settings.relaxation)
    local, loop = _pruned(local, loop, length, settings.wavelength)
    local, loop = _filled(local, loop, length, usable, settings.wavelength)
    local, loop = _relaxed(local, loop, length, settings.relaxation)
    return np.sort(on_loop(arc_start[loop] + local, loop, arc_start))


def _sorted(local: FloatArray, loop: IntArray) -> tuple[FloatArray, IntArray]:
    order = np.lexsort((local, loop))
    return local[order], loop[order]


def _spacing(local: FloatArray, start: IntArray, length: FloatArray) -> FloatArray:
    """Distance from each sample to the next one around its loop."""
    ahead = following(start)
    loop = np.repeat(np.arange(len(length)), np.diff(start))
    gap = local[ahead] - local
    wraps = ahead <= np.arange(len(ahead))
    return np.where(wraps, gap + length[loop], gap)


def _relaxed(local: FloatArray, loop: IntArray, length: FloatArray, share: float) -> tuple[FloatArray, IntArray]:
    """Move every sample by `share` of the way to the middle of its two neighbours.

    Spacings become weighted means of neighbouring spacings, so bounds that all of them keep stay kept.
    """
    if len(local) == 0:
        return local, loop
    start = starts(np.bincount(loop, minlength=len(length)))
    gap = _spacing(local, start, length)
    before = np.empty_like(gap)
    before[following(start)] = gap
    moved = np.mod(local + share * (gap - before) / 2, length[loop])
    return _sorted(moved, loop)


def _pruned(local: FloatArray, loop: IntArray, length: FloatArray, least: float) -> tuple[FloatArray, IntArray]:
    """Remove samples until none is closer than `least` to the next.

    In each round the spacings that are shorter than both their neighbours lose one end: the one whose removal leaves
    the shorter gap.
    """
    while True:
        start = starts(np.bincount(loop, minlength=len(length)))
        gap = _spacing(local, start, length)
        ahead = following(start)
        many = np.diff(start)[loop] > 1
        short = (gap < least - SLACK) & many
        if not short.any():
            return local, loop
        behind = np.empty_like(ahead)
        behind[ahead] = np.arange(len(ahead))
        chosen = short & _comes_first(gap, ahead) & _comes_first(gap, behind)
        doomed = np.where(gap[behind] <= gap[ahead], np.arange(len(gap)), ahead)[chosen]
        keep = np.ones(len(gap), dtype=bool)
        keep[doomed] = False
        local, loop = local[keep], loop[keep]


def _comes_first(gap: FloatArray, other: IntArray) -> BoolArray:
    """Whether each spacing is shorter than another one; of equal ones the earlier counts as shorter."""
    return np.asarray((gap < gap[other]) | ((gap == gap[other]) & (np.arange(len(gap)) < other)))


def _filled(
    local: FloatArray, loop: IntArray, length: FloatArray, usable: BoolArray, least: float
) -> tuple[FloatArray, IntArray]:
    """Insert evenly spaced samples into gaps of twice `least` and more, and start empty loops."""
    count = np.bincount(loop, minlength=len(length))
    empty = np.flatnonzero((count == 0) & usable)
    gap = _spacing(local, starts(count), length)
    # An empty loop is one gap of its whole length that has a sample at its beginning.
    begin = np.concatenate([local, np.zeros(len(empty))])
    loop = np.concatenate([loop, empty])
    gap = np.concatenate([gap, length[empty]])
    parts = np.where(gap >= 2 * least - SLACK, np.floor(gap / least + SLACK), 1).astype(np.int64)
    source = np.repeat(np.arange(len(gap)), parts)
    step = ranges(np.zeros(len(parts), dtype=np.int64), parts)
    place = begin[source] + gap[source] * step / parts[source]
    return _sorted(np.mod(place, length[loop[source]]), loop[source])
