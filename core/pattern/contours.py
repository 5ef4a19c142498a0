"""Filtered outlines: the smooth lines that the wave swings about, evenly sampled, with what they carry.

Every contour is the outline of the slice, low-passed so that nothing finer than the wave remains (paper, section 6),
and moved inwards by half a line width so that the strand's outer edge is the model's surface.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model import BoolArray, FloatArray, IntArray
from ..settings import PrintSettings
from ..slicing.outlines import Outlines, starts, sums
from ..slicing.planes import line_widths
from .along_loops import dot, filtered, gaussian, pairs, previous, rows, steps
from .chunks import in_threads
from .clearance import gaps
from .inset import bend_room, inset

# Points along a contour: at least this many a wavelength.
POINTS_PER_WAVELENGTH = 6
# Standard deviation of the low-pass, in wavelengths: detail of half a wave's length keeps 1 % of its depth.
FILTER_SIGMA = 0.25
# Thinner lines than this share of the extrusion width do not stick; a thinner wall gets overlapping lines.
LEAST_WIDTH = 0.5
# So much is kept clear between walls, mm: what is printed is within the chord tolerance of the waves.
NARROW_GAP = 0.02
# With so much air before it a wall is in no crease, mm.
OPEN_AIR = 1.0
# So many layers are treated at a time, in threads: their arrays stay in the cache.
LAYERS_AT_ONCE = 16


@dataclass(frozen=True)
class Contours:
    """M smooth closed lines with N points in all; they can be addressed by a single arc length.

    `arc` counts on from loop to loop, so one number names a place on any line of any layer.

    Attributes:
        points: (N, 2) mm, the mean line of the waved outline.
        normal: (N, 2) unit vectors out of the material.
        start: (M + 1,) int64.
        layer: (M,) int64, not decreasing.
        polygon: (M,) int64, the sliced region that each line bounds.
        arc: (N,) mm, increasing; the loop's own arc length plus `arc_start` of its loop.
        arc_start: (M + 1,) mm.
        face: (N,) int64, the face of the mesh at each point.
        carried: (N, 3) u, v and vertex tone at each point.
        width: (N,) mm, line width: the one of the layer, less where the wall is thin.
        room_inside: (N,) mm, how far the line may be moved inwards without meeting anything; no more than is used.
        room_outside: (N,) mm, the same outwards; with `hide_seams` up to `OPEN_AIR`.
    """

    points: FloatArray
    normal: FloatArray
    start: IntArray
    layer: IntArray
    polygon: IntArray
    arc: FloatArray
    arc_start: FloatArray
    face: IntArray
    carried: FloatArray
    width: FloatArray
    room_inside: FloatArray
    room_outside: FloatArray

    @property
    def length(self) -> FloatArray:
        """(M,) mm, of each line."""
        return np.diff(self.arc_start)

    @property
    def step(self) -> FloatArray:
        """(N,) mm, from each point to the next one of its line."""
        return np.diff(np.append(self.arc, self.arc_start[-1]))

    @property
    def loop(self) -> IntArray:
        """(N,) the loop of each point."""
        return np.repeat(np.arange(len(self.layer)), np.diff(self.start))

    @staticmethod
    def joined(parts: list[Contours]) -> Contours:
        """The contours of several runs of layers, which follow one another, in one table."""
        points = starts(np.array([part.start[-1] for part in parts]))
        arc = np.concatenate([[0.0], np.cumsum([part.arc_start[-1] for part in parts])])

        def column(name: str) -> NDArray[Any]:
            values = [getattr(part, name) for part in parts]
            if name not in ("start", "arc", "arc_start"):
                return np.concatenate(values)
            begin = points if name == "start" else arc
            values = [own + base for own, base in zip(values, begin[:-1], strict=True)]
            if name == "arc":
                return np.concatenate(values)
            return np.concatenate([*(own[:-1] for own in values), begin[-1:]])

        names = [one.name for one in fields(Contours)]
        return Contours(*in_threads(column, names))

    def locate(self, arc: FloatArray, loop: IntArray | None = None) -> tuple[IntArray, IntArray, FloatArray]:
        """Where places lie: index of the point before, of the point after, and the share of the way between them.

        Args:
            arc: (Q,) mm.
            loop: (Q,) the loop of each, if that is known already.
        """
        before = np.clip(np.searchsorted(self.arc, arc, side="right") - 1, 0, len(self.arc) - 1)
        if loop is None:
            loop = np.searchsorted(self.start, before, side="right") - 1
        is_last = before + 1 == self.start[loop + 1]
        after = np.where(is_last, self.start[loop], before + 1)
        end = np.where(is_last, self.arc_start[loop + 1], self.arc[np.minimum(before + 1, len(self.arc) - 1)])
        share = np.clip((arc - self.arc[before]) / np.maximum(end - self.arc[before], 1e-12), 0.0, 1.0)
        return before, after, share


def contours(outlines: Outlines, loop_polygon: IntArray, settings: PrintSettings) -> Contours:
    """Resample, filter and inset the outlines of all layers.

    Args:
        outlines: M loops.
        loop_polygon: (M,) the region that each bounds.
        settings: wavelength and the extrusion widths are used.
    """
    layers = int(outlines.layer.max(initial=-1)) + 1
    cuts = np.searchsorted(outlines.layer, np.arange(0, layers + LAYERS_AT_ONCE, LAYERS_AT_ONCE))

    def part(loops: tuple[int, int]) -> Contours:
        some = slice(*loops)
        return _contours(outlines.between(*loops), loop_polygon[some], settings)

    return Contours.joined(in_threads(part, pairwise(cuts.tolist())) or [part((0, 0))])


def _contours(outlines: Outlines, loop_polygon: IntArray, settings: PrintSettings) -> Contours:
    """The contours of a few layers; nothing in them depends on other layers."""
    points, start, face, carried = resampled(outlines, settings.wavelength / POINTS_PER_WAVELENGTH)
    kernel = gaussian(FILTER_SIGMA * POINTS_PER_WAVELENGTH)
    smooth = filtered(points, start, kernel)
    normal = _normals(smooth, start, kernel)
    widest = line_widths(outlines.layer, settings)
    inwards, outwards = _reach(settings)
    most_inside = 2 * (float(widest.max(initial=0.0)) + inwards)
    most_outside = 2 * (outwards + NARROW_GAP) if outwards else 0.0
    thickness, clearance = gaps(smooth, normal, start, outlines.layer, most_inside, most_outside)
    widest = np.repeat(widest, np.diff(start))
    width = np.clip(thickness / 2, LEAST_WIDTH * widest, widest)
    base, unbent = inset(smooth, normal, np.minimum(width, thickness / 2) / 2, start, kernel)
    room_inside = np.minimum(np.maximum(thickness / 2 - width, 0.0), bend_room(base, -normal, start, inwards))
    room_outside = clearance
    if outwards:
        room_outside = np.minimum(np.maximum(clearance / 2 - NARROW_GAP, 0.0), bend_room(base, normal, start, outwards))
    arc, arc_start = _arc_length(base, start)
    return Contours(
        points=pairs(base),
        normal=pairs(normal),
        start=start,
        layer=outlines.layer,
        polygon=loop_polygon,
        arc=arc,
        arc_start=arc_start,
        face=face,
        carried=carried,
        width=width,
        room_inside=unbent * room_inside,
        room_outside=unbent * room_outside,
    )


def _reach(settings: PrintSettings) -> tuple[float, float]:
    """How far room is looked for inwards and outwards, mm: as far as anything moves a line."""
    wave = 0.0 if settings.pattern == "offset" else settings.wave_depth_max / 2
    solid = 0.0 if settings.solid_regions == "none" else settings.solid_set_back
    air = OPEN_AIR if wave and settings.hide_seams else 0.0
    return wave + max(settings.offset_max, solid), max(wave, air)


def resampled(outlines: Outlines, step: float) -> tuple[FloatArray, IntArray, IntArray, FloatArray]:
    """Evenly spaced points on each outline, no farther apart than `step` mm, at least eight a loop.

    Returns:
        points (2, N), start (M + 1,), face (N,) and the carried values (N, 3) there.
    """
    corner = rows(outlines.points)
    along = steps(corner, outlines.start)
    length = np.sqrt(dot(along, along))
    loop_length = sums(length, outlines.start)
    count = np.maximum(np.ceil(loop_length / step), 8).astype(np.int64)
    start = starts(count)
    # Where each segment ends, in spacings from its loop's beginning: that many points lie before it.
    a_segment = np.repeat(count / np.maximum(loop_length, 1e-9), outlines.count)
    end = np.cumsum(length)
    end = (end - np.repeat(end[outlines.start[:-1]] - length[outlines.start[:-1]], outlines.count)) * a_segment
    before = np.minimum(np.ceil(end), np.repeat(count, outlines.count)).astype(np.int64)
    before[outlines.start[1:] - 1] = count
    before += np.repeat(start[:-1], outlines.count)
    segment = np.cumsum(np.bincount(before[:-1], minlength=start[-1] + 1)[: start[-1]])
    number = np.arange(start[-1]) - np.repeat(start[:-1], count)
    spacings = np.maximum(length * a_segment, 1e-12)
    share = np.clip(1 - (end[segment] - number) / spacings[segment], 0, 1)
    points = np.stack([at[segment] + share * on[segment] for at, on in zip(corner, along, strict=True)])
    ends = zip(*outlines.carried.transpose(1, 2, 0), strict=True)
    carried = np.stack([at[segment] + share * (to - at)[segment] for at, to in ends], axis=1)
    return points, start, outlines.face[segment], carried


def _normals(points: FloatArray, start: IntArray, kernel: FloatArray) -> FloatArray:
    """Outward unit normals, smoothed once more so that neighbouring waves do not fan out at a corner."""
    step = steps(points, start)
    x, y = _unit(step + previous(step, start))
    return _unit(filtered(np.stack([y, -x]), start, kernel))


def _unit(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.maximum(np.sqrt(dot(vectors, vectors)), 1e-12))


def _arc_length(points: FloatArray, start: IntArray) -> tuple[FloatArray, FloatArray]:
    step = steps(points, start)
    total = np.concatenate([[0.0], np.cumsum(np.sqrt(dot(step, step)))])
    return total[:-1], total[start]


def on_loop(arc: FloatArray, loop: IntArray, arc_start: FloatArray) -> FloatArray:
    """Arcs with those at the very end of their loop moved to its beginning, which is the same place.

    Without it rounding would make them places of the next loop.
    """
    return np.where(arc >= arc_start[loop + 1] - 1e-9, arc_start[loop], arc)


def loop_of(lines: Contours, arc: FloatArray) -> IntArray:
    """(Q,) the contour on which each place lies."""
    return np.asarray(np.clip(np.searchsorted(lines.arc_start, arc, side="right") - 1, 0, len(lines.layer) - 1))


def long_enough(length: FloatArray, settings: PrintSettings) -> BoolArray:
    """(M,) which lines hold the pattern: two samples at least."""
    return np.asarray(length >= 2 * settings.wavelength)
