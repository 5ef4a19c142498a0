"""A grid of places on the contours that carries the phase of the waves, linked from every layer to the next.

The optimized sampling (`optimized.py`) looks for the phase φ of the waves, a number that grows by 1 from sample to
sample, at a few places of each contour. Where a place lies on the layer above, as the paper projects it, is worked out
once. Wherever two neighboring places do not have neighboring images, the surface is *torn*: no seam can be seen there,
and the phases of the two sides need not fit.
"""

from __future__ import annotations

import numpy as np

from ..contours.contours import Contours
from ..lookup import Lookup
from ..model import BoolArray, FloatArray, IntArray
from ..ragged import following, preceding, ranges, starts
from ..records import dataclass


@dataclass(frozen=True)
class PhaseGrid:
    """K nodes on the contours that carry the pattern, in order of their arcs; edge i leads from node i to the next.

    Attributes:
        lines: the contours.
        point: (K,) int64, the contour point that each node is.
        arc: (K,) mm.
        start: (M + 1,) int64, where each contour's nodes start.
        loop: (K,) int64, the contour of each node.
        ahead: (K,) int64, the next node around the contour.
        behind: (K,) int64, the one before.
        length: (K,) mm, of each edge.
        closes: (K,) 1 where the edge closes the contour, leading back to its first node, else 0.
        step: (K,) mm, from a node's image to the next node's along the contour above; NaN where the edge is torn.
        above: (K,) mm, the arc of the node's image; NaN where there is none.
        low: (K,) int64, the node before the image, 0 where there is none.
        share: (K,) how far the image lies on the way from `low` to the next node.
        span: (K,) how many layers higher the image is; 1 where there is none.
        shortest: (K,) mm, the least of the lengths of each edge and of what leads to it on layers between those of the
            grid; its waves have to fit on all of them.
        longest: (K,) mm, the greatest of these.
        stands_for: (K,) how many layers each edge stands for, about.
        lookup: finds arcs among those of the nodes.
    """

    lines: Contours
    point: IntArray
    arc: FloatArray
    start: IntArray
    loop: IntArray
    ahead: IntArray
    behind: IntArray
    length: FloatArray
    closes: FloatArray
    step: FloatArray
    above: FloatArray
    low: IntArray
    share: FloatArray
    span: FloatArray
    shortest: FloatArray
    longest: FloatArray
    stands_for: FloatArray
    lookup: Lookup

    @property
    def linked(self) -> BoolArray:
        """(K,) which nodes have an image."""
        return ~np.isnan(self.above)

    def bounds(self, wavelength: float, margin: float) -> tuple[FloatArray, FloatArray]:
        """(K,) the least and the most waves on each edge, a share `margin` within the bounds on the spacing."""
        return self.longest / (2 * wavelength) * (1 + margin), self.shortest / wavelength * (1 - margin)

    def coarser(self, stride: int) -> PhaseGrid:
        """One in `stride` nodes of each contour, at least four, and all where a tear begins or ends."""
        torn = np.isnan(self.step)
        return self.picked(np.flatnonzero(self._regular(stride) | (torn != torn[self.behind])))

    def picked(self, node: IntArray) -> PhaseGrid:
        """Some of the nodes, among them the first of each contour; edges with a tear on the way are torn."""
        torn = np.isnan(self.step)
        bad = starts(torn.astype(np.int64))
        way = np.concatenate([[0.0], np.cumsum(np.nan_to_num(self.step))])
        loop = self.loop[node]
        begin = starts(np.bincount(loop, minlength=len(self.lines.layer)))
        ahead = following(begin)
        end = np.where(ahead > np.arange(len(node)), node[ahead], self.start[loop + 1])
        step = np.where(bad[end] == bad[node], way[end] - way[node], np.nan)
        return grid_of(self.lines, self.point[node], loop, self.above[node], step)

    def at(self, place: FloatArray) -> tuple[IntArray, FloatArray]:
        """The node before each place (Q,), on a contour with nodes, and the share of the way to the next one."""
        # A contour's first node is its first point, so that the node before a place is one of the same contour.
        node = self.lookup.before(place)
        return node, np.minimum((place - self.arc.take(node)) / self.length.take(node), 1.0)

    def raised(self, place: FloatArray, loop: IntArray, layers: int) -> tuple[FloatArray, IntArray]:
        """Places (Q,) on contours (Q,) carried up until they are on one of every `layers` layers, counted from the top.

        Returns:
            (Q,) arcs, NaN of what does not lead there, and (Q,) their contours.
        """
        passed = self.lines.below_top % layers > 0
        place, loop = place.copy(), loop.copy()
        for _ in range(layers):
            asked = np.flatnonzero(passed.take(loop) & ~np.isnan(place))
            if not len(asked):
                break
            place[asked], loop[asked] = self._images(place[asked])
        return place, loop

    def _images(self, place: FloatArray) -> tuple[FloatArray, IntArray]:
        """The images (Q,) of places (Q,), NaN where there is none, and the contours that they are on."""
        node, share = self.at(place)
        torn = np.isnan(self.step[node])
        nearer = np.where(share < 0.5, node, self.ahead[node])
        image = np.where(torn, self.above[nearer], self.above[node] + share * self.step[node])
        up = self.loop[self.low[np.where(torn, nearer, node)]]
        return brought_back(self.lines, image, up), up

    def spanning(self, layers: int, tear: float) -> PhaseGrid:
        """One in `layers` layers, counted from the top, linked to one another over those between them.

        Neighbors whose images lie `tear` mm farther apart than they do are torn.
        """
        fine = np.flatnonzero((self.lines.below_top % layers == 0)[self.loop])
        above, up = self.raised(self.above[fine], self.loop[self.low[fine]], layers)
        return linked_grid(self.lines, self.point[fine], self.loop[fine], above, up, tear)

    def next_among(self, node: IntArray) -> IntArray:
        """(Q,) which of some nodes (Q,), all of some contours, comes next around the contour."""
        number = np.empty(len(self.arc), dtype=np.int64)
        number[node] = np.arange(len(node))
        return np.asarray(number[self.ahead[node]])

    def every(self, stride: int) -> PhaseGrid:
        """One in `stride` nodes of each contour, at least four."""
        return self.picked(np.flatnonzero(self._regular(stride)))

    def _regular(self, stride: int) -> BoolArray:
        """(K,) one in `stride` nodes of each contour, at least four."""
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


