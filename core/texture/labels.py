"""Labels: which texels of a picture each UV island covers."""

from __future__ import annotations

from dataclasses import dataclass, fields
from itertools import pairwise

import numpy as np

from ..errors import TextureError
from ..model import BoolArray, FloatArray, IntArray, TriangleMesh
from .islands import NO_ISLAND, LabelImage, components, uv_islands

_REPEATS = 4  # faces that cover a picture more often than this use it as a repeating pattern
_CHUNK_ROWS, _CHUNK_TEXELS = 1 << 18, 1 << 20  # worked on at once
_OVERLAP_SHARE = 0.1  # of the smaller island; less is a rounded border or a sliver


@dataclass(frozen=True)
class Charts:
    """Where the islands of a mesh's UV map lie in its textures, whatever is painted there.

    Attributes:
        face_island: (F,) int64, `NO_ISLAND` without a texture.
        labels: one a texture, (h, w) the island that covers each texel; of no size where no face uses the texture.
    """

    face_island: IntArray
    labels: tuple[LabelImage, ...]


@dataclass(frozen=True)
class _Rows:
    """The rows of texels that triangles cross, R of them, as stretches of the flat picture.

    Attributes:
        begin: (R,) int32, the first texel.
        end: (R,) int32, one past the last texel.
        island: (R,) int32.
    """

    begin: LabelImage
    end: LabelImage
    island: LabelImage


def uv_charts(mesh: TriangleMesh, sizes: tuple[tuple[int, int], ...]) -> Charts:
    """The charts of a mesh.

    Args:
        mesh: F faces with UVs.
        sizes: rows and columns of each texture.

    Raises:
        TextureError: a face has a texture that is not there.
    """
    if mesh.face_texture.max(initial=-1) >= len(sizes):
        raise TextureError("a face has a texture that is not there", "assign the picture again")
    island = uv_islands(mesh)
    labels = []
    for number, (height, width) in enumerate(sizes):
        faces = np.flatnonzero(mesh.face_texture == number)
        if not len(faces):
            labels.append(np.zeros((0, 0), dtype=np.int32))
            continue
        uv = mesh.face_uv if len(faces) == len(mesh.faces) else mesh.face_uv[faces]
        image, island[faces] = rasterised(uv, island[faces], height, width)
        labels.append(image)
    return Charts(island, tuple(labels))


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
    texels = width * height
    first, last = (
        row.astype(np.int64)
        for row in _centres_between(*(height * side for side in _least_and_greatest(face_uv[..., 1])))
    )
    count = last - first
    parts = _parts(count + 1, _CHUNK_ROWS)
    if count.sum() > _REPEATS * (texels + len(island)) or _area(face_uv, parts) > _REPEATS:
        return np.full((height, width), island[0], dtype=np.int32), np.full_like(island, island[0])
    size = np.array([width, height])
    rows = _joined(
        [_crossed_rows(face_uv[part] * size, first[part], count[part], island[part], size) for part in parts]
    )
    disjoint = _disjoint(rows, texels)
    if disjoint is not None:
        return disjoint.reshape(height, width), island
    labels = np.full(texels, NO_ISLAND, dtype=np.int32)
    islands = int(island.max()) + 1
    overlaps = [_fill(labels, rows, part, islands) for part in _parts(rows.end - rows.begin, _CHUNK_TEXELS)]
    pair, shared = (np.concatenate(column) for column in zip(*overlaps, strict=True))
    merged = _merged(pair, shared, labels, islands)
    if merged is not None:
        labels = np.append(merged, NO_ISLAND)[labels].astype(np.int32)
        island = merged[island]
    return labels.reshape(height, width), island


