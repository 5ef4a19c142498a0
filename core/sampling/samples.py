"""Where the waves sit: one sample for each (paper, section 3.2)."""

from __future__ import annotations

import numpy as np

from ..contours.contours import Contours
from ..model import FloatArray, IntArray
from ..records import dataclass
from .spacing import spacings


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

    @staticmethod
    def on(lines: Contours, arc: FloatArray) -> Samples:
        """The samples at increasing arcs (S,)."""
        start = np.searchsorted(arc, lines.arc_start)
        return Samples(arc, np.repeat(np.arange(len(lines.layer)), np.diff(start)), start)

    def of_loops(self, loops: slice) -> Samples:
        """Those of some contours that follow each other, which are numbered from 0 then."""
        own = slice(*self.start[[loops.start, loops.stop]].tolist())
        return Samples(
            self.arc[own], self.loop[own] - loops.start, self.start[loops.start : loops.stop + 1] - own.start
        )

    def before(self, arc: FloatArray, loop: IntArray) -> IntArray:
        """(Q,) the sample before each place.

        Args:
            arc: (Q,) mm, the places.
            loop: (Q,) their contours, which have samples. What lies before a contour's first one comes after its last.
        """
        before = np.searchsorted(self.arc, arc, side="right") - 1
        return np.where(before < self.start[loop], self.start[loop + 1] - 1, before)

    def spacing(self, lines: Contours) -> FloatArray:
        """(S,) mm along the contour from each sample to the next one of its loop."""
        return spacings(self.arc - lines.arc_start[self.loop], self.loop, lines.length)[0]
