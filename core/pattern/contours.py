"""Filtered outlines: the smooth lines that the wave swings about, evenly sampled, with what they carry.

Every contour is the outline of the slice, low-passed so that nothing finer than the wave remains (paper, section 6),
and moved inwards by half a line width so that the strand's outer edge is the model's surface.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from itertools import pairwise

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..settings import PrintSettings
from ..slicing.outlines import Outlines, following, preceding, starts, sums
from ..slicing.planes import line_widths
from .chunks import in_threads
from .clearance import gaps

# Points along a contour: at least this many a wavelength.
POINTS_PER_WAVELENGTH = 6
# Standard deviation of the low-pass, in wavelengths: detail of half a wave's length keeps 1 % of its depth.
FILTER_SIGMA = 0.25
# Thinner lines than this share of the extrusion width do not stick; a thinner wall gets overlapping lines.
LEAST_WIDTH = 0.5
# Walls nearer to each other than twice this carry no wave: clearance is measured between points, not lines, mm.
NARROW_GAP = 0.02
# Where the line would fold back by its inset, at tips sharper than the line, the inset is halved, at most so often.
UNFOLDINGS, UNFOLDED = 5, 0.2
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
        room_inside: (N,) mm, how far the line may be moved inwards without meeting anything.
        room_outside: (N,) mm, the same outwards.
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
        columns = {
            column.name: np.concatenate([getattr(part, column.name) for part in parts]) for column in fields(Contours)
        }
        columns["start"] = np.append(
            np.concatenate([part.start[:-1] + base for part, base in zip(parts, points[:-1], strict=True)]), points[-1]
        )
        columns["arc_start"] = np.append(
            np.concatenate([part.arc_start[:-1] + base for part, base in zip(parts, arc[:-1], strict=True)]), arc[-1]
        )
        columns["arc"] = np.concatenate([part.arc + base for part, base in zip(parts, arc[:-1], strict=True)])
        return Contours(**columns)

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
    step = settings.wavelength / POINTS_PER_WAVELENGTH
    points, start, face, carried = resampled(outlines, step)
    kernel = gaussian(FILTER_SIGMA * POINTS_PER_WAVELENGTH)
    smooth = filtered(points, start, kernel)
    normal = _normals(smooth, start, kernel)
    loop_layer = outlines.layer
    widest = line_widths(np.repeat(loop_layer, np.diff(start)), settings)
    reach = 2 * float(widest.max(initial=0.0)) + settings.wave_depth_max + 2 * settings.offset_max
    thickness, clearance = gaps(smooth, normal, start, loop_layer, reach)
    width = np.clip(thickness / 2, LEAST_WIDTH * widest, widest)
    base, unbent = _inset(smooth, normal, np.minimum(width, thickness / 2) / 2, start, kernel)
    arc, arc_start = _arc_length(base, start)
    turn = curvature(base, start)
    inside, outside = np.maximum(thickness / 2 - width, 0), np.maximum(clearance / 2 - NARROW_GAP, 0)
    return Contours(
        points=base,
        normal=normal,
        start=start,
        layer=loop_layer,
        polygon=loop_polygon,
        arc=arc,
        arc_start=arc_start,
        face=face,
        carried=carried,
        width=width,
        room_inside=unbent * np.minimum(inside, _bend_room(turn, start, kernel)),
        room_outside=unbent * np.minimum(outside, _bend_room(-turn, start, kernel)),
    )


def resampled(outlines: Outlines, step: float) -> tuple[FloatArray, IntArray, IntArray, FloatArray]:
    """Evenly spaced points on each outline, no farther apart than `step` mm, at least eight a loop.

    Returns:
        points (N, 2), start (M + 1,), face (N,) and the carried values (N, 3) there.
    """
    along = outlines.ends - outlines.points
    length = np.hypot(along[:, 0], along[:, 1])
    loop_length = sums(length, outlines.start)
    count = np.maximum(np.ceil(loop_length / step), 8).astype(np.int64)
    start = starts(count)
    total = np.concatenate([[0.0], np.cumsum(length)])
    loop_begin = total[outlines.start[:-1]]
    loop = np.repeat(np.arange(len(count)), count)
    place = loop_begin[loop] + (np.arange(start[-1]) - start[loop]) * (loop_length / count)[loop]
    segment = np.clip(
        np.searchsorted(total, place, side="right") - 1, outlines.start[loop], outlines.start[loop + 1] - 1
    )
    share = np.clip((place - total[segment]) / np.maximum(length[segment], 1e-12), 0, 1)[:, None]
    # `take` is several times as fast as indexing where each row holds a few numbers.
    points = outlines.points.take(segment, axis=0) + share * along.take(segment, axis=0)
    ends = outlines.carried.take(segment, axis=0)
    return points, start, outlines.face[segment], ends[:, 0] + share * (ends[:, 1] - ends[:, 0])


def gaussian(sigma: float) -> FloatArray:
    """Weights of a Gaussian with this standard deviation (in samples), cut at three of them; they sum to 1."""
    reach = int(np.ceil(3 * sigma))
    weight = np.exp(-0.5 * (np.arange(-reach, reach + 1) / max(sigma, 1e-9)) ** 2)
    return np.asarray(weight / weight.sum())


def filtered(values: FloatArray, start: IntArray, kernel: FloatArray) -> FloatArray:
    """Convolve values (N, …) around each closed loop with a symmetric kernel of odd length."""
    reach, count = len(kernel) // 2, np.diff(start)
    padded_start = starts(count + 2 * reach)
    loop = np.repeat(np.arange(len(count)), count + 2 * reach)
    offset = np.arange(padded_start[-1]) - padded_start[loop] - reach
    padded = values.take(start[loop] + offset % np.maximum(count[loop], 1), axis=0)
    centre = np.arange(start[-1]) + reach * (1 + 2 * np.repeat(np.arange(len(count)), count))
    size = len(padded) - 2 * reach
    total = kernel[0] * padded[:size]
    weighted = np.empty_like(total)
    for shift in range(1, len(kernel)):
        total += np.multiply(padded[shift : shift + size], kernel[shift], out=weighted)
    return np.asarray(total.take(centre - reach, axis=0))


def _normals(points: FloatArray, start: IntArray, kernel: FloatArray) -> FloatArray:
    """Outward unit normals, smoothed once more so that neighbouring waves do not fan out at a corner."""
    along = points.take(following(start), axis=0) - points.take(preceding(start), axis=0)
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1)
    normal /= np.maximum(np.hypot(normal[:, 0], normal[:, 1]), 1e-12)[:, None]
    normal = filtered(normal, start, kernel)
    return np.asarray(normal / np.maximum(np.hypot(normal[:, 0], normal[:, 1]), 1e-12)[:, None])


def curvature(points: FloatArray, start: IntArray) -> FloatArray:
    """(N,) 1/mm, signed: positive where a counter-clockwise line bends to the left (is convex)."""
    ahead = points.take(following(start), axis=0) - points
    behind = ahead.take(preceding(start), axis=0)
    cross = behind[:, 0] * ahead[:, 1] - behind[:, 1] * ahead[:, 0]
    dot = (ahead * behind).sum(axis=1)
    length = (np.hypot(ahead[:, 0], ahead[:, 1]) + np.hypot(behind[:, 0], behind[:, 1])) / 2
    return np.asarray(np.arctan2(cross, dot) / np.maximum(length, 1e-9))


def _inset(
    smooth: FloatArray, normal: FloatArray, depth: FloatArray, start: IntArray, kernel: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The outline moved inwards by `depth` (N,) mm, by less where it would turn back on itself, and 0 to 1 there.

    The second is how much room for a wave such a tip leaves: none where the inset had to be halved.
    """
    ahead = following(start)
    along = smooth.take(ahead, axis=0) - smooth
    least = UNFOLDED * np.einsum("ij,ij->i", along, along)
    base, wanted = smooth - normal * depth[:, None], depth
    for _ in range(UNFOLDINGS):
        folded = np.einsum("ij,ij->i", base.take(ahead, axis=0) - base, along) < least
        if not folded.any():
            break
        ends = folded.astype(float)
        ends[ahead] = np.maximum(ends[ahead], folded)
        depth = depth * (1 - 0.5 * np.minimum(2 * len(kernel) * filtered(ends, start, kernel), 1.0))
        base = smooth - normal * depth[:, None]
    return base, np.clip(2 * depth / np.maximum(wanted, 1e-9) - 1, 0.0, 1.0)


def _bend_room(turn: FloatArray, start: IntArray, kernel: FloatArray) -> FloatArray:
    """How far a line may be moved towards the inside of its bends before it folds, mm."""
    bend = filtered(np.maximum(turn, 0.0), start, kernel)
    return np.asarray(0.7 / np.maximum(np.maximum(bend, turn), 1e-3))


def _arc_length(points: FloatArray, start: IntArray) -> tuple[FloatArray, FloatArray]:
    step = points.take(following(start), axis=0) - points
    length = np.hypot(step[:, 0], step[:, 1])
    total = np.concatenate([[0.0], np.cumsum(length)])
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
