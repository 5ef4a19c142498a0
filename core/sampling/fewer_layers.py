"""A phase grid of every few layers, and the phase of the waves on the layers between.

The phase hardly changes from one layer to the next, so the optimized sampling looks for it on every few layers only. On
the layers between it follows from that of the layer above, and the sliding is shared evenly by the layers that it goes
through. A contour between them is kept in the grid as well if some of its nodes do not lead up to one of these layers,
or if its length changes too fast on the way.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..lookup import Lookup
from ..model import BoolArray, FloatArray, IntArray
from ..ragged import sums
from ..records import dataclass
from .phase import Phase
from .phase_grid import PhaseGrid, image_steps, linked_grid

# A contour is kept in the grid if its image on the layer above is longer or shorter than itself by this share.
STEEP = 0.3
# An edge between the layers counts as no shorter than this share of the edge that it leads to, and no longer than the
# inverse of it.
LEAST_RATIO = 0.75
# An edge whose image is shorter than this share of its own length tells nothing of the waves on it.
SHRUNK = 0.3
# The surface is torn between two nodes if the phase would rise there by more than this many times the usual waves.
MOST_RISE = 3


@dataclass(frozen=True)
class FewerLayers:
    """A grid of all layers and one of fewer.

    Attributes:
        all: K nodes.
        few: those of them on contours that are kept.
        kept: (K,) which these are.
        place: (K,) mm, where the others lie on contours that are kept: the arcs of their images.
        loop: (K,) int64, those contours.
    """

    all: PhaseGrid
    few: PhaseGrid
    kept: BoolArray
    place: FloatArray
    loop: IntArray

    def everywhere(self, phase: Phase) -> Phase:
        """The phase on all layers, from that on the grid of fewer."""
        grid, few, lines = self.all, self.few, self.all.lines
        node = np.flatnonzero(~self.kept)
        low, share = few.at(self.place[node])
        up = np.full(len(grid.arc), -1)
        high, slid = np.zeros(len(grid.arc)), np.zeros(len(grid.arc))
        up[node] = few.loop[low]
        high[node] = phase.at(low, share, few)
        slid[node] = self._slides(phase, self.place[node], up[node]) * (
            lines.layer[up[node]] - lines.layer[grid.loop[node]]
        )
        # The rise between two nodes is that between their images where these are on one contour; else the usual one.
        way = np.where(self.kept, 0.0, self.place)
        way = way[grid.ahead] - way
        over = np.rint(way / lines.length[up])
        expected = high[grid.ahead] - high - over * phase.turns[up] - slid[grid.ahead] + slid
        usual = grid.length * (phase.turns.sum() / few.length.sum())
        whole = (up == up[grid.ahead]) & (expected > 0) & (expected < MOST_RISE * usual + 1)
        value = high - slid
        rise = value[grid.ahead] - value
        rise -= np.rint(rise - np.where(whole, expected, usual))
        rise[self.kept] = phase.waves(few)
        value[self.kept] = phase.value
        climbed = np.cumsum(rise) - rise
        first = grid.start[grid.loop]
        turns = np.rint(sums(rise, grid.start)).astype(np.int64)
        return Phase(value[first] + climbed - climbed[first], turns)

    def _slides(self, phase: Phase, place: FloatArray, loop: IntArray) -> FloatArray:
        """(Q,) by how much the waves slide in each layer just below places on contours (Q,) that are kept."""
        few = self.few
        source = np.flatnonzero(few.linked)
        source = source[np.argsort(few.above[source], kind="stable")]
        if not len(source):
            return np.zeros(len(place))
        slide = phase.at(few.low[source], few.share[source], few) - phase.value[source]
        slide = (slide - np.rint(slide)) / few.span[source]
        arrival, arrived = few.above[source], few.loop[few.low[source]]
        after = Lookup(arrival).before(place) + 1
        before, after = np.maximum(after - 1, 0), np.minimum(after, len(source) - 1)
        from_before, from_after = arrived[before] == loop, arrived[after] == loop
        share = np.clip((place - arrival[before]) / np.maximum(arrival[after] - arrival[before], 1e-9), 0.0, 1.0)
        share = np.where(from_before, np.where(from_after, share, 0.0), 1.0)
        mixed = slide[before] * (1 - share) + slide[after] * share
        return np.where(from_before | from_after, mixed, 0.0)


def fewer_layers(grid: PhaseGrid, layers: int, tear: float) -> FewerLayers:
    """Keep one layer in `layers`, counted from the top; neighbors whose images lie `tear` mm farther apart are torn."""
    below = grid.lines.below_top
    kept = below % layers == 0
    place, up = grid.above.copy(), grid.loop[grid.low]
    onto = up.copy()
    for number in range(1, layers + 1):
        node = np.flatnonzero((below % layers == number % layers)[grid.loop])
        onward = node[grid.linked[node] & ~kept[up[node]]]
        place[onward], onto[onward] = _through(grid, place, onto, onward, tear)
        if number < layers:
            kept[_lost(grid, node, place[node], onto[node], tear)] = True
    stay = kept[grid.loop]
    node = np.flatnonzero(stay)
    few = linked_grid(grid.lines, grid.point[node], grid.loop[node], place[node], onto[node], tear)
    return FewerLayers(grid, _with_extremes(grid, few, stay, place, onto, tear), stay, place, onto)


def _through(
    grid: PhaseGrid, place: FloatArray, onto: IntArray, node: IntArray, tear: float
) -> tuple[FloatArray, IntArray]:
    """Where nodes arrive, and on which contours, if what is above them arrives at `place` (K,) on contours `onto`."""
    lines, low, share = grid.lines, grid.low[node], grid.share[node]
    ahead = grid.ahead[low]
    begin, end, loop = place[low], place[ahead], onto[low]
    length, first = lines.length[loop], lines.arc_start[loop]
    step = end - begin
    step -= length * np.rint(step / length)
    whole = (np.abs(step) <= grid.length[low] + tear) & (loop == onto[ahead])
    onward = first + np.mod(begin + share * step - first, length)
    nearer = share < 0.5
    return (
        np.where(whole, onward, np.where(nearer, begin, end)),
        np.where(whole | nearer, loop, onto[ahead]),
    )


def _lost(grid: PhaseGrid, node: IntArray, place: FloatArray, onto: IntArray, tear: float) -> IntArray:
    """The contours of nodes of which some arrive at no `place` (Q,), or whose length changes fast on the way."""
    loop, size = grid.loop[node], len(grid.lines.layer)
    step = np.abs(image_steps(grid.lines, grid.next_among(node), grid.length[node], place, onto, tear))
    missing = np.bincount(loop, np.isnan(place), size) > 0
    length = np.bincount(loop, np.where(np.isnan(step), 0.0, grid.length[node]), size)
    change = np.bincount(loop, np.nan_to_num(step), size) - length
    return np.flatnonzero(missing | (np.abs(change) > STEEP * length))


def _with_extremes(
    grid: PhaseGrid, few: PhaseGrid, kept: BoolArray, place: FloatArray, onto: IntArray, tear: float
) -> PhaseGrid:
    """The grid of fewer layers with what its edges have to hold on the layers between, too."""
    node = np.flatnonzero(~kept)
    step = np.abs(image_steps(grid.lines, grid.next_among(node), grid.length[node], place[node], onto[node], tear))
    some = np.flatnonzero(step > SHRUNK * grid.length[node])
    ratio = grid.length[node[some]] / step[some]
    low = few.lookup.before(place[node[some]])
    shortest, longest = np.ones(len(few.arc)), np.ones(len(few.arc))
    less = ratio < 1
    np.minimum.at(shortest, low[less], ratio[less])
    np.maximum.at(longest, low[~less], ratio[~less])
    many = 1.0 + np.bincount(low, minlength=len(few.arc))
    shortest = few.length * np.maximum(shortest, LEAST_RATIO)
    longest = few.length * np.minimum(longest, 1 / LEAST_RATIO)
    return replace(few, shortest=shortest, longest=longest, stands_for=many)
