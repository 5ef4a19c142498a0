"""Filtered outlines: the smooth lines that the wave swings about, evenly sampled, with what they carry.

Every contour is the outline of the slice, low-passed so that nothing finer than the wave remains (paper, section 6),
and moved inwards by half a line width so that the strand's outer edge is the model's surface.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..lookup import Lookup
from ..model import BoolArray, FloatArray, IntArray
from ..parallel import runs_of_layers
from ..ragged import ranges
from ..records import dataclass
from ..settings import PrintSettings
from ..slicing.outlines import Outlines
from ..slicing.planes import elephant_foot, line_widths
from .along_loops import around, box, dot, filtered, gaussian, steps
from .clearance import BLOCK, gaps
from .inset import bend_room, inset
from .resample import even_points, resampled

# Points along a contour: at least this many a wavelength.
POINTS_PER_WAVELENGTH = 6
# Standard deviation of the low-pass, in wavelengths: detail of half a wave's length keeps 1 % of its depth.
FILTER_SIGMA = 0.25
# Thinner lines than this share of the extrusion width do not stick; a thinner wall gets overlapping lines.
LEAST_WIDTH = 0.5
# Walls of a little more than two lines get lines of up to this share: no line is thin enough for the gap behind them.
MOST_WIDTH = 1.18
# So much is kept clear between walls, mm: what is printed is within the chord tolerance of the waves.
NARROW_GAP = 0.02
# With so much air before it a wall is in no crease, mm.
OPEN_AIR = 1.0
# About so many points are worked on at a time: their arrays stay in the cache.
POINTS_AT_ONCE = 1 << 15
# How far room is looked for is a multiple of this, mm, but for rounding errors.
REACH_STEP, ROUNDING = 0.2, 1e-9


class Reach(NamedTuple):
    """How far to either side of an outline room for a line is looked for, mm."""

    inwards: float
    outwards: float


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
        carried: (N, C) u, v and, where the mesh has any, vertex tone at each point.
        width: (N,) mm, line width: the one of the layer, less where the wall is thin, or a little more.
        room_inside: (N,) mm, how far the line may be moved inwards without meeting anything; no more than `Reach`.
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
    def below_top(self) -> IntArray:
        """(M,) by how many layers each line lies below the highest one."""
        return int(self.layer.max(initial=0)) - self.layer

    @property
    def step(self) -> FloatArray:
        """(N,) mm, from each point to the next one of its line."""
        return np.diff(np.append(self.arc, self.arc_start[-1]))

    @property
    def loop(self) -> IntArray:
        """(N,) the loop of each point."""
        return np.repeat(np.arange(len(self.layer)), np.diff(self.start))

    def uv_at(self, point: IntArray) -> FloatArray:
        """(Q, 2) UVs at some of the points."""
        return np.stack([self.carried[:, column].take(point) for column in (0, 1)], axis=1)

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


def contours(
    outlines: Outlines, loop_polygon: IntArray, settings: PrintSettings, reach: Reach | None = None
) -> Contours:
    """Resample, filter and inset the outlines of all layers.

    Args:
        outlines: M loops.
        loop_polygon: (M,) the region that each bounds.
        settings: wavelength, the extrusion widths and the first layer's compensation are used.
        reach: how far room is looked for; None is as far as the settings ask for.
    """
    reach = reach or reach_of(settings)
    even = even_points(outlines, settings.wavelength / POINTS_PER_WAVELENGTH, BLOCK)
    count, start, layer = int(even.start[-1]), even.start, outlines.layer
    step, face, carried = np.empty(count), np.empty(count, dtype=np.int64), np.empty((outlines.carried.shape[2], count))
    points, normal = np.empty((2, count)), np.empty((2, count))
    lines = Contours(
        points=points.T,  # in rows: whoever takes coordinates one after the other finds them side by side
        normal=normal.T,
        start=start,
        layer=layer,
        polygon=loop_polygon,
        arc=step,
        arc_start=np.zeros(1),
        face=face,
        carried=carried.T,
        width=np.empty(count),
        room_inside=np.empty(count),
        room_outside=np.zeros(count),
    )
    runs = list(runs_of_layers(layer, start, POINTS_AT_ONCE))
    kernel, spacing = gaussian(FILTER_SIGMA * POINTS_PER_WAVELENGTH), settings.wavelength / POINTS_PER_WAVELENGTH
    for first, last in runs:
        part, own = slice(start[first], start[last]), start[first : last + 1] - start[first]
        points[:, part] = filtered(resampled(outlines, even, first, last, face[part], carried[:, part]), own, kernel)
        normal[:, part] = _normals(points[:, part], own, kernel)
    widest, squashed = line_widths(layer, settings), np.where(layer == 0, elephant_foot(settings), 0.0)
    greatest = float(widest.max(initial=0.0))
    # Farther than the widest lines reach, so that what is thicker is seen to be.
    most_inside = 2 * (greatest + max(reach.inwards, (2 * MOST_WIDTH - 2) * greatest))
    most_outside = 2 * (reach.outwards + NARROW_GAP) if reach.outwards else 0.0
    thickness, clearance = gaps(points, spacing, normal, start, layer, most_inside, most_outside)
    for first, last in runs:
        part, own = slice(start[first], start[last]), start[first : last + 1] - start[first]
        line_width = np.repeat(widest[first:last], np.diff(own))
        squash = np.repeat(squashed[first:last], np.diff(own)) if squashed[first:last].any() else None
        half = thickness[part] / 2, clearance[part] / 2
        _inset(lines, part, own, line_width, squash, *half, kernel, reach)
    total = np.concatenate([[0.0], np.cumsum(step)])
    return replace(lines, arc=total[:-1], arc_start=total[start])


def _inset(
    lines: Contours,
    part: slice,
    start: IntArray,
    widest: FloatArray,
    squash: FloatArray | None,
    half: FloatArray,
    half_gap: FloatArray,
    kernel: FloatArray,
    reach: Reach,
) -> None:
    """Move the filtered outlines of a few layers inwards; other layers do not matter.

    Args:
        lines: what is filled in, first with the filtered outlines and their normals; `arc` with the step from each
            point to the next one.
        part: where.
        start: (m + 1,) offsets of the loops.
        widest: (n,) mm, of the lines.
        squash: (n,) mm, by which they move inwards in addition, as far as the material is thick enough for
            that; None is nowhere.
        half: (n,) mm, half of the material's thickness.
        half_gap: (n,) mm, half of the air's.
        kernel: low-pass.
        reach: as in `contours`.
    """
    inwards, outwards = reach
    outline, normal, width = lines.points[part].T, lines.normal[part].T, lines.width[part]
    np.maximum(np.where(half > MOST_WIDTH * widest, widest, half), LEAST_WIDTH * widest, out=width)
    depth = np.minimum(width, half)
    depth /= 2
    if squash is not None:
        taken = np.minimum(squash, np.maximum(half - width, 0.0))
        depth += taken
        half = half - taken
    base, step, unbent = inset(outline, normal, depth, start, kernel)
    square, turning = dot(step, step), dot(steps(normal, start), step)
    room = np.minimum(np.maximum(half - width, 0.0), bend_room(base, square, normal, turning, -1, start, inwards))
    np.multiply(room, unbent, out=lines.room_inside[part])
    if outwards:
        room = np.maximum(half_gap - NARROW_GAP, 0.0)
        room = np.minimum(room, bend_room(base, square, normal, turning, 1, start, outwards))
        np.multiply(room, unbent, out=lines.room_outside[part])
    outline[:] = base
    np.sqrt(square, out=lines.arc[part])


def reach_of(settings: PrintSettings) -> Reach:
    """The farthest that anything may move a line, rounded up so that small changes of settings keep the contours."""
    wave = settings.wave_crest
    solid = 0.0 if settings.solid_regions == "none" else settings.solid_set_back
    air = OPEN_AIR if wave and settings.hide_seams else 0.0
    inwards = wave + max(settings.offset_max, solid) + elephant_foot(settings)
    outwards = max(wave, air)
    return Reach(*(REACH_STEP * math.ceil(way / REACH_STEP - ROUNDING) for way in (inwards, outwards)))


def _normals(points: FloatArray, start: IntArray, kernel: FloatArray) -> FloatArray:
    """Outward unit normals, smoothed once more so that neighboring waves do not fan out at a corner.

    Args:
        points: (2, N) mm.
        start: (M + 1,) offsets of the loops.
        kernel: low-pass.
    """
    x, y = filtered(_unit(around(points, start)), start, kernel)
    return _unit(np.stack([y, -x]))


def _unit(vectors: FloatArray) -> FloatArray:
    vectors /= np.maximum(np.sqrt(dot(vectors, vectors)), 1e-12)
    return vectors


def on_loop(arc: FloatArray, loop: IntArray, arc_start: FloatArray) -> FloatArray:
    """Move arcs at the very end of their loop to its beginning, the same place: rounding puts them on the next loop.

    The arcs themselves are changed.
    """
    over = np.flatnonzero(arc >= arc_start.take(loop + 1) - 1e-9)
    arc[over] = arc_start[loop[over]]
    return arc


def loop_of(lines: Contours, arc: FloatArray) -> IntArray:
    """(Q,) the contour on which each place lies."""
    return np.maximum(Lookup(lines.arc_start[:-1]).before(arc), 0)


def long_enough(length: FloatArray, wavelength: float) -> BoolArray:
    """(M,) which lines of these lengths, mm, hold the pattern: two samples at least."""
    return np.asarray(length >= 2 * wavelength)


def average_along_wall(values: FloatArray, lines: Contours, window: float) -> FloatArray:
    """Average values (N,), such as tones, along each contour over about `window` mm."""
    step = lines.length / np.maximum(np.diff(lines.start), 1)
    usual = float(np.median(step)) if len(step) else 1.0
    reach = round((window / usual - 1) / 2)
    if reach < 1:
        return values
    return filtered(values, lines.start, box(reach))


def places(lines: Contours, spacing: float) -> tuple[FloatArray, IntArray]:
    """Evenly spaced places on all contours, about `spacing` mm apart: their arcs (Q,) and loops (Q,)."""
    count = np.maximum(np.round(lines.length / spacing), 1).astype(np.int64)
    loop = np.repeat(np.arange(len(count)), count)
    step = ranges(0, count)
    return lines.arc_start[loop] + (step + 0.5) * (lines.length / count)[loop], loop