def image_steps(
    lines: Contours, ahead: IntArray, length: FloatArray, above: FloatArray, up: IntArray, tear: float
) -> FloatArray:
    """Way from each image to the next along the contour above, the shorter way round; NaN where the surface is torn.

    Args:
        lines: the contours.
        ahead: (Q,) which place comes next around the contour.
        length: (Q,) mm, the way there.
        above: (Q,) arcs of the places' images on contours `up` (Q,), NaN where there is none.
        up: these; any where there is no image.
        tear: mm; neighbors whose images lie so much farther apart than they are torn.
    """
    step = above.take(ahead) - above
    around = lines.length.take(up)
    step -= around * np.rint(step / around)
    step[(up != up.take(ahead)) | (np.abs(step) > length + tear)] = np.nan
    return step


def linked_grid(
    lines: Contours, point: IntArray, loop: IntArray, above: FloatArray, up: IntArray, tear: float
) -> PhaseGrid:
    """As `grid_of`, of nodes (K,) with images on contours `up` (K,), torn where these are `tear` mm farther apart."""
    grid = grid_of(lines, point, loop, above, np.empty(len(point)))
    grid.step[:] = image_steps(lines, grid.ahead, grid.length, above, up, tear)
    return grid


def grid_of(lines: Contours, point: IntArray, loop: IntArray, above: FloatArray, step: FloatArray) -> PhaseGrid:
    """The grid of nodes at these contour points, with their contours, images and steps between images, all (K,)."""
    arc, size = lines.arc[point], len(point)
    start = starts(np.bincount(loop, minlength=len(lines.layer)))
    ahead, behind = following(start), preceding(start)
    length = lengths(lines, arc, loop, ahead)
    has = np.flatnonzero(~np.isnan(above))
    low, share, lookup = np.zeros(size, dtype=np.int64), np.zeros(size), Lookup(arc)
    grid = PhaseGrid(
        lines=lines,
        point=point,
        arc=arc,
        start=start,
        loop=loop,
        ahead=ahead,
        behind=behind,
        length=length,
        closes=(ahead <= np.arange(size)).astype(float),
        step=step,
        above=above,
        low=low,
        share=share,
        span=np.ones(size),
        shortest=length,
        longest=length,
        stands_for=np.ones(size),
        lookup=lookup,
    )
    low[has], share[has] = grid.at(above[has])
    grid.span[has] = (lines.layer[loop[low]] - lines.layer[loop])[has]
    return grid


def lengths(lines: Contours, arc: FloatArray, loop: IntArray, ahead: IntArray) -> FloatArray:
    """(K,) mm along the contour from each node to the next, 0 where it is the only one."""
    length = arc.take(ahead) - arc
    over = np.flatnonzero(length < 0)
    length[over] += lines.length[loop[over]]
    return length


def brought_back(lines: Contours, arc: FloatArray, loop: IntArray) -> FloatArray:
    """Arcs (Q,) that may lie beyond an end of their contours (Q,), brought back onto these."""
    length, local = lines.length.take(loop), arc - lines.arc_start.take(loop)
    return np.asarray(arc - length * np.floor(local / length))
