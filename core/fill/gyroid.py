"""Sparse fill along the gyroid, sin x cos y + sin y cos z + sin z cos x = 0, cut at the height of each layer.

At one height the gyroid is a family of waves side by side, along x where |sin z| ≤ |cos z| and along y elsewhere. In
the frame of the waves it is a cos y + b sin y = c with coefficients that depend on x only, so
y = atan2(b, a) ± arccos(c / √(a² + b²)). Counting y in waves makes straight lines of them: regions are warped so,
hatched and joined like for any other lines, for all layers at once, and the lines are warped back.
"""

from __future__ import annotations

import numpy as np
import shapely

from ..model import BoolArray, FloatArray, IntArray, Shapes
from ..paths import Feature, Paths
from ..ragged import starts
from ..records import dataclass
from ..settings import PrintSettings
from .hatch import crossings, long_enough, rotated, spans
from .joining import LinkLimits, joined

# Length of the curves over the area, for a gyroid of period 2π, averaged over all heights.
_LENGTH_PER_AREA = 0.3913
_CHORDS = 24  # a period is cut into these; simplifying then drops most of them
_SHORTEST_CHORD_MM = 0.1
_SIMPLIFY_MM = 0.06
_LONGEST_LINK = 3.0  # in distances of the waves, along the wall
_NO_STRAIGHT_LINK = -1.0  # what is straight between the waves is bent between the walls


@dataclass(frozen=True)
class _Waves:
    """The frame of the waves of each point. N points.

    Attributes:
        z: (N,) height in radians.
        scale_mm: of one radian.
    """

    z: FloatArray
    scale_mm: float

    def roots(self, x_mm: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(N,) middle and (N,) half the distance, in radians, of two neighboring waves at x (N,)."""
        x, sine, cosine = x_mm / self.scale_mm, np.sin(self.z), np.cos(self.z)
        along = _along_x(self.z)
        sign = np.where(np.where(along, cosine, sine) < 0, -1.0, 1.0)
        a = np.where(along, np.sin(x) * sign, np.abs(sine))
        b = np.where(along, np.abs(cosine), -np.cos(x) * sign)
        c = -sign * np.where(along, sine * np.cos(x), cosine * np.sin(x))
        return np.arctan2(b, a), np.arccos(np.clip(c / np.hypot(a, b), -1.0, 1.0))

    def counted(self, points: FloatArray) -> FloatArray:
        """(N, 2) mm → (N, 2) with y counted in waves, a whole number on each wave."""
        middle, half = self.roots(points[:, 0])
        above = points[:, 1] / self.scale_mm - middle + half
        pair = np.floor(above / (2 * np.pi))
        above -= 2 * np.pi * pair
        between = above / np.maximum(2 * half, 1e-12)
        beyond = 1 + (above - 2 * half) / np.maximum(2 * (np.pi - half), 1e-12)
        return np.stack([points[:, 0], 2 * pair + np.where(above < 2 * half, between, beyond)], axis=1)

    def measured(self, points: FloatArray) -> FloatArray:
        """(N, 2) with y counted in waves → mm, the inverse of `counted`."""
        middle, half = self.roots(points[:, 0])
        pair = np.floor(points[:, 1] / 2)
        share = points[:, 1] - 2 * pair
        above = np.where(share < 1, share * 2 * half, 2 * half + (share - 1) * 2 * (np.pi - half))
        return np.stack([points[:, 0], (above + 2 * np.pi * pair + middle - half) * self.scale_mm], axis=1)


def gyroid_paths(
    regions: Shapes, layer: IntArray, height_mm: FloatArray, width_mm: FloatArray, settings: PrintSettings
) -> Paths:
    """Fill regions with a gyroid; averaged over its period in height, its lines cover `infill_density` of the area.

    Args:
        regions: (I,) Polygon or MultiPolygon, maybe empty.
        layer: (I,) layer of each.
        height_mm: (I,) where each is cut.
        width_mm: (I,) of the lines.
        settings: `infill_density`, which is not 0, `infill_angle` and `extrusion_width` are used.

    Returns:
        INFILL polylines on the gyroid, joined along the regions' boundaries; their island is the region.
    """
    scale = _LENGTH_PER_AREA * settings.extrusion_width * 100.0 / settings.infill_density
    apart = np.pi * scale
    chord = max(2 * np.pi * scale / _CHORDS, _SHORTEST_CHORD_MM)
    z = height_mm / scale
    angle = settings.infill_angle + np.where(_along_x(z), 0.0, 90.0)

    warped = shapely.segmentize(regions, chord)
    corners, owner = shapely.get_coordinates(warped, return_index=True)
    counted = _Waves(z[owner], scale).counted(rotated(corners, -angle, owner))
    shapely.set_coordinates(warped, counted * [1.0, apart])
    points, start, region = _straight_lines(warped, apart, 0.5 * settings.extrusion_width)
    points, start = _subdivided(points / [1.0, apart], start, chord)
    owner = np.repeat(region, np.diff(start))
    points = rotated(_Waves(z[owner], scale).measured(points), angle, owner)
    points, start = _simplified(points, start)
    width = np.repeat(width_mm[region], np.diff(start))
    return Paths.alike(points, start, layer[region], feature=Feature.INFILL, island=region, closed=False, width=width)


def _straight_lines(regions: Shapes, apart: float, shortest: float) -> tuple[FloatArray, IntArray, IntArray]:
    """Lines along x in regions (I,), `apart` from each other and no shorter than `shortest`; results as of `joined`."""
    everywhere = np.ones(len(regions))
    cut = crossings(regions, 0 * everywhere, apart * everywhere)
    found = spans(cut)
    limits = LinkLimits(0.0, _NO_STRAIGHT_LINK * everywhere, _LONGEST_LINK * apart * everywhere)
    return joined(cut, found, long_enough(cut, found, shortest), 0 * everywhere, limits)


def _along_x(z: FloatArray) -> BoolArray:
    """(N,) whether the waves at heights z (N,), in radians, run along x; along y they do elsewhere."""
    return np.asarray(np.abs(np.sin(z)) <= np.abs(np.cos(z)))


def _subdivided(points: FloatArray, start: IntArray, chord_mm: float) -> tuple[FloatArray, IntArray]:
    """Polylines cut into lines that are no longer than `chord_mm` along x."""
    step = np.diff(points, axis=0, append=points[-1:])
    step[start[1:] - 1] = 0.0
    count = np.maximum(np.ceil(np.abs(step[:, 0]) / chord_mm), 1).astype(np.int64)
    first = starts(count)
    row = np.repeat(np.arange(len(points)), count)
    share = (np.arange(first[-1]) - first[row]) / count[row]
    return points[row] + share[:, None] * step[row], first[start]


def _simplified(points: FloatArray, start: IntArray) -> tuple[FloatArray, IntArray]:
    """Polylines with fewer points, within `_SIMPLIFY_MM`."""
    lines = shapely.linestrings(points, indices=np.repeat(np.arange(len(start) - 1), np.diff(start)))
    lines = shapely.simplify(lines, _SIMPLIFY_MM, preserve_topology=False)
    return shapely.get_coordinates(lines), starts(shapely.get_num_coordinates(lines))
