"""A grid of places on the contours that carries the phase of the waves, linked from every layer to the next.

The optimized sampling (`optimized.py`) looks for the phase φ of the waves, a number that grows by 1 from sample to
sample, at a few places of each contour. Where a place lies on the layer above, as the paper projects it, is worked out
once; wherever two neighboring places do not have neighboring images the surface is *torn* there: no seam can be seen,
and the phases of the two sides owe each other nothing.
"""

from __future__ import annotations

import numpy as np

from ..contours.contours import Contours, long_enough, loop_of
from ..model import BoolArray, FloatArray, IntArray
from ..ragged import following, preceding, ranges, starts
from ..records import dataclass
from ..settings import PrintSettings
from .samples import Projector

# Every so many contour points are projected as a rule, at least so many of each contour. One of so many points is
# searched on the whole layer above, at least so many of a contour, but no more than every other of these; the others
# are looked for near where their neighbors' images are.
STATION_STRIDE, LEAST_NODES = 3, 8
SEARCHED, LEAST_SEARCHED = 96, 4
# Neighbors whose images lie farther apart than their own distance and this share of the wavelength are torn.
TEAR = 1.0
# So many times as many points are projected between torn neighbors.
FINER = 4


@dataclass(frozen=True)
class PhaseGrid:
    """K nodes on the contours that carry the pattern, in order of their arcs; edge i leads from node i to the next.

    Attributes:
        arc: (K,) mm.
        start: (M + 1,) int64, where each contour's nodes start.
        loop: (K,) int64, the contour of each node.
        ahead: (K,) int64, the next node around the contour.
        behind: (K,) int64, the one before.
        length: (K,) mm, of each edge.
        seam: (K,) 1 where the edge leads over the contour's beginning, else 0.
        step: (K,) mm, from a node's image to the next node's along the contour above; NaN where the edge is torn.
        above: (K,) mm, the arc of the node's image; NaN where there is none.
        low: (K,) int64, the node before the image, 0 where there is none.
        share: (K,) how far the image lies on the way from `low` to the next node.
        span: (K,) how many layers higher the image is; 1 where there is none.
        shortest: (K,) mm, the least length of each edge and of what leads to it between the layers of the grid.
        longest: (K,) mm, the greatest.
        stands_for: (K,) on about how many layers each edge's waves are.
    """

    arc: FloatArray
    start: IntArray
    loop: IntArray
    ahead: IntArray
    behind: IntArray
    length: FloatArray
    seam: FloatArray
    step: FloatArray
    above: FloatArray
    low: IntArray
    share: FloatArray
    span: FloatArray
    shortest: FloatArray
    longest: FloatArray
    stands_for: FloatArray

    @property
    def linked(self) -> BoolArray:
        """(K,) which nodes have an image."""
        return ~np.isnan(self.above)

    def bounds(self, wavelength: float, margin: float) -> tuple[FloatArray, FloatArray]:
        """(K,) the least and the most waves on each edge, a share `margin` within the bounds on the spacing."""
        return self.longest / (2 * wavelength) * (1 + margin), self.shortest / wavelength * (1 - margin)

    def coarser(self, lines: Contours, stride: int) -> PhaseGrid:
        """Every so many nodes of each contour, at least four, and all where a tear begins or ends."""
        torn = np.isnan(self.step)
        return self.picked(lines, np.flatnonzero(self._regular(stride) | (torn != torn[self.behind])))

    def picked(self, lines: Contours, node: IntArray) -> PhaseGrid:
        """Some of the nodes, among them the first of each contour; edges with a tear on the way are torn."""
        torn = np.isnan(self.step)
        bad = starts(torn.astype(np.int64))
        way = np.concatenate([[0.0], np.cumsum(np.nan_to_num(self.step))])
        loop = self.loop[node]
        begin = starts(np.bincount(loop, minlength=len(lines.layer)))
        ahead = following(begin)
        end = np.where(ahead > np.arange(len(node)), node[ahead], self.start[loop + 1])
        step = np.where(bad[end] == bad[node], way[end] - way[node], np.nan)
        return grid_of(lines, self.arc[node], loop, self.above[node], step)

    def carried(self, lines: Contours, place: FloatArray, asked: BoolArray) -> FloatArray:
        """The images (Q,) of places (Q,), which may be NaN; those not `asked` (Q,) stay where they are."""
        out = place.copy()
        known = np.flatnonzero(asked & ~np.isnan(place))
        node, share = between(self.arc, self.length, place[known])
        torn = np.isnan(self.step[node])
        nearer = np.where(share < 0.5, node, self.ahead[node])
        image = np.where(torn, self.above[nearer], self.above[node] + share * self.step[node])
        up = self.loop[self.low[np.where(torn, nearer, node)]]
        out[known] = _around(lines, image, up)
        return out

    def spanning(self, lines: Contours, layers: int, spanned: int, tear: float) -> PhaseGrid:
        """Only every so many layers, counted from the top, linked to one another over those between them.

        This grid has every `spanned` layers itself, of which `layers` is a multiple. Neighbors whose images lie `tear`
        mm farther apart than they do are torn.
        """
        below = int(lines.layer.max(initial=0)) - lines.layer[self.loop]
        fine = np.flatnonzero(below % layers == 0)
        above = self.above[fine]
        for _ in range(layers // spanned - 1):
            above = self.carried(lines, above, np.ones(len(fine), dtype=bool))
        arc, loop = self.arc[fine], self.loop[fine]
        step = image_steps(lines, arc, loop, above, tear)
        return grid_of(lines, arc, loop, above, step)

    def every(self, lines: Contours, stride: int) -> PhaseGrid:
        """Only every so many nodes of each contour, at least four."""
        return self.picked(lines, np.flatnonzero(self._regular(stride)))

    def _regular(self, stride: int) -> BoolArray:
        """(K,) every so many nodes of each contour, at least four."""
        local = np.arange(len(self.arc)) - self.start[self.loop]
        every = np.minimum(stride, np.maximum(np.diff(self.start) // 4, 1))[self.loop]
        return np.asarray(local % every == 0)

    def rows(self) -> tuple[IntArray, IntArray, IntArray, FloatArray]:
        """What lies above each edge that is not torn, as weighted edges of the contour above.

        Returns:
            (C,) the edges; (C + 1,) where the entries of each start; (E,) the edges above; (E,) their weights.
        """
        cell = np.flatnonzero(~np.isnan(self.step))
        count = np.diff(self.start)
        up = self.loop[self.low[cell]]
        first = self.start[up]
        backwards = self.step[cell] < 0
        # The image of an edge begins at the image of the node that comes first on the contour above.
        begin = np.where(backwards, self.ahead[cell], cell)
        node, share = self.low[begin] - first, self.share[begin]
        other = np.where(backwards, cell, self.ahead[cell])
        end, end_share = self.low[other] - first, self.share[other]
        wraps = ((end < node) | ((end == node) & (end_share < share))) & (np.abs(self.step[cell]) > 1e-6)
        # Two images in one place may come in either order by rounding.
        same = ~wraps & ((end < node) | ((end == node) & (end_share < share)))
        end, end_share = np.where(same, node, end), np.where(same, share, end_share)
        entries = end + np.where(wraps, count[up], 0) - node + 1
        start = starts(entries)
        owner = np.repeat(np.arange(len(cell)), entries)
        weight = np.ones(start[-1])
        weight[start[:-1]] -= share
        weight[start[1:] - 1] -= 1 - end_share
        edge = first[owner] + ranges(node, entries) % np.maximum(count[up], 1)[owner]
        return cell, start, edge, weight * np.where(backwards, -1.0, 1.0)[owner]


def phase_grid(
    lines: Contours, projector: Projector, settings: PrintSettings, stride: int = STATION_STRIDE
) -> PhaseGrid:
    """A grid with a node every so many contour points, and closer ones where the surface is torn."""
    usable = long_enough(lines.length, settings)
    every = _strides(lines, stride)
    many = np.where(usable, -(-np.diff(lines.start) // every), 0)
    loop, rank = np.repeat(np.arange(len(many)), many), ranges(np.zeros(len(many), dtype=np.int64), many)
    node = lines.start[loop] + rank * every[loop]
    tear = TEAR * settings.wavelength
    searched = rank % np.clip(many // LEAST_SEARCHED, 2, SEARCHED // every)[loop] == 0
    above = _followed_images(lines, projector, node, searched, usable, tear)
    torn = np.flatnonzero(np.isnan(image_steps(lines, lines.arc[node], loop, above, tear)))
    ahead = following(starts(many))[torn]
    length = np.where(ahead > torn, node[ahead], lines.start[loop[torn] + 1]) - node[torn]
    step = max(stride // FINER, 1)
    many = (length - 1) // step
    between = np.repeat(node[torn], many) + ranges(np.ones(len(torn), dtype=np.int64), many) * step
    node, above = np.append(node, between), np.append(above, _images(lines, projector, between, usable))
    order = np.argsort(node, kind="stable")
    node, above = node[order], above[order]
    arc, loop = lines.arc[node], projector.loop[node]
    return grid_of(lines, arc, loop, above, image_steps(lines, arc, loop, above, tear))


def _strides(lines: Contours, stride: int) -> IntArray:
    """(M,) contour points from node to node."""
    return np.minimum(stride, np.maximum(np.diff(lines.start) // LEAST_NODES, 1))


def _followed_images(
    lines: Contours, projector: Projector, node: IntArray, searched: BoolArray, usable: BoolArray, tear: float
) -> FloatArray:
    """Images of contour points, of which some, the first of each contour among them, are searched on the whole layer.

    Where neighbors of these have neighboring images, those of the points between them lie near the line between.
    """
    above = np.full(len(node), np.nan)
    above[searched] = image = _images(lines, projector, node[searched], usable)
    arc, loop = lines.arc[node[searched]], projector.loop[node[searched]]
    step = image_steps(lines, arc, loop, image, tear)
    ahead = following(starts(np.bincount(loop, minlength=len(lines.layer))))
    length = _lengths(lines, arc, loop, ahead)
    owner = np.cumsum(searched) - 1
    smooth = (~np.isnan(step) & (length > 0))[owner]
    near = np.flatnonzero(~searched & smooth)
    at, owner = node[near], owner[near]
    up = loop_of(lines, image[owner])
    guess = _around(lines, image[owner] + (step / length)[owner] * (lines.arc[at] - arc[owner]), up)
    place, distance = projector.nearby(projector.spot[at], guess)
    above[near] = np.where(distance <= projector.threshold, place, np.nan)
    others = np.flatnonzero(~searched & np.isnan(above))
    above[others] = _images(lines, projector, node[others], usable)
    return above


def _images(lines: Contours, projector: Projector, point: IntArray, usable: BoolArray) -> FloatArray:
    """Arcs of the images of contour points on the layer above; NaN where none is near enough or carries the pattern."""
    above = projector.above(lines.points[point], lines.layer[projector.loop[point]])
    found = np.flatnonzero(~np.isnan(above))
    above[found[~usable[loop_of(lines, above[found])]]] = np.nan
    return above


def image_steps(lines: Contours, arc: FloatArray, loop: IntArray, above: FloatArray, tear: float) -> FloatArray:
    """Way from each image to the next along the contour above, the shorter way round; NaN where the surface is torn."""
    ahead = following(starts(np.bincount(loop, minlength=len(lines.layer))))
    has = ~np.isnan(above)
    up = np.where(has, loop_of(lines, np.where(has, above, 0.0)), -1)
    around = np.where(has, lines.length[up], 1.0)
    step = above[ahead] - above
    step -= around * np.rint(step / around)
    own = _lengths(lines, arc, loop, ahead)
    return np.where((up >= 0) & (up == up[ahead]) & (np.abs(step) <= own + tear), step, np.nan)


def grid_of(lines: Contours, arc: FloatArray, loop: IntArray, above: FloatArray, step: FloatArray) -> PhaseGrid:
    """The grid of nodes with these arcs, contours, images and steps between images, all (K,)."""
    start = starts(np.bincount(loop, minlength=len(lines.layer)))
    ahead, behind = following(start), preceding(start)
    length = _lengths(lines, arc, loop, ahead)
    has = ~np.isnan(above)
    low, share = between(arc, length, above[has])
    full_low, full_share = np.zeros(len(arc), dtype=np.int64), np.zeros(len(arc))
    full_low[has], full_share[has] = low, share
    return PhaseGrid(
        arc=arc,
        start=start,
        loop=loop,
        ahead=ahead,
        behind=behind,
        length=length,
        seam=(ahead <= np.arange(len(arc))).astype(float),
        step=step,
        above=above,
        low=full_low,
        share=full_share,
        span=np.where(has, lines.layer[loop[full_low]] - lines.layer[loop], 1.0),
        shortest=length,
        longest=length,
        stands_for=np.ones(len(arc)),
    )


def between(arc: FloatArray, length: FloatArray, place: FloatArray) -> tuple[IntArray, FloatArray]:
    """The node before each place, on a contour with nodes, and the share of the way to the next one."""
    # A contour's first node is its first point, so that the node before a place is one of the same contour.
    node = np.searchsorted(arc, place, side="right") - 1
    return node, np.minimum((place - arc.take(node)) / length.take(node), 1.0)


def on_grid(grid: PhaseGrid, finer: PhaseGrid) -> tuple[IntArray, FloatArray]:
    """Where the nodes of a finer grid lie on this one: the node before each, and the share of the way to the next."""
    return between(grid.arc, grid.length, finer.arc)


def _lengths(lines: Contours, arc: FloatArray, loop: IntArray, ahead: IntArray) -> FloatArray:
    """(K,) mm along the contour from each node to the next, 0 where it is the only one."""
    length = arc[ahead] - arc
    over = np.flatnonzero(length < 0)
    length[over] += lines.length[loop[over]]
    return length


def _around(lines: Contours, arc: FloatArray, loop: IntArray) -> FloatArray:
    """Arcs (Q,) that may lie beyond an end of their contours (Q,), brought back onto these."""
    length, local = lines.length.take(loop), arc - lines.arc_start.take(loop)
    return np.asarray(arc - length * np.floor(local / length))
