"""Labels: which texels of a picture each UV island covers, found row by row between the edges of its charts."""

from __future__ import annotations

from dataclasses import fields
from itertools import pairwise

import numpy as np

from ..mesh.components import components
from ..model import FloatArray, IntArray
from ..ragged import ranges
from ..records import dataclass
from .chart_edges import ChartEdges, chart_edges, first_center
from .islands import NO_ISLAND, LabelImage

_REPEATS = 4  # faces that cover a picture more often than this use it as a repeating pattern
_CHUNK_ROWS = 1 << 18  # worked on at once
_OVERLAP_SHARE = 0.1  # of the smaller island; less is a rounded border or a sliver
_MOST_KEYS = 1 << 61


@dataclass(frozen=True)
class _Rows:
    """The rows of texels within the charts, R of them, as stretches of the flat picture.

    Attributes:
        begin: (R,) int32, the first texel.
        end: (R,) int32, one past the last texel.
        island: (R,) that each row belongs to.
    """

    begin: LabelImage
    end: LabelImage
    island: LabelImage


def rasterized(
    face_uv: FloatArray, area: FloatArray, island: LabelImage, height: int, width: int, place: IntArray
) -> tuple[LabelImage, LabelImage]:
    """Label the texels whose centers lie in the UV triangles; UVs outside 0 to 1 repeat the picture.

    Islands that lie on one another (mirrored halves share their texels) become one. A picture that is used as a
    repeating pattern is one island that covers all of it.

    Args:
        face_uv: (T, 3, 2).
        area: (T,) see `uv_areas`.
        island: (T,) of each triangle.
        height: of the picture, texels.
        width: of the picture, texels.
        place: (T, 3) the same number where corners of an island meet; the fewer do, the longer it takes.

    Returns:
        (H, W) island of each texel, `NO_ISLAND` where no chart is, and the triangles' islands (T,) after merging.
    """
    texels, size = width * height, np.array([width, height])
    edges = chart_edges(face_uv, np.sign(area), place, island, size)
    row, end = (first_center(ends[:, 1]).astype(np.int64) for ends in (edges.low, edges.high))
    count = end - row
    if np.abs(area).sum() > _REPEATS or count.sum() > _REPEATS * (texels + len(island)):
        return np.full((height, width), island[0]), np.full_like(island, island[0])
    labels, merged = _painted(_stretches(edges, row, count, size), texels, int(island.max()) + 1)
    return labels.reshape(height, width), island if merged is None else merged[island]


def _parts(size: IntArray | LabelImage, most: int) -> list[slice]:
    """Consecutive parts of members of the given sizes (N,), each of a total size of about `most`."""
    part = np.cumsum(size, dtype=np.int64) // most
    bounds = [0, *(np.flatnonzero(np.diff(part)) + 1).tolist(), len(part)]
    return [slice(first, end) for first, end in pairwise(bounds)]


