"""Curves on the object's surface that show the findings of an analysis, their classes and colors."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ..contours.contours import Contours
from ..contours.places import loop_of, places
from ..model import BoolArray, FloatArray, IntArray
from ..ragged import starts
from ..records import dataclass
from ..sampling.quality import PROBE_SPACING, SeamErrors
from ..sampling.samples import Samples
from .tracelines import Tracelines

Rgb = tuple[float, float, float]
"""sRGB-encoded, 0 to 1."""

HEAT_STOPS = (0.05, 1.5, 3.0, 4.0)
HEAT_COLORS: tuple[Rgb, ...] = ((0.10, 0.62, 0.18), (0.98, 0.60, 0.05), (0.86, 0.08, 0.08), (0.50, 0.05, 0.55))
"""Errors and their colors; what is less is transparent (paper, section 6.4)."""
DISCARDED_COLOR: Rgb = (0.20, 0.50, 0.95)
TRACE_COLOR: Rgb = (0.10, 0.13, 0.28)
BIRTH_COLOR: Rgb = (0.05, 0.62, 0.45)
DEATH_COLOR: Rgb = (0.88, 0.25, 0.05)
FADED_COLOR: Rgb = (0.90, 0.20, 0.75)
SHORT_COLOR: Rgb = (0.10, 0.75, 0.85)
DEGRADED_COLOR: Rgb = (0.98, 0.78, 0.20)
GONE_COLOR: Rgb = (0.85, 0.15, 0.10)

_LIFT_MM = 0.05
_LEAST_FADED = 0.05


@dataclass(frozen=True)
class SurfaceCurves:
    """K polylines with N points on the surface of the object, where it is printed.

    Attributes:
        points: (N, 3) mm.
        start: (K + 1,) int64.
        value: (N,) value that the color stands for, such as the seam error.
    """

    points: FloatArray
    start: IntArray
    value: FloatArray


def heat_colors(error: FloatArray) -> FloatArray:
    """(N, 3) sRGB colors of seam errors (N,), blended between the stops."""
    return np.stack([np.interp(error, HEAT_STOPS, channel) for channel in np.array(HEAT_COLORS).T], axis=1)


def heat_class(error: FloatArray) -> IntArray:
    """(N,) number of the stop that each error is nearest to; -1 below the first, which is invisible."""
    middles = [(a + b) / 2 for a, b in pairwise(HEAT_STOPS)]
    return np.where(error < HEAT_STOPS[0], -1, np.searchsorted(middles, error, side="right"))


def heat_curves(lines: Contours, plane: FloatArray, errors: SeamErrors) -> tuple[list[SurfaceCurves], SurfaceCurves]:
    """Seams as curves: one set for each color of `HEAT_COLORS`, and one for the probes that were discarded.

    Args:
        lines: contours.
        plane: (L,) mm, height of each layer.
        errors: at probes on them.
    """
    error = np.nan_to_num(errors.error, nan=-1.0)
    kind = np.where(errors.discarded, len(HEAT_STOPS), heat_class(error))
    sets = [stretches(lines, plane, errors.arc, kind == number, error) for number in range(len(HEAT_STOPS) + 1)]
    return sets[:-1], sets[-1]


def stretches(
    lines: Contours, plane: FloatArray, arc: FloatArray, shown: BoolArray, value: FloatArray
) -> SurfaceCurves:
    """Runs of probes that are shown, each as a curve from half a step before its first to half a step after its last.

    Args:
        lines: contours.
        plane: (L,) mm, height of each layer.
        arc: (Q,) mm, increasing, places `quality.PROBE_SPACING` apart as `places.places` makes them.
        shown: (Q,) which of them.
        value: (Q,) carried along.
    """
    keep = np.flatnonzero(shown)
    loop = loop_of(lines, arc[keep])
    half = (lines.length / np.maximum(np.round(lines.length / PROBE_SPACING), 1))[loop] / 2
    begins = np.ones(len(keep), dtype=bool)
    begins[1:] = (keep[1:] != keep[:-1] + 1) | (loop[1:] != loop[:-1])
    ends = np.append(begins[1:], True)[: len(keep)]
    # The end of each run is one more place, right after its last.
    both = np.repeat(np.arange(len(keep)), 1 + ends)
    extra = np.zeros(len(both), dtype=bool)
    extra[1:] = both[1:] == both[:-1]
    at = arc[keep][both] + np.where(extra, half[both], -half[both])
    run = np.cumsum(begins) - 1
    return SurfaceCurves(
        surface_points(lines, plane, at, loop[both]), starts(np.bincount(run[both])), value[keep][both].astype(float)
    )


def surface_points(lines: Contours, plane: FloatArray, arc: FloatArray, loop: IntArray) -> FloatArray:
    """(Q, 3) mm, places on contours, moved out to the surface and a little beyond."""
    before, after, share = lines.locate(np.clip(arc, lines.arc_start[loop], lines.arc_start[loop + 1] - 1e-9), loop)
    share = share[:, None]
    outer = lines.points + lines.normal * (lines.width / 2 + _LIFT_MM)[:, None]
    flat = outer[before] + share * (outer[after] - outer[before])
    return np.column_stack([flat, plane[lines.layer[loop]]])


def trace_curves(lines: Contours, plane: FloatArray, samples: Samples, traced: Tracelines) -> SurfaceCurves:
    """The tracelines; those of a single sample are left out. The value is the number of the line."""
    points = surface_points(lines, plane, samples.arc, samples.loop)
    count = np.diff(traced.start)
    line = np.repeat(np.arange(len(count)), count)
    keep = (count > 1)[line]
    return SurfaceCurves(points[traced.sample[keep]], starts(count[count > 1]), line[keep].astype(float))


def sample_points(lines: Contours, plane: FloatArray, samples: Samples, chosen: BoolArray) -> FloatArray:
    """(n, 3) mm, some of the samples on the surface."""
    return surface_points(lines, plane, samples.arc[chosen], samples.loop[chosen])


def faded_curves(lines: Contours, plane: FloatArray, faded: FloatArray) -> SurfaceCurves:
    """Where the wave was faded for lack of room; `faded` (N,) is the lost share at each contour point."""
    arc, loop = places(lines, PROBE_SPACING)
    value = faded[lines.locate(arc, loop)[0]]
    return stretches(lines, plane, arc, value > _LEAST_FADED, value)


def loop_curves(lines: Contours, plane: FloatArray, chosen: BoolArray) -> SurfaceCurves:
    """Whole contours: those of `chosen` (M,)."""
    arc, loop = places(lines, PROBE_SPACING)
    return stretches(lines, plane, arc, chosen[loop], np.ones(len(arc)))
