"""Seams of the print: where closed paths start and end."""

from __future__ import annotations

import numpy as np

from ..contours.grid import nearest
from ..model import BoolArray, FloatArray, IntArray
from ..paths import Feature, Paths
from ..ragged import following, preceding, ranges, starts, sums
from ..settings import PrintSettings

# A little to the right of straight back: of a back that is flat the corner is farthest, in all layers.
_REAR = (0.2, 1.0)
# What steps back less is as good as straight (mm).
_LEAST_VALLEY_MM = 0.05


def seam_offsets(paths: Paths, settings: PrintSettings) -> IntArray:
    """(K,) which of its points each path starts at; 0 for open paths and for the tower.

    `rear` is the point farthest back, of a flat back its right corner; `aligned` starts at the rear on a loop's first
    layer and then stays as near as it can to a seam of the layer below. `valley` does the same, but only where the line
    steps back into the material: in the valleys of a wave, or else in concave corners, if the loop has any. `nearest`
    depends on the way of the nozzle and is found when paths are put in order; until then it is the rear.
    """
    if settings.seam_position in ("rear", "nearest"):
        rear = nearest(-_rearwards(paths.points), paths.start)[0] - paths.start[:-1]
        return np.where(has_seam(paths), rear, 0)
    offset = np.zeros(len(paths.layer), dtype=np.int64)
    closed = np.flatnonzero(has_seam(paths))
    if len(closed) == 0:
        return offset
    count = np.diff(paths.start)[closed]
    group = starts(count)
    points = paths.points.take(ranges(paths.start[closed], count), axis=0)
    hidden = np.zeros(len(points))
    if settings.seam_position == "valley":
        hidden[~valleys(points, group, settings.wavelength / 2)] = np.inf
    layer = paths.layer[closed]
    seams = np.zeros((0, 2))
    for current in np.unique(layer):
        here = np.flatnonzero(layer == current)
        member = ranges(group[here], count[here])
        mine = points[member]
        local = starts(count[here])
        chosen = nearest(_distance_to(mine, seams) + hidden[member], local)[0]
        offset[closed[here]] = chosen - local[:-1]
        seams = mine[chosen]
    return offset


def has_seam(paths: Paths) -> BoolArray:
    """(K,) closed paths, but for those of the tower, which turns its corner from layer to layer by itself."""
    return np.asarray(paths.closed & (paths.feature != Feature.TOWER))


def valleys(points: FloatArray, start: IntArray, reach: float) -> BoolArray:
    """(N,) bool, points in the valleys of closed loops; all points of a loop without any.

    The depth of a point is how far it lies to the left, where the material is, of the chord from `reach` before it to
    `reach` behind it on the loop. A valley is a local maximum of at least half the loop's greatest depth.

    Args:
        points: (N, 2) mm, of loops with the material to their left: counter-clockwise, holes clockwise.
        start: (M + 1,) where each loop starts.
        reach: mm, half a wave's length.
    """
    depth = _depths(points, start, reach)
    deepest = np.maximum.reduceat(depth, start[:-1])
    limit = np.repeat(np.maximum(deepest / 2, _LEAST_VALLEY_MM), np.diff(start))
    valley = (depth >= limit) & (depth >= depth[following(start)]) & (depth >= depth[preceding(start)])
    return np.asarray(valley | np.repeat(deepest < _LEAST_VALLEY_MM, np.diff(start)))


def _depths(points: FloatArray, start: IntArray, reach: float) -> FloatArray:
    """(N,) mm to the left of the chord from `reach` before each point to `reach` behind it."""
    loop = np.repeat(np.arange(len(start) - 1), np.diff(start))
    length = np.hypot(*(points[following(start)] - points).T)
    around = np.maximum(sums(length, start), 1e-12)  # a loop may have shrunk to a point
    arc = np.cumsum(length) - length
    begin = arc[start[:-1]]
    reach_of = np.minimum(reach, around / 4)[loop]

    def at(shift: FloatArray) -> FloatArray:
        """The places that lie so far along the loop."""
        place = begin[loop] + (arc - begin[loop] + shift) % around[loop]
        before = np.clip(np.searchsorted(arc, place, side="right") - 1, start[loop], start[loop + 1] - 1)
        share = (place - arc[before]) / np.maximum(length[before], 1e-12)
        return np.asarray(points[before] + share[:, None] * (points[following(start)[before]] - points[before]))

    back, ahead = at(-reach_of), at(reach_of)
    chord, way = ahead - back, points - back
    cross = chord[:, 0] * way[:, 1] - chord[:, 1] * way[:, 0]
    return np.asarray(cross / np.maximum(np.hypot(*chord.T), 1e-12))


def _distance_to(points: FloatArray, seams: FloatArray) -> FloatArray:
    """(N,) mm², to the nearest of the seams below (S, 2); without any, less the farther a point lies to the rear."""
    if len(seams) == 0:
        return -_rearwards(points)
    away = points[:, None] - seams[None]
    return np.asarray((away**2).sum(axis=2).min(axis=1))


def _rearwards(points: FloatArray) -> FloatArray:
    """(N,) how far points (N, 2) lie to the rear; `@` would wake the threads of OpenBLAS, which then spin."""
    return np.asarray(np.einsum("ij,j", points, _REAR))