def _stretches(edges: ChartEdges, first: IntArray, count: IntArray, size: IntArray) -> _Rows:
    """The texels between E edges that cross `count` rows (E,) from the row `first` (E,); `size` is (w, h).

    Along each row of each island, edges where the chart begins and edges where it ends are counted against each other.
    Edges run from their lower to their upper end, so that two charts cut a shared edge at the very same place and
    leave no texel out and none twice.
    """
    if not count.any():
        none = np.zeros(0, dtype=np.int32)
        return _Rows(none, none, edges.island[:0])
    bottom, lines = int(first.min()), int((first + count).max() - first.min())
    left = int(np.minimum(edges.low[:, 0], edges.high[:, 0]).min()) - 2
    span = 2 * (int(np.maximum(edges.low[:, 0], edges.high[:, 0]).max()) - left + 3)
    parts = [_crossings(edges, part, first[part], count[part]) for part in _parts(count, _CHUNK_ROWS)]
    island, row, column = (np.concatenate(values) for values in zip(*parts, strict=True))
    line, names = island * lines + (row - bottom), None
    if (int(edges.island.max()) + 1) * lines * span > _MOST_KEYS:  # charts far out in the plane
        names, line = np.unique(line, return_inverse=True)
    key = line * span + (column - 2 * left)
    key.sort()
    closed = np.flatnonzero(np.cumsum(1 - 2 * (key & 1)) == 0)
    begin, end = key[np.append(0, closed[:-1] + 1)] >> 1, key[closed] >> 1
    some = end > begin
    line, start = np.divmod(begin[some], span // 2)
    island, row = np.divmod(line if names is None else names[line], lines)
    start += left
    owner = island.astype(edges.island.dtype)
    return _wrapped(row + bottom, start, start + (end - begin)[some], owner, size)


def _crossings(edges: ChartEdges, part: slice, first: IntArray, count: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Island, row and column (Q,) of the first texel on the right of some edges in each row that they cross.

    The column is doubled, and odd where the chart ends there.
    """
    low, high = edges.low[part], edges.high[part]
    rise = high[:, 1] - low[:, 1]
    slope = (high[:, 0] - low[:, 0]) / np.where(rise > 0, rise, 1.0)
    edge, row = np.repeat(np.arange(len(count)), count), ranges(first, count)
    at = low[edge, 0] + (row + 0.5 - low[edge, 1]) * slope[edge]
    column = 2 * first_center(at).astype(np.int64) + edges.ends[part][edge]
    return edges.island[part][edge].astype(np.int64), row, column


def _wrapped(row: IntArray, first: IntArray, last: IntArray, island: LabelImage, size: IntArray) -> _Rows:
    """The same texels within the picture: of rows, from the column `first` to the one before `last` (R,) each."""
    width, height = size
    row, begin = row % height, first % width
    last = last - first + begin
    parts = [(row, begin, np.minimum(last, width), island)]
    while (last > width).any():
        over = last > width
        row, last, island = row[over], last[over] - width, island[over]
        parts.append((row, np.zeros_like(row), np.minimum(last, width), island))
    return _joined(
        [
            _Rows((row * width + begin).astype(np.int32), (row * width + end).astype(np.int32), owner)
            for row, begin, end, owner in parts
        ]
    )


def _joined(parts: list[_Rows]) -> _Rows:
    """All rows of several tables."""
    return _Rows(*(np.concatenate([getattr(part, column.name) for part in parts]) for column in fields(_Rows)))


def _painted(rows: _Rows, texels: int, islands: int) -> tuple[LabelImage, LabelImage | None]:
    """The flat picture of rows, and the new numbers of islands that lie on one another, None where none do.

    Texels that two islands still share go to the row that begins first.
    """
    order = np.argsort(rows.begin, kind="stable")
    begin, end, island = rows.begin[order], rows.end[order], rows.island[order]
    reach = np.append(np.zeros(1, np.int32), np.maximum.accumulate(end)[:-1])[: len(end)]  # of the rows before
    farthest = np.maximum.accumulate(np.where(end > reach, np.arange(len(end)), 0))
    under = np.flatnonzero(reach > begin)
    above = farthest[under - 1]
    shared = np.minimum(end[under], reach[under]) - begin[under]
    covered = np.bincount(island, end - begin, islands).astype(np.int64)
    merged = _merged(covered, np.stack([island[under], island[above]], axis=1), shared)
    begin = np.maximum(begin, reach)
    end = np.maximum(begin, end)
    # In turns: a gap without an island, a row, a gap, …
    bounds = np.concatenate([[0], np.stack([begin, end], axis=1).ravel(), [texels]])
    turns = np.full(2 * len(begin) + 1, NO_ISLAND, dtype=island.dtype)
    turns[1::2] = island if merged is None else merged[island]
    return np.repeat(turns, np.diff(bounds)), merged


def _merged(covered: IntArray, pair: LabelImage, shared: LabelImage) -> LabelImage | None:
    """New number of each island once those that lie on one another are one, None where none do.

    Args:
        covered: (I,) texels of each island.
        pair: (Q, 2) islands of two rows that share texels.
        shared: (Q,) how many.
    """
    unlike = pair[:, 0] != pair[:, 1]
    low, high = pair[unlike].min(axis=1).astype(np.int64), pair[unlike].max(axis=1)
    kinds, kind = np.unique(low * len(covered) + high, return_inverse=True)
    pairs = np.stack(np.divmod(kinds, len(covered)), axis=1)
    stacked = np.bincount(kind, shared[unlike], len(kinds)) > _OVERLAP_SHARE * covered[pairs].min(axis=1)
    if not stacked.any():
        return None
    everyone = np.repeat(np.arange(len(covered))[:, None], 2, axis=1)
    return components(np.concatenate([everyone, pairs[stacked]]))[: len(covered)].astype(pair.dtype)
