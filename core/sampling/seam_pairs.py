"""Places on the contours and their images on the layer above, and where both lie in the waves between samples."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..contours.contours import Contours, loop_of
from ..model import BoolArray, FloatArray, IntArray
from ..parallel import product
from ..ragged import following, preceding, ranges
from ..records import dataclass
from .phase_grid import PhaseGrid
from .samples import Projector, Samples, squared
from .spacing import gaps

Singles = NDArray[np.float32]

# The error from which on a seam is seen.
VISIBLE = 0.5
HALF, FULL = np.float32(np.pi), np.float32(2 * np.pi)


@dataclass(frozen=True)
class Pairs:
    """P places in the first and their images in the second row, and how much a seam between the two matters.

    Attributes:
        before: (2, P) int64, the sample before each.
        along: (2, P) mm, how far it lies after where that sample was at first.
        importance: (P,) mm of contour.
    """

    before: IntArray
    along: Singles
    importance: Singles


class Waves:
    """Samples that move, on contours set apart so that none leaves its own."""

    def __init__(self, lines: Contours, samples: Samples) -> None:
        self.loop, self.start = samples.loop, samples.start
        self.length = lines.length
        self.arc_start = lines.arc_start
        self.arc = samples.arc
        self.first = self.place = samples.arc - lines.arc_start[samples.loop]
        self.ahead, self.behind = following(self.start), preceding(self.start)
        self.first_gap = self.gap().astype(np.float32)

    def gap(self) -> FloatArray:
        """(S,) mm from each sample to the next."""
        return gaps(self.place, self.start, self.length)

    def locate(self, arc: FloatArray, loop: IntArray) -> tuple[IntArray, FloatArray]:
        """The sample before each of places on contours at first, and how far these lie after it, mm.

        Places before a contour's first sample lie in its last wave, one turn farther on.
        """
        before = np.searchsorted(self.arc, arc, side="right") - 1
        wrapped = np.flatnonzero(before < self.start.take(loop))
        before[wrapped] = self.start[loop[wrapped] + 1] - 1
        along = arc - self.arc.take(before)
        along[wrapped] += self.length[loop[wrapped]]
        return before, along

    def seen(self, pairs: Pairs, exact: bool) -> float:
        """How many mm of the pairs are seen to be a seam, if not `exact` by their slide alone."""
        share, _ = self.shares(pairs)
        if exact:
            low, high = np.cos(FULL * share)
            return product(pairs.importance, (low - high) ** 2 >= VISIBLE)
        # The share of all phases at which 4 sin²(π slide) sin²(phase) is VISIBLE.
        sine, least = np.abs(np.sin(HALF * (share[0] - share[1]))), np.float32(np.sqrt(VISIBLE) / 2)
        some = np.flatnonzero(sine > least)
        return product(pairs.importance[some], np.arccos(least / sine[some])) / (np.pi / 2)

    def shares(self, pairs: Pairs) -> tuple[Singles, Singles]:
        """(2, P) how far each place lies on the way from the sample before to the next, and 1 by the mm between these.

        Where samples have moved past places since these were located, that is a little less than 0 or more than 1.
        """
        moved, inverse = (self.place - self.first).astype(np.float32), (1 / self.gap()).astype(np.float32)
        # Clipping, of which there is nothing to do, is quicker than checking.
        steep = inverse.take(pairs.before, mode="clip")
        share = pairs.along - moved.take(pairs.before, mode="clip")
        share *= steep
        return share, steep

    def relocate(self, pairs: Pairs) -> None:
        """Find the samples before all places anew, where samples have moved past these by less than a spacing."""
        share, before, along = (of.ravel() for of in (self.shares(pairs)[0], pairs.before, pairs.along))
        astray = np.flatnonzero((share < 0) | (share >= 1))
        old, early = before[astray], share[astray] < 0
        new = np.where(early, self.behind[old], self.ahead[old])
        along[astray] += np.where(early, self.first_gap[new], -self.first_gap[old])
        before[astray] = new


def near_seams(grid: PhaseGrid, waves: Waves, seam: float, around: int) -> tuple[BoolArray, IntArray]:
    """Which samples are near a seam, and the nodes on whose edges or their images are waves that they shape.

    Args:
        grid: of all layers.
        waves: the samples.
        seam: where the error is greater than this at some phase is a seam.
        around: how many samples on each side of a seam are near it.
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
    waves: Waves,
    node: IntArray,
    free: BoolArray,
    weight: FloatArray,
    apart: float,
) -> Pairs:
    """Places on the edges from nodes and their images among the samples, those that a free sample shapes.

    Args:
        projector: made for the contours.
        grid: of all layers.
        waves: the samples.
        node: (Q,) int64, the edges' first nodes.
        free: (S,) samples that may move.
        weight: (N,) how much a seam at each contour point matters.
        apart: distance of the places in points of the contours.
    """
    lines = projector.lines
    edge, point, query, arc = _places(projector, grid, node, apart)
    low, along = waves.locate(arc, grid.loop[edge])
    image, up = _images(projector, grid, edge, query, arc)
    found = np.flatnonzero(~np.isnan(image) & (np.diff(waves.start)[up] > 0))
    high, _ = waves.locate(image[found], up[found])
    shaped = free | free[waves.ahead]
    some = np.flatnonzero(shaped[low[found]] | shaped[high])
    found = found[some]
    # Between nodes the image is near the line between theirs.
    image, distance = projector.nearby(query[found], image[found])
    some = np.flatnonzero(distance <= projector.threshold)
    found = found[some]
    high, above = waves.locate(image[some], up[found])
    matters = weight.take(point[found]) * (apart * float(lines.arc_start[-1] / len(lines.arc)))
    after = np.stack([along[found], above]).astype(np.float32)
    return Pairs(np.stack([low[found], high]), after, matters.astype(np.float32))


