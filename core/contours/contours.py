"""Filtered outlines: the smooth lines that the wave swings about, evenly sampled, with what they carry.

Every contour is the outline of the slice, low-passed so that nothing finer than the wave remains (paper, section 6),
and moved inwards by half a line width so that the strand's outer edge is the model's surface.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..model import FloatArray, IntArray
from ..parallel import runs_of_layers
from ..records import dataclass
from ..settings import PrintSettings
from ..slicing.outlines import Outlines
from ..slicing.planes import elephant_foot, line_widths
from .along_loops import around, dot, filtered, gaussian, steps
from .clearance import BLOCK, wall_distances
from .inset import bend_room, inset
from .resample import EvenPoints, even_points, resampled

# Points along a contour: at least this many a wavelength.
POINTS_PER_WAVELENGTH = 6
# Standard deviation of the low-pass, in wavelengths: detail of half a wave's length keeps 1 % of its depth.
FILTER_SIGMA = 0.25
# Thinner lines than this share of the extrusion width do not stick; a thinner wall gets overlapping lines.
LEAST_WIDTH = 0.5
# Walls of a little more than two lines get lines of up to this share: no line is thin enough for the gap behind them.
MOST_WIDTH = 1.18
# Kept clear between walls, mm: what is printed is within the chord tolerance of the waves.
NARROW_GAP = 0.02
# Air in front of a wall with which it is in no crease, mm.
OPEN_AIR = 1.0
# Points worked on at a time, about: their arrays stay in the cache.
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
    spacing, kernel = settings.wavelength / POINTS_PER_WAVELENGTH, gaussian(FILTER_SIGMA * POINTS_PER_WAVELENGTH)
    even = even_points(outlines, spacing, BLOCK)
    start, layer = even.start, outlines.layer
    runs = [_Run(*loops, start) for loops in runs_of_layers(layer, start, POINTS_AT_ONCE)]
    points, normal, face, carried = _filtered(outlines, even, runs, kernel)
    widest, squash = line_widths(layer, settings), np.where(layer == 0, elephant_foot(settings), 0.0)
    greatest = float(widest.max(initial=0.0))
    # Farther than the widest lines reach, so that what is thicker is seen to be.
    most_inside = 2 * (greatest + max(reach.inwards, (2 * MOST_WIDTH - 2) * greatest))
    most_outside = 2 * (reach.outwards + NARROW_GAP) if reach.outwards else 0.0
    thickness, clearance = wall_distances(points, spacing, normal, start, layer, most_inside, most_outside)
    step, width, room_inside = np.empty((3, len(face)))
    room_outside = np.zeros(len(face))
    for run in runs:
        part = run.points
        out = points[:, part], step[part], width[part], room_inside[part], room_outside[part]
        own = run.of_loops(widest), run.of_loops(squash) if squash[run.loops].any() else None
        _inset(out, normal[:, part], run.start, *own, thickness[part] / 2, clearance[part] / 2, kernel, reach)
    total = np.concatenate([[0.0], np.cumsum(step)])
    return Contours(
        points=points.T,  # in rows: whoever takes coordinates one after the other finds them side by side
        normal=normal.T,
        start=start,
        layer=layer,
        polygon=loop_polygon,
        arc=total[:-1],
        arc_start=total[start],
        face=face,
        carried=carried.T,
        width=width,
        room_inside=room_inside,
        room_outside=room_outside,
    )


class _Run:
    """Loops of a few layers, worked on at a time.

    Attributes:
        loops: among all loops.
        points: among all points.
        start: (m + 1,) where each loop's points start, counted within the run.
    """

    def __init__(self, first: int, last: int, start: IntArray) -> None:
        self.loops, self.points = slice(first, last), slice(int(start[first]), int(start[last]))
        self.start = start[first : last + 1] - start[first]

    def of_loops(self, value: FloatArray) -> FloatArray:
        """(n,) at each point of the run, the value of its loop; `value` (M,) is of all loops."""
        return np.repeat(value[self.loops], np.diff(self.start))


def _filtered(
    outlines: Outlines, even: EvenPoints, runs: list[_Run], kernel: FloatArray
) -> tuple[FloatArray, FloatArray, IntArray, FloatArray]:
    """(2, N) mm, the outlines evenly sampled and low-passed; (2, N) their normals; (N,) faces; (C, N) what they carry.

    Args:
        outlines: M loops.
        even: where the N points lie on them.
        runs: of loops.
        kernel: low-pass.
    """
    count = int(even.start[-1])
    points, normal, face = np.empty((2, count)), np.empty((2, count)), np.empty(count, dtype=np.int64)
    carried = np.empty((outlines.carried.shape[2], count))
    for run in runs:
        part = run.points
        on_outlines = resampled(outlines, even, run.loops, face[part], carried[:, part])
        points[:, part] = filtered(on_outlines, run.start, kernel)
        normal[:, part] = _normals(points[:, part], run.start, kernel)
    return points, normal, face, carried


def _inset(
    out: tuple[FloatArray, ...],
    normal: FloatArray,
    start: IntArray,
    widest: FloatArray,
    squash: FloatArray | None,
    half: FloatArray,
    half_gap: FloatArray,
    kernel: FloatArray,
    reach: Reach,
) -> None:
    """Move the filtered outlines of a few layers inwards.

    Args:
        out: (2, n) mm, the outlines, which are moved; and what is written, (n,) mm each: the step to the next point,
            line width, room inside and outside.
        normal: (2, n) unit vectors out of the material.
        start: (m + 1,) offsets of the loops.
        widest: (n,) mm, of the lines.
        squash: (n,) mm, by which they move inwards besides, where the material is thick enough; None is nowhere.
        half: (n,) mm, half of the material's thickness.
        half_gap: (n,) mm, half of the air's.
        kernel: low-pass.
        reach: as in `contours`.
    """
    outline, length, width, room_inside, room_outside = out
    np.maximum(np.where(half > MOST_WIDTH * widest, widest, half), LEAST_WIDTH * widest, out=width)
    depth = np.minimum(width, half)
    depth /= 2
    if squash is not None:
        taken = np.minimum(squash, np.maximum(half - width, 0.0))
        depth += taken
        half = half - taken
    base, step, unbent = inset(outline, normal, depth, start, kernel)
    square, turning = dot(step, step), dot(steps(normal, start), step)
    room = np.minimum(np.maximum(half - width, 0.0), bend_room(base, square, normal, turning, -1, start, reach.inwards))
    np.multiply(room, unbent, out=room_inside)
    if reach.outwards:
        room = np.maximum(half_gap - NARROW_GAP, 0.0)
        room = np.minimum(room, bend_room(base, square, normal, turning, 1, start, reach.outwards))
        np.multiply(room, unbent, out=room_outside)
    outline[:] = base
    np.sqrt(square, out=length)


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
