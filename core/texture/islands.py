"""UV islands: which faces form one chart of a texture, and which texels each chart covers."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..model import BoolArray, FloatArray, IntArray, TriangleMesh

NO_ISLAND = -1

_UV_STEP = 1e-6  # UVs nearer than this are the same; a tenth of a texel of the largest pictures
_REPEATS = 4  # faces that cover a picture more often than this use it as a repeating pattern
_CHUNK_TEXELS = 1 << 22
_OVERLAP_SHARE = 0.1  # of the smaller island; less is a rounded border or a sliver

LabelImage = NDArray[np.int32]


@dataclass(frozen=True)
class _Rows:
    """The texel rows that triangles cross, R of them: row number, first and one past the last column, island."""

    row: IntArray
    first: IntArray
    last: IntArray
    island: IntArray


def uv_islands(mesh: TriangleMesh) -> IntArray:
    """Island of each face (F,), numbered from 0 over all textures; `NO_ISLAND` without a texture.

    Faces belong together where they share a vertex at the same UV and use the same texture.
    """
    island = np.full(len(mesh.faces), NO_ISLAND, dtype=np.int64)
    faces = np.flatnonzero(mesh.face_texture >= 0)
    if not len(faces):
        return island
    steps = np.rint(mesh.face_uv[faces] / _UV_STEP).astype(np.int64).view(np.uint64)
    texture = np.broadcast_to(mesh.face_texture[faces, None], (len(faces), 3)).astype(np.uint64)
    key = _mixed(mesh.faces[faces].astype(np.uint64), texture, steps[..., 0], steps[..., 1])
    _, node = np.unique(key.ravel(), return_inverse=True)
    root = components(node.reshape(-1, 3))
    island[faces] = np.unique(root, return_inverse=True)[1]
    return island


def components(groups: IntArray) -> IntArray:
    """Connected components of nodes that occur together: of groups (G, k) of node numbers, each group's root (G,).

    Every group hooks the roots of its nodes to the least of them, then all paths are halved; groups that agree are
    done, since roots only ever merge.
    """
    parent = np.arange(groups.max(initial=-1) + 1)
    open_groups = groups
    while len(open_groups):
        roots = parent[open_groups]
        least = roots.min(axis=1)
        apart = (roots != least[:, None]).any(axis=1)
        open_groups, roots, least = open_groups[apart], roots[apart], least[apart]
        np.minimum.at(parent, roots.ravel(), np.repeat(least, groups.shape[1]))
        parent = _flattened(parent)
    root: IntArray = parent[groups[:, 0]]
    return root


def rasterised(face_uv: FloatArray, island: IntArray, height: int, width: int) -> tuple[LabelImage, IntArray]:
    """Label the texels whose centres lie in the UV triangles; UVs outside 0 to 1 repeat the picture.

    Islands that lie on one another (mirrored halves share their texels) become one. A picture that is used as a
    repeating pattern is one island that covers all of it.

    Args:
        face_uv: (T, 3, 2).
        island: (T,) of each triangle.
        height: of the picture, texels.
        width: of the picture, texels.

    Returns:
        (H, W) island of each texel, `NO_ISLAND` where no chart is, and the triangles' islands (T,) after merging.
    """
    corners = face_uv * [width, height]
    first, last = _centres_between(corners[..., 1].min(axis=1), corners[..., 1].max(axis=1))
    texels = width * height
    if np.abs(_doubled_area(corners)).sum() / 2 > _REPEATS * texels or (last - first).sum() > _REPEATS * (
        texels + len(island)
    ):
        return np.full((height, width), island[0], dtype=np.int32), np.full_like(island, island[0])
    rows = _crossed_rows(corners, first.astype(np.int64), (last - first).astype(np.int64), island)
    rows = _wrapped(rows, height, width)
    disjoint = _disjoint(rows, texels, width)
    if disjoint is not None:
        return disjoint.reshape(height, width), island
    labels = np.full(texels, NO_ISLAND, dtype=np.int32)
    overlaps = [_fill(labels, chunk, width) for chunk in _chunks(rows)]
    merged = _merged(np.concatenate(overlaps), labels, island)
    if merged is not None:
        labels = np.append(merged, NO_ISLAND)[labels].astype(np.int32)
        island = merged[island]
    return labels.reshape(height, width), island


def _mixed(*parts: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """One 64-bit key of several numbers; unlike ones differ but for a chance of about n² / 2⁶⁵."""
    key = np.zeros(parts[0].shape, dtype=np.uint64)
    for part in parts:
        key = (key ^ part) * np.uint64(0x9E3779B97F4A7C15)
        key ^= key >> np.uint64(29)
        key *= np.uint64(0xBF58476D1CE4E5B9)
        key ^= key >> np.uint64(32)
    return key


def _flattened(parent: IntArray) -> IntArray:
    """Every node's root."""
    while True:
        above: IntArray = parent[parent]
        if np.array_equal(above, parent):
            return parent
        parent = above