def _places(
    projector: Projector, grid: PhaseGrid, node: IntArray, apart: float
) -> tuple[IntArray, IntArray, NDArray[np.complex128], FloatArray]:
    """Places on the edges from nodes: (P,) the edge of each, the contour point before, where it is, and its arc."""
    lines = projector.lines
    loop, first = grid.loop[node], np.searchsorted(lines.arc, grid.arc)
    last = np.where(grid.seam[node] > 0, lines.start[loop + 1], first[grid.ahead[node]])
    # How many places lie before each edge's beginning and before its end.
    begin, end = (np.ceil((point - lines.start[loop]) / apart).astype(np.int64) for point in (first[node], last))
    edge, place = np.repeat(node, end - begin), apart * ranges(begin, end - begin)
    point = place.astype(np.int64)
    place -= point
    point += lines.start.take(grid.loop.take(edge))
    away = projector.along.take(point) * place
    query, arc = projector.spot.take(point) + away, lines.arc.take(point) + np.sqrt(squared(away))
    return edge, point, query, arc


def _images(
    projector: Projector, grid: PhaseGrid, edge: IntArray, query: NDArray[np.complex128], arc: FloatArray
) -> tuple[FloatArray, IntArray]:
    """(P,) arcs of the images of places on the layer above, NaN where there is none, and (P,) their contours.

    They lie on the line between those of the edge's nodes; where these are torn apart, the place itself is projected.
    """
    lines = projector.lines
    image = grid.above[edge] + (arc - grid.arc[edge]) / grid.length[edge] * grid.step[edge]
    up = grid.loop.take(grid.low.take(edge))
    torn = np.flatnonzero(np.isnan(image))
    image[torn] = projector.above(query[torn].view(np.float64).reshape(-1, 2), lines.layer[grid.loop[edge[torn]]])
    up[torn] = loop_of(lines, np.nan_to_num(image[torn]))
    bottom, top = lines.arc_start.take(up), lines.arc_start.take(up + 1)
    image += (top - bottom) * ((image < bottom).astype(float) - (image >= top))
    return image, up
