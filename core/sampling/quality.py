"""How well the checkerboard holds together: the paper's error between a layer and the one above (section 6.4)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..contours.contours import Contours
from ..contours.places import loop_of, places
from ..model import BoolArray, FloatArray, IntArray
from ..records import dataclass
from .projector import Projector
from .samples import Samples

# Distance between the probes, mm; the paper's 133,539 probes on LucyCat lie about 0.25 mm apart.
PROBE_SPACING = 0.25
# Below the first an error counts as none, from the second on it is salient (section 6.4 and the scale of Figure 10).
ERROR_FREE, SALIENT = 0.05, 0.5
HISTOGRAM_EDGES = (0.0, 0.05, 0.25, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0)


@dataclass(frozen=True)
class SeamErrors:
    """The error at probes all over the surface.

    Attributes:
        arc: (Q,) mm, the places of the probes.
        error: (Q,) d = (t₁ − t₂)² in [0, 4]; NaN where a probe was discarded.
    """

    arc: FloatArray
    error: FloatArray

    @property
    def discarded(self) -> BoolArray:
        """(Q,) probes with nothing above them within the projection threshold."""
        return np.isnan(self.error)

    def shares(self, samples: int, visibility: FloatArray | None = None) -> dict[str, Any]:
        """The report's figures: shares of the probes that were not discarded, and the discarded share of all.

        Args:
            samples: how many the pattern has.
            visibility: (Q,) 0 to 1, how visible a seam is at each probe; then `salient_seen` is the salient share
                weighted by it, and `visibility` the mean weight.
        """
        kept = self.error[~self.discarded]
        total = max(len(kept), 1)
        error_free, salient = int((kept < ERROR_FREE).sum()), int((kept >= SALIENT).sum())
        seen: dict[str, float] = {}
        if visibility is not None:
            weight = visibility[~self.discarded]
            seen["salient_seen"] = float(weight[kept >= SALIENT].sum() / max(weight.sum(), 1e-12))
            seen["visibility"] = float(weight.mean()) if len(weight) else 0.0
        return {
            "samples": samples,
            "error_free": error_free / total,
            "imperceptible": (len(kept) - error_free - salient) / total,
            "salient": salient / total,
            "discarded": float(self.discarded.mean()) if len(self.error) else 0.0,
            "probes": len(self.error),
            "discarded_probes": int(self.discarded.sum()),
            "mean_error": float(kept.mean()) if len(kept) else 0.0,
            "histogram": {"edges": list(HISTOGRAM_EDGES), "counts": np.histogram(kept, HISTOGRAM_EDGES)[0].tolist()},
            **seen,
        }


def displacement_at(lines: Contours, samples: Samples, arc: FloatArray) -> FloatArray:
    """(Q,) t = cos(2πu) at places on the contours, -1 to 1, NaN on a contour without samples."""
    loop, displacement = loop_of(lines, arc), np.full(len(arc), np.nan)
    waved = np.flatnonzero(np.diff(samples.start)[loop] > 0)
    arc, loop = arc[waved], loop[waved]
    before = samples.before(arc, loop)
    along = arc - samples.arc[before]
    along += np.where(along < 0, lines.length[loop], 0.0)
    displacement[waved] = np.cos(2 * np.pi * along / samples.spacing(lines)[before])
    return displacement


def seam_errors(samples: Samples, projector: Projector) -> SeamErrors:
    """Probe all contours that carry the pattern and compare each place with the one above it.

    Phase flips are left out of t, as in the paper. Probes with nothing above them, or only a contour without samples,
    count as discarded.
    """
    if not len(samples.arc):
        return SeamErrors(np.zeros(0), np.zeros(0))
    lines = projector.lines
    arc, loop = places(lines, PROBE_SPACING)
    layers = int(lines.layer.max(initial=0))
    use: IntArray = np.flatnonzero((np.diff(samples.start)[loop] > 0) & (lines.layer[loop] < layers))
    arc, loop = arc[use], loop[use]
    above, distance = projector.project(projector.at(arc), lines.layer[loop] + 1)
    found = np.isfinite(distance)
    error = np.full(len(arc), np.nan)
    error[found] = (displacement_at(lines, samples, arc[found]) - displacement_at(lines, samples, above[found])) ** 2
    return SeamErrors(arc, error)