def _least_and_greatest(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(T,) each of rows (T, 3); column by column, since numpy is slow along short rows."""
    first, second, third = values.T
    return np.minimum(np.minimum(first, second), third), np.maximum(np.maximum(first, second), third)


def _area(face_uv: FloatArray, parts: list[slice]) -> float:
    """How often triangles (T, 3, 2) cover the picture, all together."""
    total = 0.0
    for part in parts:
        a, b = face_uv[part, 1] - face_uv[part, 0], face_uv[part, 2] - face_uv[part, 0]
        total += float(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()) / 2
    return total


def _centres_between(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """First and one past the last texel whose centre is in [low, high)."""
    return np.ceil(low - 0.5), np.ceil(high - 0.5)


def _parts(size: IntArray | LabelImage, most: int) -> list[slice]:
    """Runs of members with about so much size together; `size` is (N,)."""
    part = np.cumsum(size, dtype=np.int64) // most
    bounds = [0, *(np.flatnonzero(np.diff(part)) + 1).tolist(), len(part)]
    return [slice(first, end) for first, end in pairwise(bounds)]


def _crossed_rows(corners: FloatArray, first: IntArray, count: IntArray, island: IntArray, size: IntArray) -> _Rows:
    """The texels inside each triangle (T, 3, 2): `count` (T,) rows from the row `first` (T,); `size` is (w, h).

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
    return _wrapped(row[some], start[some].astype(np.int64), end[some].astype(np.int64), owner, size)


def _wrapped(row: IntArray, first: IntArray, last: IntArray, island: IntArray, size: IntArray) -> _Rows:
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
            _Rows(*(column.astype(np.int32) for column in (row * width + begin, row * width + end, owner)))
            for row, begin, end, owner in parts
        ]
    )


def _joined(parts: list[_Rows]) -> _Rows:
    """All rows of several tables."""
    return _Rows(*(np.concatenate([getattr(part, column.name) for part in parts]) for column in fields(_Rows)))


def _disjoint(rows: _Rows, texels: int) -> LabelImage | None:
    """The flat picture of rows of which none share a texel unless all are of one island; None where some do."""
    order = np.argsort(rows.begin, kind="stable")
    begin, end = rows.begin[order], rows.end[order]
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


def _fill(labels: LabelImage, rows: _Rows, part: slice, islands: int) -> tuple[IntArray, IntArray]:
    """Write some rows into the flat picture.

    Returns:
        Pairs (n,) of islands that met at a texel, the one times the number of islands plus the other, the lesser one
        first, and how many texels each pair met at.
    """
    begin, count = rows.begin[part].astype(np.int64), np.diff([rows.begin[part], rows.end[part]], axis=0)[0]
    index = np.arange(count.sum()) + np.repeat(begin - (np.cumsum(count) - count), count)
    island = np.repeat(rows.island[part], count)
    before = labels[index]
    labels[index] = island
    after = labels[index]
    met = ((before != NO_ISLAND) & (before != island)) | (after != island)
    mine, other = island[met], np.where(after[met] != island[met], after[met], before[met])
    pair = np.minimum(mine, other).astype(np.int64) * islands + np.maximum(mine, other)
    # Along a row it is the same pair for a while.
    fresh = np.flatnonzero(np.append(True, pair[1:] != pair[:-1])[: len(pair)])
    kinds, kind = np.unique(pair[fresh], return_inverse=True)
    texels = np.bincount(kind, np.diff(np.append(fresh, len(pair))), len(kinds))
    return kinds, texels.astype(np.int64)


def _merged(pair: IntArray, shared: IntArray, labels: LabelImage, islands: int) -> IntArray | None:
    """New number of each island once those that lie on one another are one, None where none do.

    Args:
        pair: (n,) as `_fill` has them; a pair may occur more than once.
        shared: (n,) texels of each.
        labels: the flat picture.
        islands: how many there are.
    """
    if not len(pair):
        return None
    pair, kind = np.unique(pair, return_inverse=True)
    shared = np.bincount(kind, shared, len(pair))
    first, second = pair // islands, pair % islands
    texels = np.bincount(labels[labels != NO_ISLAND], minlength=islands)
    hidden = np.bincount(first, shared, islands) + np.bincount(second, shared, islands)
    size = np.maximum(np.minimum((texels + hidden)[first], (texels + hidden)[second]), 1)
    stacked: BoolArray = shared > _OVERLAP_SHARE * size
    if not stacked.any():
        return None
    everyone = np.repeat(np.arange(islands)[:, None], 2, axis=1)
    root = components(np.concatenate([everyone, np.stack([first[stacked], second[stacked]], axis=1)]))
    return np.asarray(root[:islands], dtype=np.int64)