def _doubled_area(corners: FloatArray) -> FloatArray:
    """(T,) twice the signed area of plane triangles (T, 3, 2)."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area: FloatArray = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return area


def _centres_between(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """First and one past the last texel whose centre is in [low, high)."""
    return np.ceil(low - 0.5), np.ceil(high - 0.5)


def _crossed_rows(corners: FloatArray, first: IntArray, count: IntArray, island: IntArray) -> _Rows:
    """The spans of texels inside each triangle.

    Edges run from their lower to their upper end, so that two triangles cut a shared edge at the very same place and
    leave no texel out and none twice.
    """
    following = np.roll(corners, -1, axis=1)
    upward = (corners[..., 1] < following[..., 1]) | (
        (corners[..., 1] == following[..., 1]) & (corners[..., 0] <= following[..., 0])
    )
    low = np.where(upward[..., None], corners, following)
    high = np.where(upward[..., None], following, corners)
    rise = high[..., 1] - low[..., 1]
    slope = (high[..., 0] - low[..., 0]) / np.where(rise > 0, rise, 1.0)
    row = np.arange(count.sum()) + np.repeat(first - (np.cumsum(count) - count), count)
    centre = row + 0.5
    left, right = np.full(len(row), np.inf), np.full(len(row), -np.inf)
    for edge in range(3):
        x, bottom, top, lean = (
            np.repeat(values[:, edge], count) for values in (low[..., 0], low[..., 1], high[..., 1], slope)
        )
        at = x + (centre - bottom) * lean
        crossed = (centre >= bottom) & (centre < top)
        left = np.where(crossed, np.minimum(left, at), left)
        right = np.where(crossed, np.maximum(right, at), right)
    start, end = _centres_between(left, right)
    some = end > start
    owner = np.repeat(island, count)[some]
    return _Rows(row[some], start[some].astype(np.int64), end[some].astype(np.int64), owner)


def _wrapped(rows: _Rows, height: int, width: int) -> _Rows:
    """The same texels in rows that lie within the picture."""
    row, first, last, island = rows.row % height, rows.first % width, rows.last, rows.island
    last = last - rows.first + first
    parts = [_Rows(row, first, np.minimum(last, width), island)]
    while (last > width).any():
        over = last > width
        row, last, island = row[over], last[over] - width, island[over]
        parts.append(_Rows(row, np.zeros_like(row), np.minimum(last, width), island))
    return _Rows(
        np.concatenate([part.row for part in parts]),
        np.concatenate([part.first for part in parts]),
        np.concatenate([part.last for part in parts]),
        np.concatenate([part.island for part in parts]),
    )


def _disjoint(rows: _Rows, texels: int, width: int) -> LabelImage | None:
    """The flat picture of rows of which none share a texel unless all are of one island; None where some do."""
    begin, end = rows.row * width + rows.first, rows.row * width + rows.last
    order = np.argsort(begin, kind="stable")
    begin, end = begin[order], end[order]
    if len(begin) and rows.island.min() == rows.island.max():
        begin[1:] = np.maximum(begin[1:], np.maximum.accumulate(end)[:-1])  # each row without what is there already
        end = np.maximum(begin, end)
    if (begin[1:] < end[:-1]).any():
        return None
    # In turns: a gap without an island, a row, a gap, …
    bounds = np.concatenate([[0], np.stack([begin, end], axis=1).ravel(), [texels]])
    island = np.full(2 * len(begin) + 1, NO_ISLAND, dtype=np.int32)
    island[1::2] = rows.island[order]
    return np.repeat(island, np.diff(bounds))


def _chunks(rows: _Rows) -> list[_Rows]:
    """The rows in parts of at most about `_CHUNK_TEXELS` texels."""
    part = np.cumsum(rows.last - rows.first) // _CHUNK_TEXELS
    bounds = [0, *(np.flatnonzero(np.diff(part)) + 1), len(part)]
    return [_Rows(rows.row[a:b], rows.first[a:b], rows.last[a:b], rows.island[a:b]) for a, b in pairwise(bounds)]


def _fill(labels: LabelImage, rows: _Rows, width: int) -> IntArray:
    """Write the rows into the flat picture; returns (n, 2) islands that met at a texel, once for each such texel."""
    count = rows.last - rows.first
    begin = rows.first + rows.row * width
    index = np.arange(count.sum()) + np.repeat(begin - (np.cumsum(count) - count), count)
    island = np.repeat(rows.island.astype(np.int32), count)
    before = labels[index]
    labels[index] = island
    after = labels[index]
    met = ((before != NO_ISLAND) & (before != island)) | (after != island)
    mine, other = island[met], np.where(after[met] != island[met], after[met], before[met])
    pairs: IntArray = np.stack([mine, other], axis=1).astype(np.int64)
    return pairs


def _merged(overlaps: IntArray, labels: LabelImage, island: IntArray) -> IntArray | None:
    """New number of each island once those that lie on one another are one, None where none do."""
    if not len(overlaps):
        return None
    count = int(island.max()) + 1
    pairs = np.sort(overlaps, axis=1)
    pair, shared = np.unique(pairs[:, 0] * count + pairs[:, 1], return_counts=True)
    first, second = pair // count, pair % count
    texels = np.bincount(labels[labels != NO_ISLAND], minlength=count)
    hidden = np.bincount(first, shared, count) + np.bincount(second, shared, count)
    size = np.maximum(np.minimum((texels + hidden)[first], (texels + hidden)[second]), 1)
    stacked: BoolArray = shared > _OVERLAP_SHARE * size
    if not stacked.any():
        return None
    everyone = np.repeat(np.arange(count)[:, None], 2, axis=1)
    root = components(np.concatenate([everyone, np.stack([first[stacked], second[stacked]], axis=1)]))
    merged: IntArray = root[:count]
    return merged
