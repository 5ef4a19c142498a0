"""Which island each texel of a mip pyramid belongs to, level by level, whatever the pictures show."""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, Float32Array, IntArray
from ..records import dataclass
from .charts import Charts
from .islands import NO_ISLAND, LabelImage

BAND_TEXELS = 1 << 17  # processed at once, so that they stay in the cache


@dataclass(frozen=True)
class IslandLevel:
    """The islands of one level; its texels are 2^level texels of the picture wide. Flat arrays of h · w texels.

    Attributes:
        height: h, rows.
        width: w, columns.
        coverage: share of the texel that its island covers, or None where that is 1 for every texel with an island.
        island: (h · w,) the island that covers most of the texel, `NO_ISLAND` for none.
        uniform: (h · w,) whether the texel, its right neighbor and the two above are wholly of one island, or of none.
        mixed: (n,) texels that are neither wholly covered by one island nor wholly empty.
        own: (4, n) which of their `children` are of the same island.
    """

    height: int
    width: int
    coverage: Float32Array | None
    island: LabelImage
    uniform: BoolArray
    mixed: IntArray
    own: BoolArray


def island_levels(charts: Charts, texture_filter: str) -> tuple[tuple[IslandLevel, ...], ...]:
    """For each texture its levels from the finest down to a single texel.

    The Lanczos filter needs only the finest level; a texture that no face uses gets none.
    """
    return tuple(_levels(labels, texture_filter == "lanczos") if labels.size else () for labels in charts.labels)


def _levels(labels: LabelImage, only_finest: bool) -> tuple[IslandLevel, ...]:
    (height, width), none = labels.shape, np.zeros(0, dtype=np.int64)
    uniform = _uniform(height, width, labels.ravel(), none)
    levels = [IslandLevel(height, width, None, labels.ravel(), uniform, none, np.zeros((4, 0), dtype=bool))]
    while not only_finest and (levels[-1].height > 1 or levels[-1].width > 1):
        levels.append(_halved(levels[-1]))
    return tuple(levels)


def _halved(level: IslandLevel) -> IslandLevel:
    """The next coarser level; odd sizes are padded with uncovered texels, so no texel is stretched.

    A texel belongs to the island that covers most of it.
    """
    height, width = (level.height + 1) // 2, (level.width + 1) // 2
    even = (slice(None, None, 2), slice(None, None, 2))
    owner = level.island.reshape(level.height, level.width)[even].ravel()
    mixed = np.flatnonzero(~level.uniform.reshape(level.height, level.width)[even])
    child, within = children(level.height, level.width, mixed)
    label = np.where(within, level.island.take(child), NO_ISLAND).astype(level.island.dtype)
    share = np.ones(child.shape, np.float32) if level.coverage is None else level.coverage.take(child)
    share = np.where(label == NO_ISLAND, np.float32(0), share)
    votes = np.stack([np.where(label == mine, share, 0).sum(axis=0) for mine in label])
    owner[mixed] = np.take_along_axis(label, votes.argmax(axis=0)[None], axis=0)[0]
    own = (label == owner[mixed]) & (share > 0)
    coverage = (owner != NO_ISLAND).astype(np.float32)
    coverage[mixed] = np.where(own, share, 0).sum(axis=0) / 4
    uniform = _uniform(height, width, owner, mixed[coverage[mixed] < 1])
    return IslandLevel(height, width, coverage, owner, uniform, mixed, own)


def children(height: int, width: int, texel: IntArray) -> tuple[IntArray, BoolArray]:
    """(4, n) texels of a level (height, width) under `texel` (n,) of the next one, and (4, n) whether they exist.

    Texels beyond the picture are given as texel 0.
    """
    row, column = np.divmod(texel, (width + 1) // 2)
    rows, columns = 2 * row + [[0], [0], [1], [1]], 2 * column + [[0], [1], [0], [1]]
    within = (rows < height) & (columns < width)
    return np.where(within, rows * width + columns, 0), within


def _uniform(height: int, width: int, island: LabelImage, partly: IntArray) -> BoolArray:
    """See `IslandLevel.uniform`; `partly` are the texels that are not wholly covered."""
    uniform = np.zeros(height * width, dtype=bool)
    last = height * width - width - 1
    for begin in range(0, last, BAND_TEXELS):
        end = min(begin + BAND_TEXELS, last)
        part, here = uniform[begin:end], island[begin:end]
        np.equal(here, island[begin + width + 1 : end + width + 1], out=part)
        part &= here == island[begin + 1 : end + 1]
        part &= here == island[begin + width : end + width]
    uniform[width - 1 :: width] = False
    for step in (0, 1, width, width + 1):  # of the quad
        uniform[np.maximum(partly - step, 0)] = False
    return uniform
