"""Tone at points of the surface, from its textures or from its vertices."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..model import BoolArray, Float32Array, FloatArray, IntArray
from .islands import LabelImage
from .pyramid import Picture, TexturePyramids

_CHUNK_POINTS = 1 << 14  # a chunk's intermediate arrays stay in the cache
_HALF = np.float32(0.5)
_NO_WEIGHT = 1e-6  # below this total weight the taps have no value


def tone_at(
    pyramids: TexturePyramids, face: IntArray, uv: FloatArray, vertex_tone: FloatArray | None, background_tone: float
) -> FloatArray:
    """Tone of N points of the surface, averaged over the footprint that the pyramids were built for.

    A texture is looked up trilinearly within the point's own UV island; where the island is too small for a level,
    the next finer one is used, and finally the picture itself. Alpha blends towards the background.

    Args:
        pyramids: from `build_pyramids`, of the mesh that the faces belong to.
        face: (N,) the face that each point lies on.
        uv: (N, 2).
        vertex_tone: (N,) tone from a color attribute, for points without a texture; NaN or None for none.
        background_tone: where nothing is painted.

    Returns:
        (N,) 0 to 1.
    """
    tone = np.full(len(face), background_tone)
    if vertex_tone is not None:
        np.copyto(tone, vertex_tone, where=np.isfinite(vertex_tone))
    finest, columns = pyramids.face_level.astype(np.int8), np.ascontiguousarray(uv.T)
    for number, picture in enumerate(pyramids.pictures):
        if not picture.levels:
            continue
        finer = np.where(pyramids.face_texture == number, finest, np.int8(-1)).take(face)
        for level in range(int(finer.max(initial=-1)) + 1):
            points, near = np.flatnonzero(finer == level), [np.zeros(0, dtype=np.int64)]
            for some in _chunks(points):
                places = _places(pyramids, picture, face, columns, some)
                if pyramids.texture_filter == "lanczos":
                    values = _nearest(picture, *places[:2])
                else:
                    values, known = _trilinear(picture, level, *places)
                    near.append(some.compress(~known))
                tone[some] = _blended(values, background_tone)
            for some in _chunks(np.concatenate(near)):
                places = _places(pyramids, picture, face, columns, some)
                tone[some] = _blended(_near_borders(picture, level, *places), background_tone)
    return np.clip(tone, 0.0, 1.0, out=tone)


def _chunks(points: IntArray) -> Iterator[IntArray]:
    """Some points at a time."""
    return (points[begin : begin + _CHUNK_POINTS] for begin in range(0, len(points), _CHUNK_POINTS))


def _places(
    pyramids: TexturePyramids, picture: Picture, face: IntArray, uv: FloatArray, some: IntArray
) -> tuple[FloatArray, FloatArray, LabelImage, FloatArray]:
    """Where some of the points (n,) lie: x and y in texels of the picture, the island, and the level between levels."""
    u, v = (column.take(some) for column in uv)
    x, y, on = _within(picture, u) * picture.width, _within(picture, v) * picture.height, face.take(some)
    return x, y, pyramids.face_island.take(on), pyramids.face_level.take(on)


def _blended(values: list[Float32Array], background_tone: float) -> Float32Array:
    """Paint (n,) as it is, or with alpha (n,) over the background."""
    return values[0] if len(values) == 1 else values[0] + (1.0 - values[1]) * background_tone


def _within(picture: Picture, place: FloatArray) -> FloatArray:
    """U or V (n,) inside the picture: wrapped around if it repeats, else clamped to its border."""
    return np.asarray(place - np.floor(place) if picture.repeats else np.clip(place, 0.0, 1.0))


def _nearest(picture: Picture, x: FloatArray, y: FloatArray) -> list[Float32Array]:
    """Paint and, if there is any, alpha (n,) of the texel that each point lies in."""
    level = picture.levels[0]
    column = np.minimum(x * (level.width / picture.width), level.width - 1).astype(np.int64)
    row = np.minimum(y * (level.height / picture.height), level.height - 1).astype(np.int64)
    index = row * level.width + column
    return [values.take(index) for values in (level.paint, level.alpha) if values is not None]


def _trilinear(
    picture: Picture, finer: int, x: FloatArray, y: FloatArray, island: LabelImage, level: FloatArray
) -> tuple[list[Float32Array], BoolArray]:
    """Paint and, if there is any, alpha (n,) at a `level` (n,) between the level `finer` and the next coarser one.

    Also returns (n,) where they are known, as `_within_island` does.
    """
    place = x.astype(np.float32), y.astype(np.float32)
    values, known = _within_island(picture, finer, *place, island)
    if finer + 1 < len(picture.levels):
        share = (level - finer).astype(np.float32)
        coarse, coarse_known = _within_island(picture, finer + 1, *place, island)
        known &= coarse_known
        values = [_mixed(one, other, share) for one, other in zip(values, coarse, strict=True)]
    return values, known


def _within_island(
    picture: Picture, number: int, x: Float32Array, y: Float32Array, island: LabelImage
) -> tuple[list[Float32Array], BoolArray]:
    """Paint and, if there is any, alpha (n,) from the four texels around each point.

    Also returns (n,) whether the island covers all four of them; elsewhere the values are meaningless.
    """
    level = picture.levels[number]
    (left, right_share), (below, upper_share) = _between_texels(x, number), _between_texels(y, number)
    corner = below.astype(np.int64)
    corner *= level.width
    corner += left.astype(np.int64)
    # A place before the first texel wraps to one at the end of a row, and those are never uniform.
    known = level.uniform.take(corner, mode="wrap") & (level.island.take(corner, mode="wrap") == island)
    answers = []
    for values in (level.paint, level.alpha):
        if values is not None:
            texels = (values.take(corner + step, mode="clip") for step in (0, 1, level.width, level.width + 1))
            lower, lower_right, upper, upper_right = texels
            lower, upper = _mixed(lower, lower_right, right_share), _mixed(upper, upper_right, right_share)
            answers.append(_mixed(lower, upper, upper_share))
    return answers, known


def _between_texels(place: Float32Array, number: int) -> tuple[Float32Array, Float32Array]:
    """(n,) the texel of a level whose middle lies before each place, -1 or more, and how far on to the next it lies."""
    share = place * np.float32(0.5**number) - _HALF
    first = np.floor(share)
    share -= first
    return first, share


def _mixed(first: Float32Array, second: Float32Array, share: Float32Array) -> Float32Array:
    """(n,) linear interpolation from the first to the second, in place of the second."""
    second -= first
    second *= share
    second += first
    return second


def _near_borders(
    picture: Picture, finer: int, x: FloatArray, y: FloatArray, island: LabelImage, level: FloatArray
) -> list[Float32Array]:
    """Paint and, if there is any, alpha (n,) as `_trilinear`, near other islands.

    Points whose island is missing in the finer level use the next finer one, and so on, and finally the picture with
    any island; a coarser level without the island is left out.
    """
    across, up, share = (column.astype(np.float32) for column in (x, y, level - finer))
    paint, alpha = np.zeros((2, len(x)), dtype=np.float32)
    lost = np.arange(len(x))
    for number in range(finer, -1, -1):
        paint[lost], alpha[lost], known = _bilinear(picture, number, across[lost], up[lost], island[lost])
        lost = lost[~known]
        if not len(lost):
            break
    paint[lost], alpha[lost], _ = _bilinear(picture, 0, across[lost], up[lost], None)
    if finer + 1 < len(picture.levels):
        coarse_paint, coarse_alpha, known = _bilinear(picture, finer + 1, across, up, island)
        known[lost] = False
        share = share * known
        paint += share * (coarse_paint - paint)
        alpha += share * (coarse_alpha - alpha)
    return [paint] if picture.levels[0].alpha is None else [paint, alpha]


def _bilinear(
    picture: Picture, number: int, x: Float32Array, y: Float32Array, island: LabelImage | None
) -> tuple[Float32Array, Float32Array, BoolArray]:
    """Paint and alpha (n,) from the four texels around each point, and (n,) whether its island is among them.

    Texels are weighted by how much of them the island covers; with `island` None all weigh the same.
    """
    level = picture.levels[number]
    (left, right_share), (below, upper_share) = _between_texels(x, number), _between_texels(y, number)
    columns = _neighbors(left, level.width, picture.repeats)
    rows = _neighbors(below, level.height, picture.repeats)
    paint, alpha, weight = np.zeros((3, len(x)), dtype=np.float32)
    for row, across in zip(rows, (1 - upper_share, upper_share), strict=True):
        row *= level.width
        for column, along in zip(columns, (1 - right_share, right_share), strict=True):
            index, share = row + column, across * along
            if island is not None:
                share *= level.island.take(index) == island
            paint += share * level.paint.take(index)
            if level.alpha is not None:
                alpha += share * level.alpha.take(index)
            if level.coverage is not None:
                share *= level.coverage.take(index)
            weight += share
    known = weight > _NO_WEIGHT
    divisor = np.where(known, weight, np.float32(1))
    return paint / divisor, known.astype(np.float32) if level.alpha is None else alpha / divisor, known


def _neighbors(first: Float32Array, count: int, repeats: bool) -> tuple[IntArray, IntArray]:
    """Texel numbers `first` (-1 to count - 1) and the next ones, wrapped around or clamped to 0 to count - 1."""
    low, high = first.astype(np.int64), first.astype(np.int64) + 1
    low[low < 0] = count - 1 if repeats else 0
    high[high == count] = 0 if repeats else count - 1
    return low, high
