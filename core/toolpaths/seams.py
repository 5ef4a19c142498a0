"""Where closed paths start."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray, IntArray
from ..pattern.grid import nearest
from ..settings import PrintSettings
from ..slicing.outlines import ranges, starts
from .moves import Feature, Paths


def seam_offsets(paths: Paths, settings: PrintSettings) -> IntArray:
    """(K,) which of its points each path starts at; 0 for open paths and for the tower.

    `rear` is the point farthest back (greatest Y); `aligned` starts at the rear on a loop's first layer and then
    stays as near as it can to a seam of the layer below.
    """
    offset = np.zeros(len(paths.layer), dtype=np.int64)
    # The tower turns its corner from layer to layer by itself.
    closed = np.flatnonzero(paths.closed & (paths.feature != Feature.TOWER))
    if len(closed) == 0:
        return offset
    count = np.diff(paths.start)[closed]
    points = paths.points[ranges(paths.start[closed], count)]
    group = starts(count)
    if settings.seam_position == "rear":
        offset[closed] = nearest(-points[:, 1], group)[0] - group[:-1]
        return offset
    layer = paths.layer[closed]
    seams = np.zeros((0, 2))
    for current in np.unique(layer):
        here = np.flatnonzero(layer == current)
        mine = points[ranges(group[here], count[here])]
        local = starts(count[here])
        chosen = nearest(_distance_to(mine, seams), local)[0]
        offset[closed[here]] = chosen - local[:-1]
        seams = mine[chosen]
    return offset


def _distance_to(points: FloatArray, seams: FloatArray) -> FloatArray:
    if len(seams) == 0:
        return -points[:, 1]
    away = points[:, None] - seams[None]
    return np.asarray((away**2).sum(axis=2).min(axis=1))
