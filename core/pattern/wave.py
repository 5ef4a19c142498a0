"""Waved outlines: the sine between the samples as a polyline within the chord tolerance (paper, section 3.2)."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..contours.contours import POINTS_PER_WAVELENGTH, Contours
from ..model import BoolArray, FloatArray, IntArray
from ..parallel import in_chunks
from ..ragged import ranges, starts
from ..records import dataclass
from ..sampling.samples import Samples
from ..settings import PrintSettings
from .chords import chord_ends
from .modulation import faded, layer_is_black, layer_shift, layer_sign, shape, supported

# Share of the chord tolerance spent on sampling the sine evenly; the rest is for removing points that change nothing.
SAMPLING_SHARE = 0.35
# Chords tessellated at a time, about, so that their arrays stay in the cache.
CHORDS_AT_ONCE = 25 << 10
# Rows of the table of what is interpolated between contour points.
_POINT, _NORMAL = slice(0, 2), slice(2, 4)
_DEPTH, _SET_BACK, _TONE, _WIDTH, _SWAPPED = range(4, 9)


@dataclass(frozen=True)
class WavedOutlines:
    """The outer wall as it is printed: M loops with N points.

    Attributes:
        base: (N, 2) mm, on the contour, before the wave.
        points: (N, 2) mm, after wave and set-back.
        start: (M + 1,) int64.
        layer: (M,) int64.
        polygon: (M,) int64, the sliced region.
        wave: (N,) t = cos(2πu) in [−1, 1], before the layer's sign; 0 where a line carries no wave.
        depth: (N,) mm, peak to peak.
        set_back: (N,) mm.
        tone: (N,) 0 to 1.
        uv: (N, 2) texture coordinates.
        width: (N,) mm, line width.
        swapped: (N,) bool, whether the other tool prints the line that leaves each point; None if it prints none.
    """

    base: FloatArray
    points: FloatArray
    start: IntArray
    layer: IntArray
    polygon: IntArray
    wave: FloatArray
    depth: FloatArray
    set_back: FloatArray
    tone: FloatArray
    uv: FloatArray
    width: FloatArray
    swapped: BoolArray | None = None


@dataclass(frozen=True)
class Spans:
    """The contours cut at their samples: one span per wave, or a whole loop without samples.

    Attributes:
        arc: (P,) mm, where each span begins.
        length: (P,) mm.
        loop: (P,) int64.
        waves: (P,) bool, False for the whole loops.
    """

    arc: FloatArray
    length: FloatArray
    loop: IntArray
    waves: BoolArray


def spans(lines: Contours, samples: Samples) -> Spans:
    """Cut every contour at its samples."""
    bare = np.flatnonzero(np.diff(samples.start) == 0)
    loop = np.concatenate([samples.loop, bare])
    order = np.argsort(loop, kind="stable")
    return Spans(
        np.concatenate([samples.arc, lines.arc_start[bare]])[order],
        np.concatenate([samples.spacing(lines), lines.length[bare]])[order],
        loop[order],
        np.concatenate([np.ones(len(samples.arc), dtype=bool), np.zeros(len(bare), dtype=bool)])[order],
    )


def modulated(
    lines: Contours, tone: FloatArray, slant_deg: FloatArray, settings: PrintSettings
) -> tuple[FloatArray, FloatArray]:
    """Wave depth and set-back at every contour point, reduced where a strand would lack support or room.

    Args:
        lines: N contour points.
        tone: (N,) 0 black to 1 white.
        slant_deg: (N,) of the surface, positive where it looks up.
        settings: those of the pattern are used.

    Returns:
        (N,) depth and (N,) set-back, mm.
    """
    count = np.diff(lines.start)
    is_black = np.repeat(layer_is_black(lines.layer, settings), count)
    depth, set_back = supported(*shape(tone, is_black, settings), slant_deg, settings)
    if settings.pattern == "offset":
        return depth, np.minimum(set_back, lines.room_inside)
    depth[np.repeat(lines.layer < settings.flat_layers, count)] = 0.0
    return faded(depth, set_back, lines.room_inside, lines.room_outside)


def waved(
    lines: Contours,
    samples: Samples,
    tone: FloatArray,
    depth: FloatArray,
    set_back: FloatArray,
    settings: PrintSettings,
    swapped: BoolArray | None = None,
) -> WavedOutlines:
    """Displace every contour along its normal: cos(2πu) between samples times half the depth, less the set-back.

    Args:
        lines: M contours with N points.
        samples: where the waves sit.
        tone: (N,) at every contour point.
        depth: (N,) mm.
        set_back: (N,) mm.
        settings: the chord tolerance is used.
        swapped: (N,) bool, points that the other tool prints, or None.
    """
    if not len(samples.arc):
        return _without_waves(lines, tone, depth, set_back, settings, swapped)
    pieces = spans(lines, samples)
    count = _chords_of(pieces, lines, depth, settings)
    columns = [*lines.points.T, *lines.normal.T, depth, set_back, tone, lines.width]
    table = np.stack(columns if swapped is None else [*columns, swapped.astype(np.float64)])
    at_once = max(CHORDS_AT_ONCE * len(count) // max(int(count.sum()), 1), 1)
    tessellated = partial(_tessellated, lines, pieces, count, table, settings)
    return _outlines(lines, *in_chunks(tessellated, np.arange(len(count)), rows=at_once))


def _tessellated(
    lines: Contours, pieces: Spans, count: IntArray, table: FloatArray, settings: PrintSettings, piece: IntArray
) -> tuple[NDArray[Any], ...]:
    """The points of some spans that are kept: arguments of `_outlines`.

    Args:
        lines: N contour points.
        pieces: P spans.
        count: (P,) chords in each.
        table: (8 or 9, N) at every contour point: rows as the constants say, the last one where any is swapped.
        settings: of the pattern.
        piece: (Q,) the spans, one after the other.
    """
    row, share, before, after, weight = _along(pieces, lines, piece, count[piece])
    value = table.take(before, axis=1)
    value += weight * (table.take(after, axis=1) - value)
    wave, swing = _swing(share, pieces.waves[row], lines.layer[pieces.loop[row]], settings)
    points = value[_POINT] + value[_NORMAL] * (swing * value[_DEPTH] / 2 - value[_SET_BACK])
    last = np.cumsum(count[piece] + 1) - 1
    tolerance = settings.chord_tolerance * (1 - SAMPLING_SHARE)
    keep = chord_ends(points, last - count[piece], count[piece], last, tolerance)
    if len(value) > _SWAPPED:
        keep[1:] |= (value[_SWAPPED, 1:] > 0.5) != (value[_SWAPPED, :-1] > 0.5)
    keep[last] = False  # it is the first point of the next span
    kept = np.flatnonzero(keep)
    nearest = np.where(weight[kept] < 0.5, before[kept], after[kept])
    uv = lines.uv_at(nearest)
    return points.take(kept, axis=1).T, value.take(kept, axis=1).T, wave[kept], pieces.loop[row[kept]], uv


def _outlines(
    lines: Contours, points: FloatArray, value: FloatArray, wave: FloatArray, loop: IntArray, uv: FloatArray
) -> WavedOutlines:
    """Outlines from K points: (K, 2) mm, what the table has there (K, 8 or 9), t (K,), contour (K,), UVs (K, 2)."""
    return WavedOutlines(
        base=np.ascontiguousarray(value[:, _POINT]),
        points=np.ascontiguousarray(points),
        start=starts(np.bincount(loop, minlength=len(lines.layer))),
        layer=lines.layer,
        polygon=lines.polygon,
        wave=wave,
        depth=value[:, _DEPTH].copy(),
        set_back=value[:, _SET_BACK].copy(),
        tone=value[:, _TONE].copy(),
        uv=uv,
        width=value[:, _WIDTH].copy(),
        swapped=value[:, _SWAPPED] > 0.5 if value.shape[1] > _SWAPPED else None,
    )


def _without_waves(
    lines: Contours,
    tone: FloatArray,
    depth: FloatArray,
    set_back: FloatArray,
    settings: PrintSettings,
    swapped: BoolArray | None,
) -> WavedOutlines:
    """As `waved` where no contour carries a wave: their own points, set back."""
    moved = np.ascontiguousarray(lines.points.T - lines.normal.T * set_back)
    first = lines.start[:-1]
    keep = chord_ends(moved, first, np.diff(lines.start), first, settings.chord_tolerance)
    if swapped is not None:
        keep[1:] |= swapped[1:] != swapped[:-1]
    point = np.flatnonzero(keep)
    return WavedOutlines(
        base=np.stack([column.take(point) for column in lines.points.T], axis=1),
        points=np.stack([row.take(point) for row in moved], axis=1),
        start=np.searchsorted(point, lines.start),
        layer=lines.layer,
        polygon=lines.polygon,
        wave=np.zeros(len(point)),
        depth=depth[point],
        set_back=set_back[point],
        tone=tone[point],
        uv=lines.uv_at(point),
        width=lines.width[point],
        swapped=None if swapped is None else swapped[point],
    )


def _swing(
    share: FloatArray, waves: BoolArray, layer: IntArray, settings: PrintSettings
) -> tuple[FloatArray, FloatArray]:
    """(Q,) the wave t at a share (Q,) of each span, and (Q,) the displacement on its layer, -1 to 1, outwards."""
    wave = np.where(waves, np.cos(2 * np.pi * share), 0.0)
    if not settings.phase_shift_layers:
        return wave, layer_sign(layer) * wave
    return wave, np.where(waves, np.cos(2 * np.pi * share + layer_shift(layer, settings)), 0.0)


def _along(
    pieces: Spans, lines: Contours, piece: IntArray, count: IntArray
) -> tuple[IntArray, FloatArray, IntArray, IntArray, FloatArray]:
    """Evenly spaced places along spans: the span of each, the share of the way along it, its `Contours.locate`."""
    row = np.repeat(piece, count + 1)
    step = ranges(0, count + 1)
    share = step / np.repeat(np.maximum(count, 1), count + 1)
    loop = pieces.loop[row]
    arc = pieces.arc[row] + share * pieces.length[row]
    begin, end = lines.arc_start[loop], lines.arc_start[loop + 1]
    arc = np.where(arc >= end, np.maximum(arc - (end - begin), begin), arc)
    return row, share, *lines.locate(arc, loop)


def _chords_of(pieces: Spans, lines: Contours, depth: FloatArray, settings: PrintSettings) -> IntArray:
    """(P,) chords in each span: enough for the sharpest bend of its sine and for the contour's own points."""
    before, _, _ = lines.locate(pieces.arc)
    after, _, _ = lines.locate(np.minimum(pieces.arc + pieces.length, lines.arc_start[pieces.loop + 1] - 1e-6))
    deepest = np.maximum(depth[before], depth[after])
    bend = deepest / 2 * (2 * np.pi / pieces.length) ** 2
    chord = np.sqrt(8 * SAMPLING_SHARE * settings.chord_tolerance / np.maximum(bend, 1e-6))
    chord = np.where(pieces.waves, chord, np.inf)
    own = settings.wavelength / POINTS_PER_WAVELENGTH
    return np.asarray(np.ceil(pieces.length / np.minimum(chord, own)), dtype=np.int64)


def valley_lines(lines: Contours, depth: FloatArray, set_back: FloatArray) -> FloatArray:
    """(N, 2) mm, the line through the valleys of the wave, as far inside as the outer wall goes."""
    valleys = -lines.normal
    valleys *= (depth / 2 + set_back)[:, None]
    valleys += lines.points
    return valleys
