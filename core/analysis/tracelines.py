"""Tracelines: the samples of all layers joined into lines that run up the object (paper, section 3.2, Figure 4 e)."""

from __future__ import annotations

import numpy as np

from ..contours.places import loop_of
from ..model import BoolArray, FloatArray, IntArray
from ..ragged import starts
from ..records import dataclass
from ..sampling.projector import Projector
from ..sampling.samples import Samples


@dataclass(frozen=True)
class Tracelines:
    """S samples in K lines, from the bottom to the top of each.

    Attributes:
        sample: (S,) int64, the samples line by line.
        start: (K + 1,) int64.
        birth: (S,) bool of each sample: it begins a line though the layer below carries the pattern there.
        death: (S,) bool of each sample: it ends a line though the layer above carries the pattern there.
    """

    sample: IntArray
    start: IntArray
    birth: BoolArray
    death: BoolArray

    def report(self) -> dict[str, float]:
        """How many there are and how often the pattern is broken."""
        count = np.diff(self.start)
        return {
            "tracelines": len(count),
            "births": int(self.birth.sum()),
            "deaths": int(self.death.sum()),
            "longest_layers": int(count.max(initial=0)),
            "mean_layers": float(count.mean()) if len(count) else 0.0,
        }


def tracelines(samples: Samples, projector: Projector, wavelength: float) -> Tracelines:
    """Join each sample to the one above it.

    A sample goes on in the sample nearest to its projection onto the next layer, if that is less than half a
    wavelength away and no other sample is nearer to it. Where the projection finds nothing, or an outline too short
    for the pattern, a line ends without a death; births likewise.

    Args:
        samples: S on the contours of all layers.
        projector: made for these contours.
        wavelength: mm.
    """
    after, away, above = _nearest(samples, projector, 1)
    _, _, below = _nearest(samples, projector, -1)
    source = np.flatnonzero(above & (away < wavelength / 2))
    source = source[np.lexsort((away[source], after[source]))]
    first = np.ones(len(source), dtype=bool)
    first[1:] = after[source][1:] != after[source][:-1]
    source = source[first]
    target = after[source]
    goes_on, comes_from = np.zeros((2, len(samples.arc)), dtype=bool)
    goes_on[source], comes_from[target] = True, True
    root = np.arange(len(samples.arc))
    root[target] = source
    while not np.array_equal(further := root[root], root):
        root = further
    order = np.argsort(root, kind="stable")
    _, count = np.unique(root, return_counts=True)
    return Tracelines(order, starts(count), below & ~comes_from, above & ~goes_on)


def _nearest(samples: Samples, projector: Projector, step: int) -> tuple[IntArray, FloatArray, BoolArray]:
    """The nearest sample a layer up or down: its number, its distance along the contour, and whether there is one."""
    lines = projector.lines
    layer = lines.layer[samples.loop] + step
    found, away = np.zeros(len(layer), dtype=np.int64), np.full(len(layer), np.inf)
    inside = np.flatnonzero((layer >= 0) & (layer <= lines.layer.max(initial=0)))
    place, gap = projector.project(projector.at(samples.arc[inside]), layer[inside])
    loop = loop_of(lines, place)
    hit = np.isfinite(gap)
    hit[hit] = np.diff(samples.start)[loop[hit]] > 0
    inside, place, loop = inside[hit], place[hit], loop[hit]
    before = samples.before(place, loop)
    after = np.where(before + 1 == samples.start[loop + 1], samples.start[loop], before + 1)
    choices = np.stack([before, after])
    straight = np.abs(samples.arc[choices] - place)
    around = np.minimum(straight, lines.length[loop] - straight)
    nearer = np.argmin(around, axis=0)
    row = np.arange(len(inside))
    found[inside], away[inside] = choices[nearer, row], around[nearer, row]
    return found, away, np.isfinite(away)
