"""Whole numbers of waves: where waves begin and end, rounded from a plan of fractions, layer by layer from below.

What the layer below hands up is the phase itself; what it lacks against the plan, D, is carried along. D is free up to
a whole number everywhere. It is taken as continuous along the contour, and where it strays from its mean around the
loop by more than `STRAY` of a wave, a wave begins at one end of that stretch and one ends at the other; where the two
ends are one and the same, around the loop, its number of waves changes. Smoothing D along the contour in each layer is
the relaxation of the paper.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..settings import PrintSettings
from ..slicing.outlines import sums
from .contours import Contours
from .phase_grid import PhaseGrid
from .wave_plan import WavePlan

# Waves by which the phase may stray from the plan before a wave is added or dropped, and where the stretch ends.
STRAY, STRETCH = 1.0, 0.5
# The phase's difference from the plan is smoothed so often in each layer, and may be mended so often.
SMOOTHINGS = 4
MENDINGS = 3


@dataclass(frozen=True)
class Phase:
    """The phase of the waves on a grid: samples sit where it is whole.

    Attributes:
        value: (K,) at each node, counting on around its contour from the first node.
        turns: (M,) int64, waves around each contour.
    """

    value: FloatArray
    turns: IntArray

    def waves(self, grid: PhaseGrid) -> FloatArray:
        """(K,) waves on the edge from each node to the next."""
        return np.asarray(self.value[grid.ahead] - self.value + grid.seam * self.turns[grid.loop])

    def at(self, node: IntArray, share: FloatArray, grid: PhaseGrid) -> FloatArray:
        """The phase on the way from nodes to the next ones."""
        ahead = self.value[grid.ahead[node]] + grid.seam[node] * self.turns[grid.loop[node]]
        return np.asarray(self.value[node] * (1 - share) + ahead * share)


def feasible_turns(lines: Contours, settings: PrintSettings) -> tuple[FloatArray, FloatArray]:
    """(M,) fewest and (M,) most waves that each contour holds with a spacing in [λ, 2λ)."""
    most = np.floor(lines.length / settings.wavelength + 1e-9)
    return np.floor(lines.length / (2 * settings.wavelength)) + 1, most


def rounded(lines: Contours, grid: PhaseGrid, plan: WavePlan, settings: PrintSettings) -> Phase:
    """The phase with whole numbers of waves that follows a plan.

    Args:
        lines: M contours.
        grid: K nodes on them.
        plan: waves and slides in fractions.
        settings: the wavelength is used.
    """
    work = _Rounding(lines, grid, plan, settings)
    layer = lines.layer[grid.loop]
    cuts = np.searchsorted(layer, np.arange(int(lines.layer.max(initial=-1)) + 2))
    for this in range(len(cuts) - 1):
        work.layer(cuts[max(this - 1, 0)], cuts[this], cuts[this + 1])
    return Phase(work.plain + work.lack, work.turns.astype(np.int64))


class _Rounding:
    """The state of the sweep: what is known of all layers up to the present one."""

    def __init__(self, lines: Contours, grid: PhaseGrid, plan: WavePlan, settings: PrintSettings) -> None:
        self.grid = grid
        self.fewest, self.most = feasible_turns(lines, settings)
        self.total = sums(plan.waves, grid.start)
        counted = np.cumsum(plan.waves) - plan.waves
        first = np.minimum(grid.start[:-1], max(len(counted) - 1, 0))
        base = counted[first] if len(counted) else np.zeros(len(self.total))
        self.plain = counted - base[grid.loop]
        # One coordinate for all contours, in which those of a layer lie one after the other with room between them.
        self.offset = base + 2.0 * np.arange(len(base))
        self.above = self.plain[grid.low] + grid.share * plan.waves[grid.low]
        self.place = self.offset[grid.loop[grid.low]] + self.above
        self.handed = self.plain + plan.slide - self.above
        self.linked = grid.linked
        self.lack = np.zeros(len(grid.arc))
        self.turns = np.zeros(len(self.total))

    def layer(self, below: int, begin: int, end: int) -> None:
        """Fix the phase on the nodes from `begin` to `end`; those of the layer below begin at `below`."""
        loops = np.unique(self.grid.loop[begin:end])
        source = below + np.flatnonzero(self.linked[below:begin])
        source = source[np.argsort(self.place[source], kind="stable")]
        known = self._carried(source) if len(source) else loops[:0]
        new = np.setdiff1d(loops, known)
        self.turns[new] = np.clip(np.rint(self.total[new]), self.fewest[new], self.most[new])
        node = np.arange(begin, end)
        loop = self.grid.loop[begin:end]
        slope = np.where(self.total > 0, (self.turns - self.total) / np.maximum(self.total, 1e-9), 0.0)[loop]
        even = self.lack[begin:end] - self.plain[begin:end] * slope
        even[~np.isin(loop, known)] = 0.0
        ahead, behind = self.grid.ahead[node] - begin, self.grid.behind[node] - begin
        for _ in range(SMOOTHINGS):
            even = 0.5 * even + 0.25 * (even[ahead] + even[behind])
        self.lack[begin:end] = even + self.plain[begin:end] * slope

    def _carried(self, source: IntArray) -> IntArray:
        """Take over the phase from the layer below; returns the contours that got one."""
        up = self.grid.loop[self.grid.low[source]]
        first = np.flatnonzero(np.append(True, up[1:] != up[:-1]))
        count = np.diff(np.append(first, len(up)))
        handed = self.handed[source] + self.lack[source]
        step = np.append(0.0, np.diff(handed))
        step -= np.rint(step)
        step[first] = 0.0
        walk = np.cumsum(step)
        lack = _mended(walk - np.repeat(walk[first], count), first, count)
        lack += np.repeat(handed[first] - np.rint(handed[first]), count)
        loop, last = up[first], first + count - 1
        turns = np.rint(lack[last] - lack[first] + self.total[loop])
        self.turns[loop] = np.clip(turns, self.fewest[loop], self.most[loop])
        self._spread(loop, self.place[source], lack, first, last)
        return np.asarray(loop)

    def _spread(self, loop: IntArray, place: FloatArray, lack: FloatArray, first: IntArray, last: IntArray) -> None:
        """Interpolate between the places around each contour."""
        total, more = self.total[loop], self.turns[loop] - self.total[loop]
        at = np.insert(place, first, place[last] - total)
        value = np.insert(lack, first, lack[last] - more)
        ends = last + np.arange(1, len(loop) + 1) + 1
        at, value = np.insert(at, ends, place[first] + total), np.insert(value, ends, lack[first] + more)
        order = np.concatenate([np.arange(self.grid.start[u], self.grid.start[u + 1]) for u in loop])
        group = np.repeat(np.arange(len(loop)), self.grid.start[loop + 1] - self.grid.start[loop])
        # Contours apart: what is added around one may reach over its neighbour's range.
        apart = 4 * float(total.max()) + 4
        where = self.plain[order] + group * apart
        at = (
            at
            - self.offset[np.repeat(loop, last - first + 3)]
            + np.repeat(np.arange(len(loop)), last - first + 3) * apart
        )
        self.lack[order] = np.interp(where, at, value)


def _mended(lack: FloatArray, first: IntArray, count: IntArray) -> FloatArray:
    """Whole waves added to or taken from the stretches where the phase strays too far from its mean."""
    mean = np.repeat(np.add.reduceat(lack, first) / count, count)
    is_first = np.zeros(len(lack), dtype=bool)
    is_first[first] = True
    for _ in range(MENDINGS):
        stray = lack - mean
        side = np.sign(stray) * (np.abs(stray) > STRETCH)
        stretch = np.flatnonzero(is_first | np.append(True, side[1:] != side[:-1]))
        far: BoolArray = (np.maximum.reduceat(np.abs(stray), stretch) > STRAY) & (side[stretch] != 0)
        if not far.any():
            break
        lack = lack - side * np.repeat(far, np.diff(np.append(stretch, len(lack))))
    return lack
