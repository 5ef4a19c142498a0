"""Whole numbers of waves: where waves begin and end, rounded from a plan of fractions, layer by layer from below.

Each layer takes its phase over from the layer below. What is carried along is the difference D between that phase and
the planned one. A whole number may be added to D anywhere, since a phase looks the same one wave farther on; so D is
made continuous along the contour. Where it still strays too far from its mean around the loop, that stretch is moved by
a whole wave: a wave begins at one end of the stretch and one ends at the other. If the loop does not close with the
planned number of waves, that number changes. A contour that would have too many or too few waves for the bounds on the
spacing loses or gets one where D then strays least. Smoothing D along the contour in each layer corresponds to the
relaxation of the paper.

The sum of all waves is steered to that of the plan, so that the mean spacing is the one asked for.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ..lookup import Lookup
from ..model import FloatArray, IntArray
from ..ragged import starts, sums
from .phase import Phase
from .phase_grid import PhaseGrid
from .wave_plan import WavePlan

# Least and greatest number of waves by which the phase may stray from the plan before one is added or dropped.
STRAYS = (0.55, 1.5)
# The stretch that is then changed reaches to where the phase strays by this share of that.
STRETCH = 0.5
# To steer the sum of the waves, the plan is tilted along each contour by at most this many waves each way, too few to
# add or drop one alone.
STEERED = 0.3
# What is in excess is to be made up for within 1 / HASTE of the waves that are left.
HASTE = 4.0
# How often in each layer D is smoothed, and how often stretches that stray are moved.
SMOOTHINGS, MENDINGS = 2, 2


def feasible_turns(grid: PhaseGrid, wavelength: float) -> tuple[FloatArray, FloatArray]:
    """(M,) fewest and (M,) most waves that fit on each contour, and on those that it stands for between the layers."""
    most = np.floor(sums(grid.shortest, grid.start) / wavelength + 1e-9)
    fewest = np.floor(sums(grid.longest, grid.start) / (2 * wavelength)) + 1
    # A short contour that is much longer or shorter than those between has at least the waves that it holds itself.
    return np.minimum(fewest, np.maximum(most, 2)), np.maximum(most, 2)


def rounded(grid: PhaseGrid, plan: WavePlan, stray: float, wavelength: float) -> Phase:
    """The phase with whole numbers of waves that follows a plan.

    Args:
        grid: K nodes on M contours.
        plan: waves and slides in fractions.
        stray: what share of the waves around a contour the phase may stray from it before one is added or dropped.
        wavelength: λ, mm.
    """
    work = _Rounding(grid, plan, stray, wavelength)
    for here, there in pairwise(work.cuts.tolist()):
        work.layer(*(slice(begin, end) for begin, end in zip(here, there, strict=True)))
    return Phase(work.planned_phase + work.difference, work.turns.astype(np.int64))


def _before(values: FloatArray) -> FloatArray:
    """The sum of all values before each."""
    return np.asarray(np.cumsum(values) - values)


class _HandedUp:
    """What each layer hands up to the next: E entries, one a linked node, sorted by their images on the contours above.

    Attributes:
        source: (E,) int64, the node below.
        phase: (E,) what its phase exceeds that of its image by, as planned.
        way: (E,) how far around its contour the image lies, from -1/2 to 1/2.
        contour: (C,) int64, the contours that get any.
        start: (C + 1,) int64, where each one's entries start.
        before: (K,) int64, the entry before each node around its contour; E on a contour that gets none.
        after: (K,) int64, the one after it.
        share: (K,) how far the node lies between them.
        wrap: (K,) what the contour has more than planned comes on top by this share, where its beginning is between.
    """

    def __init__(self, grid: PhaseGrid, plan: WavePlan, planned_phase: FloatArray, total: FloatArray) -> None:
        # One coordinate for all contours, in which they lie one after the other with room between them.
        offset = _before(total) + 2.0 * np.arange(len(total))
        source = np.flatnonzero(grid.linked)
        low = grid.low[source]
        target = grid.loop[low]
        above = planned_phase[low] + grid.share[source] * plan.waves[low]
        place = offset[target] + above
        order = np.argsort(place, kind="stable")
        target, place, above = target[order], place[order], above[order]
        self.source = source[order]
        self.phase = planned_phase[self.source] + plan.slide[self.source] - above
        self.way = above / np.maximum(total, 1e-9)[target] - 0.5
        first = starts(np.bincount(target, minlength=len(total)))
        self.contour = np.flatnonzero(np.diff(first))
        self.start = np.append(first[self.contour], len(target))
        self._between(grid, offset[grid.loop] + planned_phase, place, first, total[grid.loop])

    def _between(
        self, grid: PhaseGrid, where: FloatArray, place: FloatArray, first: IntArray, total: FloatArray
    ) -> None:
        """Find the nodes among the entries."""
        begin, end = first[grid.loop], first[grid.loop + 1] - 1
        known = np.flatnonzero(begin <= end)
        self.before, self.after = np.full((2, len(where)), len(place))
        self.share, self.wrap = np.zeros((2, len(where)))
        begin, end, total, where = begin[known], end[known], total[known], where[known]
        after = Lookup(place).before(where) + 1
        early, late = after <= begin, after > end
        self.before[known] = before = np.where(early, end, after - 1)
        self.after[known] = after = np.where(late, begin, after)
        low = place[before] - early * total
        gap = place[after] + late * total - low
        self.share[known] = share = np.clip((where - low) / np.maximum(gap, 1e-9), 0.0, 1.0)
        self.wrap[known] = share * late - (1 - share) * early


class _Rounding:
    """The state of the sweep: what is known of all layers up to the present one. D is told at the top of this file.

    A layer has few nodes, so that what can be found for all layers at once is, and the rest takes as few calls as can
    be.

    Attributes:
        planned_phase: (K,) at each node, from 0 at the first one of its contour.
        total: (M,) planned waves of each contour, a fraction.
        difference: (K,) D at each node.
        handed: E entries, what each layer hands up.
        carried: (E + 1,) D at each entry; 0 at the last, which stands for none.
        turns: (M,) whole number of waves of each contour.
        excess: waves that the layers up to the present one have more than planned.
        cuts: where each layer begins among contours, nodes, contours that get something, and entries.
    """

    def __init__(self, grid: PhaseGrid, plan: WavePlan, stray: float, wavelength: float) -> None:
        self.total = sums(plan.waves, grid.start)
        self.planned_phase = _before(plan.waves) - _before(self.total)[grid.loop]
        way = self.planned_phase / np.maximum(self.total, 1e-9)[grid.loop]
        self.handed = handed = _HandedUp(grid, plan, self.planned_phase, self.total)
        self.difference, self.carried = np.zeros(len(grid.arc)), np.zeros(len(handed.source) + 1)
        fewest, most = feasible_turns(grid, wavelength)
        self.turns = np.clip(np.rint(self.total), fewest, most) * (np.diff(grid.start) > 0)
        self.stands_for = sums(grid.stands_for, grid.start) / np.maximum(np.diff(grid.start), 1)
        # What one wave in excess tilts the plan by on each contour and those above it.
        planned = self.stands_for * self.total
        self.haste = HASTE / np.maximum(planned.sum() - _before(planned), 1.0)
        self.excess = 0.0
        # Where each layer's contours begin, their nodes, those of them that get something, and what they get.
        layer = grid.lines.layer
        loops = np.searchsorted(layer, np.arange(int(layer.max(initial=-1)) + 2))
        known = np.searchsorted(handed.contour, loops)
        cuts = np.stack([loops, grid.start[loops], known, handed.start[known]], axis=1)
        self.cuts = cuts = cuts[np.append(True, np.diff(cuts[:, 1]) > 0)] if len(cuts) else cuts
        # Of the contours that get something from below, of what they get, and of the nodes; counted within the layer.
        self.planned_turns, self.fewest, self.most = (of[handed.contour] for of in (self.total, fewest, most))
        count = np.diff(handed.start)
        loop_cut, node_cut, known_cut, entry_cut = cuts[:-1].T
        many = np.diff(cuts, axis=0)
        self.first = handed.start[:-1] - np.repeat(entry_cut, many[:, 2])
        self.last = self.first + count - 1
        self.count = count
        owner = np.repeat(np.arange(len(count)), count)
        self.owner = owner - np.repeat(known_cut, many[:, 3])
        self.stray = np.clip(stray * self.planned_turns, *STRAYS)[owner]
        self.tilt = self.planned_turns[owner] * handed.way
        self.loop = grid.loop - np.repeat(loop_cut, many[:, 1])
        self.ahead, self.behind = (of - np.repeat(node_cut, many[:, 1]) for of in (grid.ahead, grid.behind))
        self.way, self.over = way, handed.wrap - way * (handed.before < len(handed.source))

    def layer(self, loops: slice, nodes: slice, known: slice, entries: slice) -> None:
        """Fix the phase on the contours of one layer, some of which are `known` to get something from below."""
        handed = self.handed
        if known.start < known.stop:
            self._carry(loops.start, known, entries)
        more = self.turns[loops] - self.total[loops]
        self.excess += float(self.stands_for[loops] @ more)
        more = more.take(self.loop[nodes])
        difference = self.carried.take(handed.before[nodes])
        rise = self.carried.take(handed.after[nodes])
        rise -= difference
        rise *= handed.share[nodes]
        difference += rise
        difference += self.over[nodes] * more
        ahead, behind = self.ahead[nodes], self.behind[nodes]
        # The weights (1, 2, 1) / 4 of a node and its neighbors.
        for _ in range(SMOOTHINGS):
            difference += difference.take(ahead)
            difference += difference.take(behind)
        difference *= 0.25**SMOOTHINGS
        more *= self.way[nodes]
        difference += more
        self.difference[nodes] = difference

    def _carry(self, loop: int, known: slice, entries: slice) -> None:
        """Take D over from below; fixes the number of waves of the `known` contours."""
        handed, first, owner = self.handed, self.first[known], self.owner[entries]
        carried = self.difference.take(handed.source[entries])
        carried += handed.phase[entries]
        walk = np.empty(len(carried))
        np.subtract(carried[1:], carried[:-1], out=walk[1:])
        walk[first] = 0.0
        walk -= np.rint(walk)
        walk = walk.cumsum()
        mean = np.add.reduceat(walk, first)
        mean /= self.count[known]
        # The plan's number of waves is met in the end: what came in excess is made up for in the layers to come.
        tilt = self.tilt[entries] * (self.excess * self.haste[loop])
        stray = np.minimum(np.maximum(tilt, -STEERED, out=tilt), STEERED, out=tilt)
        stray += walk
        stray -= mean.take(owner)
        begin = carried.take(first)
        begin -= np.rint(begin)
        begin -= walk.take(first)
        _mend(walk, stray, first, self.stray[entries])
        turns = walk.take(self.last[known])
        turns -= walk.take(first)
        turns += self.planned_turns[known]
        turns = np.rint(turns)
        held = np.minimum(np.maximum(turns, self.fewest[known]), self.most[known])
        for this in (held != turns).nonzero()[0]:
            part = slice(first[this], first[this] + self.count[known][this])
            for _ in range(int(abs(held[this] - turns[this]))):
                walk[part] += _step_for(walk[part], np.sign(held[this] - turns[this]))
        self.turns[handed.contour[known]] = held
        walk += begin.take(owner)
        self.carried[entries] = walk


def _mend(walk: FloatArray, stray: FloatArray, first: IntArray, most: FloatArray) -> None:
    """Add whole waves to or take them from `walk` where it strays by more than `most` from its mean; changes `stray`.

    Args:
        walk: (E,) D, continuous along each contour.
        stray: (E,) from its mean.
        first: where each contour's entries begin.
        most: (E,) by how much it may.
    """
    for _ in range(MENDINGS):
        away = np.abs(stray)
        over = away - most
        if np.maximum.reduce(over) <= 0:
            break
        side = np.sign(stray)
        side *= away > STRETCH * most
        begins = np.empty(len(stray), dtype=bool)
        np.not_equal(side[1:], side[:-1], out=begins[1:])
        begins[first] = True
        far = np.maximum.reduceat(over, begins.nonzero()[0]) > 0
        side *= far.take(begins.cumsum() - 1)
        stray -= side
        walk -= side


def _step_for(stray: FloatArray, step: float) -> FloatArray:
    """A step up or down by one wave where the phase strays least from its mean with it."""
    size = len(stray)
    tail = step * np.cumsum(stray[::-1])[::-1]
    many = np.arange(size, 0, -1)
    # What the step adds to the sum of squares around the mean, by where it comes.
    cost = 2 * tail + many - (tail[0] + many) ** 2 / size
    place = 1 + int(np.argmin(cost[1:])) if size > 1 else 0
    return step * (np.arange(size) >= place)
