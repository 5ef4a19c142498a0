"""Places on the contours and their images on the layer above, and where both lie in the waves between samples."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..contours.contours import Contours
from ..contours.places import loop_of
from ..lookup import Lookup
from ..model import BoolArray, FloatArray, IntArray
from ..parallel import product
from ..ragged import following, preceding, ranges
from ..records import dataclass
from .phase_grid import PhaseGrid
from .projector import Projector, squared
from .samples import Samples
from .spacing import gaps

Singles = NDArray[np.float32]

# The error from which on a seam is seen.
VISIBLE = 0.5
HALF, FULL = np.float32(np.pi), np.float32(2 * np.pi)


@dataclass(frozen=True)
class Pairs:
    """P places (first row) and their images on the layer above (second row), and how much a seam between them matters.

    Attributes:
        before: (2, P) int64, the sample before each.
        along: (2, P) mm from where that sample was at first to the place.
        importance: (P,) mm of contour that each place stands for, times its weight.
    """

    before: IntArray
    along: Singles
    importance: Singles


class MovingSamples:
    """Samples that move along their contours, each counted from its contour's beginning so that it cannot leave it.

    Attributes:
        place: (S,) mm from the beginning of each one's contour; below 0 or beyond its end after moving over it.
        first: (S,) the same before anything moved.
        first_gap: (S,) mm from each sample to the next before anything moved.
    """

    def __init__(self, lines: Contours, samples: Samples) -> None:
        self.loop, self.start = samples.loop, samples.start
        self.length = lines.length
        self.arc_start = lines.arc_start
        self.arc, self.lookup = samples.arc, Lookup(samples.arc)
        self.first = self.place = samples.arc - lines.arc_start[samples.loop]
        self.ahead, self.behind = following(self.start), preceding(self.start)
        self.first_gap = self.gap().astype(np.float32)

    def gap(self) -> FloatArray:
        """(S,) mm from each sample to the next."""
        return gaps(self.place, self.start, self.length)

    def locate(self, arc: FloatArray, loop: IntArray) -> tuple[IntArray, FloatArray]:
        """The sample before each of Q places before anything has moved, and how many mm these lie after it.

        Args:
            arc: (Q,) the places.
            loop: (Q,) their contours. What lies before a contour's first sample is in the wave after its last one.
        """
        before = self.lookup.before(arc)
        wrapped = np.flatnonzero(before < self.start.take(loop))
        before[wrapped] = self.start[loop[wrapped] + 1] - 1
        along = arc - self.arc.take(before)
        along[wrapped] += self.length[loop[wrapped]]
        return before, along

    def seen(self, pairs: Pairs, exact: bool) -> float:
        """How many mm of contour show a seam: by the error at the places if `exact`, else by their slide."""
        share, _ = self.shares(pairs)
        if exact:
            low, high = np.cos(FULL * share)
            return product(pairs.importance, (low - high) ** 2 >= VISIBLE)
        # The share of all phases at which 4 sin²(π slide) sin²(phase) is VISIBLE.
        sine, least = np.abs(np.sin(HALF * (share[0] - share[1]))), np.float32(np.sqrt(VISIBLE) / 2)
        some = np.flatnonzero(sine > least)
        return product(pairs.importance[some], np.arccos(least / sine[some])) / (np.pi / 2)

    def shares(self, pairs: Pairs) -> tuple[Singles, Singles]:
        """(2, P) which share of the way from the sample before to the next each place lies at, and (2, P) 1 / that way.

        Where samples have moved past places since these were located, the share is a little below 0 or above 1.
        """
        moved, inverse = (self.place - self.first).astype(np.float32), (1 / self.gap()).astype(np.float32)
        # No index is out of range; with mode="clip" numpy saves itself the check.
        steep = inverse.take(pairs.before, mode="clip")
        share = pairs.along - moved.take(pairs.before, mode="clip")
        share *= steep
        return share, steep

    def relocate(self, pairs: Pairs) -> None:
        """Find the sample before each place again; none may have moved past a place by more than one spacing."""
        share, before, along = self.shares(pairs)[0].ravel(), pairs.before.ravel(), pairs.along.ravel()
        astray = np.flatnonzero((share < 0) | (share >= 1))
        self.pass_on(before, along, astray, share[astray] < 0)

    def pass_on(self, before: IntArray, along: NDArray[Any], astray: IntArray, early: BoolArray) -> None:
        """Give places `astray` (Q,) to the sample before theirs where they are `early` (Q,), else to the next one."""
        old = before[astray]
        new = np.where(early, self.behind[old], self.ahead[old])
        along[astray] += np.where(early, self.first_gap[new], -self.first_gap[old])
        before[astray] = new


def near_seams(grid: PhaseGrid, waves: MovingSamples, seam: float, around: int) -> tuple[BoolArray, IntArray]:
    """Which samples are near a seam, and on which edges of the grid something depends on them.

    Args:
        grid: of all layers.
        waves: the samples.
        seam: where the error exceeds this at some phase of the wave is a seam.
        around: how many samples on each side of a seam are near it.

    Returns:
        (S,) which samples are near a seam, and (Q,) the nodes at which those edges begin.
    """
    node = np.flatnonzero(grid.linked)
    own, up = grid.loop[node], grid.loop[grid.low[node]]
    gap = waves.gap()
    low, along = waves.locate(grid.arc[node], own)
    high, above = waves.locate(grid.above[node], up)
    slide = along / gap[low] - above / gap[high]
    seen = np.abs(slide - np.rint(slide)) > np.arcsin(np.sqrt(seam) / 2) / np.pi
    near = np.zeros(len(waves.place), dtype=bool)
    near[low[seen]] = True
    near[high[seen]] = True
    for _ in range(around):
        near |= near[waves.ahead] | near[waves.behind]
    wanted = np.zeros(len(grid.arc), dtype=bool)
    wanted[node] = near[low] | near[high]
    wanted |= wanted[grid.ahead]
    return near, np.flatnonzero(wanted)


def pairs_between(
    projector: Projector,
    grid: PhaseGrid,
    waves: MovingSamples,
    node: IntArray,
    free: BoolArray,
    weight: FloatArray,
    apart: float,
) -> Pairs:
    """Places on edges of the grid and their images, as far as a sample that may move has a part in their phase.

    Args:
        projector: made for the contours.
        grid: of all layers.
        waves: the samples.
        node: (Q,) int64, the nodes at which the edges begin.
        free: (S,) samples that may move.
        weight: (N,) how much a seam at each contour point matters.
        apart: distance between places, in contour points.
    """
    lines = projector.lines
    which, point, query, arc = _places(projector, grid, node, apart)
    low, along = waves.locate(arc, grid.loop.take(node).take(which))
    image, up, near = _images(projector, grid, node, which, query, arc)
    found = np.flatnonzero(~np.isnan(image) & (np.diff(waves.start) > 0).take(up))
    image, up = image.take(found), up.take(found)
    high, above = waves.locate(image, up)
    shaped = free | free[waves.ahead]
    some = np.flatnonzero(shaped.take(low.take(found)) | shaped.take(high))
    found = found.take(some)
    # Between nodes the image is near the line between theirs.
    beyond, distance = projector.beside(query.take(found), image.take(some), near.take(found))
    above = above.take(some)
    above += beyond
    within = distance <= projector.threshold
    if not within.all():
        found, some, above = found[within], some[within], above[within]
    high = high.take(some)
    astray = np.flatnonzero((above < 0) | (above >= waves.first_gap.take(high)))
    waves.pass_on(high, above, astray, above[astray] < 0)
    matters = weight.take(point.take(found)) * (apart * float(lines.arc_start[-1] / len(lines.arc)))
    after = np.stack([along.take(found), above]).astype(np.float32)
    return Pairs(np.stack([low.take(found), high]), after, matters.astype(np.float32))


def _places(
    projector: Projector, grid: PhaseGrid, node: IntArray, apart: float
) -> tuple[IntArray, IntArray, NDArray[np.complex128], FloatArray]:
    """Places on the edges from nodes (Q,): (P,) which edge, the contour point before, where it is, and its arc."""
    lines, begins = projector.lines, grid.point.take(node)
    first, end = lines.start.take(grid.loop.take(node)), lines.start.take(grid.loop.take(node) + 1)
    last = np.where(grid.closes.take(node) > 0, end, grid.point.take(grid.ahead.take(node)))
    # How many places lie before each edge's beginning and before its end.
    begin, end = (np.ceil((point - first) / apart).astype(np.int64) for point in (begins, last))
    which, place = np.repeat(np.arange(len(node)), end - begin), apart * ranges(begin, end - begin)
    point = place.astype(np.int64)
    place -= point
    point += first.take(which)
    query, arc = projector.spot.take(point), lines.arc.take(point)
    if place.any():
        away = projector.along.take(point) * place
        query, arc = query + away, arc + np.sqrt(squared(away))
    return which, point, query, arc


def _images(
    projector: Projector,
    grid: PhaseGrid,
    node: IntArray,
    which: IntArray,
    query: NDArray[np.complex128],
    arc: FloatArray,
) -> tuple[FloatArray, IntArray, IntArray]:
    """(P,) arcs of the images of places on the layer above, NaN where there is none, (P,) their contours and points.

    They lie on the line between those of the edge's nodes; where these are torn apart, the place itself is projected.
    """
    lines, low = projector.lines, grid.low.take(node)
    slope, above = grid.step.take(node) / grid.length.take(node), grid.above.take(node)
    # Contour points between the nodes around an image lie about evenly.
    onward = grid.point[grid.ahead] + grid.closes.astype(np.int64) * np.diff(lines.start)[grid.loop]
    rate = ((onward - grid.point) / grid.length).take(low)
    rank = grid.point.take(low) + (above - grid.arc.take(low)) * rate
    way = (arc - grid.arc.take(node).take(which)) * slope.take(which)
    image, near = above.take(which) + way, way
    near *= rate.take(which)
    near += rank.take(which)
    torn = np.flatnonzero(np.isnan(image))
    near[torn] = 0.0
    near = np.minimum(near.astype(np.int64), len(lines.arc) - 1)
    up = grid.loop.take(low).take(which)
    here = grid.loop[node[which[torn]]]
    image[torn] = projector.above(query[torn].view(np.float64).reshape(-1, 2), lines.layer[here])
    up[torn] = loop_of(lines, np.nan_to_num(image[torn]))
    bottom, top = lines.arc_start.take(up), lines.arc_start.take(up + 1)
    beyond = np.flatnonzero((image < bottom) | (image >= top))
    image[beyond] += np.where(image[beyond] < bottom[beyond], 1.0, -1.0) * (top - bottom)[beyond]
    stray = projector.loop.take(near, mode="clip") != up
    stray[beyond] = True
    amiss = np.flatnonzero(stray)
    near[amiss] = np.searchsorted(lines.arc, image[amiss], side="right") - 1
    return image, up, near
