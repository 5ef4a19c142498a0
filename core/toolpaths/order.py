"""In which order, and which way round, the paths of each layer are printed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..settings import PrintSettings
from ..slicing.outlines import ranges, starts
from .moves import Feature, Paths
from .seams import seam_offsets


@dataclass(frozen=True)
class OrderedPaths:
    """All paths in printing order, each point in the order of printing; closed ones repeat their first point.

    Attributes:
        points: (N, 2) mm.
        width: (N,) mm, of the line that leaves each point.
        start: (K + 1,) int64.
        layer: (K,) int64, not decreasing.
        feature: (K,) int64.
    """

    points: FloatArray
    width: FloatArray
    start: IntArray
    layer: IntArray
    feature: IntArray


def ordered(paths: Paths, settings: PrintSettings) -> OrderedPaths:
    """Order all layers: skirt, tower and supports first, then region by region, the nearest next; walls before fill.

    Args:
        paths: of all features and layers.
        settings: seam_position and outer_wall_first are used.
    """
    offset = seam_offsets(paths, settings)
    count = np.diff(paths.start)
    first = paths.start[:-1] + offset
    last = np.where(paths.closed, first, paths.start[1:] - 1)
    begin, end = _complex(paths.points[first]), _complex(paths.points[last])
    rank = _ranks(settings)[paths.feature]
    # What is not the part carries negative islands: it comes first so that a nozzle is primed before it meets the part.
    order = np.lexsort((rank, paths.island, paths.layer))
    bounds = starts(np.bincount(paths.layer, minlength=int(paths.layer.max(initial=-1)) + 1))
    sequence: list[int] = []
    flipped = np.zeros(len(count), dtype=bool)
    position = 0j
    for layer in range(len(bounds) - 1):
        members = order[bounds[layer] : bounds[layer + 1]]
        position = _order_layer(members, paths, begin, end, rank, position, sequence, flipped)
    return _laid_out(paths, np.array(sequence, dtype=np.int64), offset, flipped)


def _ranks(settings: PrintSettings) -> IntArray:
    rank = np.zeros(len(Feature), dtype=np.int64)
    walls = [Feature.OUTER_WALL, Feature.INNER_WALL]
    walls = walls if settings.outer_wall_first else walls[::-1]
    inside = [*walls, Feature.BRIDGE, Feature.SKIN, Feature.INFILL]
    for place, feature in enumerate([*inside, Feature.SUPPORT, Feature.SUPPORT_INTERFACE]):
        rank[feature] = place
    return rank


def _complex(points: FloatArray) -> np.ndarray[tuple[int, ...], np.dtype[np.complex128]]:
    return points[:, 0] + 1j * points[:, 1]


def _order_layer(
    members: IntArray,
    paths: Paths,
    begin: np.ndarray[tuple[int, ...], np.dtype[np.complex128]],
    end: np.ndarray[tuple[int, ...], np.dtype[np.complex128]],
    rank: IntArray,
    position: complex,
    sequence: list[int],
    flipped: BoolArray,
) -> complex:
    """Append one layer's paths to the sequence; returns where the nozzle ends up.

    `members` come sorted by island and rank, so every (island, rank) is a run.
    """
    key = paths.island[members] * 8 + rank[members]
    cuts = np.flatnonzero(np.diff(key)) + 1
    runs = np.split(members, cuts)
    by_island: dict[int, list[IntArray]] = {}
    for run in runs:
        if len(run):
            by_island.setdefault(int(paths.island[run[0]]), []).append(run)
    waiting = [island for island in sorted(by_island) if island >= 0]
    entries = np.array([begin[by_island[island][0][0]] for island in waiting])
    # Supports lie among the part: the nozzle is primed when it comes there.
    planned = sorted((island for island in by_island if island < 0), key=lambda island: (island < -2, island))
    while planned or waiting:
        if planned:
            island = planned.pop(0)
        else:
            nearest = int(np.argmin(np.abs(entries - position)))
            island = waiting.pop(nearest)
            entries = np.delete(entries, nearest)
        for run in by_island[island]:
            position = _chain(run, paths.closed, begin, end, position, sequence, flipped)
    return position


def _chain(
    run: IntArray,
    closed: BoolArray,
    begin: np.ndarray[tuple[int, ...], np.dtype[np.complex128]],
    end: np.ndarray[tuple[int, ...], np.dtype[np.complex128]],
    position: complex,
    sequence: list[int],
    flipped: BoolArray,
) -> complex:
    """Visit paths nearest first; open ones may be printed from either end."""
    heads, tails = begin[run], end[run]
    if len(run) > 1 or not closed[run[0]]:
        free = np.ones(len(run), dtype=bool)
        for _ in range(len(run)):
            to_head = np.where(free, np.abs(heads - position), np.inf)
            to_tail = np.where(free, np.abs(tails - position), np.inf)
            a, b = int(np.argmin(to_head)), int(np.argmin(to_tail))
            turn = bool(to_tail[b] < to_head[a]) and not closed[run[b]]
            chosen = b if turn else a
            free[chosen] = False
            flipped[run[chosen]] = turn
            sequence.append(int(run[chosen]))
            position = heads[chosen] if turn else tails[chosen]
        return complex(position)
    sequence.append(int(run[0]))
    return complex(tails[0])


def _laid_out(paths: Paths, sequence: IntArray, offset: IntArray, flipped: BoolArray) -> OrderedPaths:
    count = np.diff(paths.start)[sequence]
    printed = count + paths.closed[sequence]
    row = np.repeat(sequence, printed)
    step = ranges(np.zeros(len(sequence), dtype=np.int64), printed)
    size = np.repeat(count, printed)
    local = np.where(flipped[row], size - 1 - step, (step + offset[row]) % size)
    point = paths.start[row] + local
    # A line printed backwards leaves its points by the segment that used to arrive there.
    leaving = np.where(flipped[row], paths.start[row] + np.maximum(local - 1, 0), point)
    return OrderedPaths(
        paths.points[point], paths.width[leaving], starts(printed), paths.layer[sequence], paths.feature[sequence]
    )
