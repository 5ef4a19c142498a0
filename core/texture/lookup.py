"""Tone at points of the surface, from its textures or from its vertices."""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from .islands import LabelImage
from .pyramid import Picture, TexturePyramids

_CHUNK_POINTS = 1 << 14  # a chunk's intermediate arrays stay in the cache
_NO_WEIGHT = 1e-6  # taps that weigh less in all say nothing


def tone_at(
    pyramids: TexturePyramids, face: IntArray, uv: FloatArray, vertex_tone: FloatArray, background_tone: float
) -> FloatArray:
    """Tone of N points of the surface, averaged over the footprint that the pyramids were built for.

    A texture is looked up trilinearly within the point's own UV island; where the island is too small for a level
    the next finer one is asked, and at last the picture itself. Alpha blends towards the background.

    Args:
        pyramids: from `build_pyramids`, of the mesh that the faces belong to.
        face: (N,) the face that each point lies on.
        uv: (N, 2).
        vertex_tone: (N,) tone from a colour attribute, for points without a texture; NaN for none.
        background_tone: where nothing is painted.

    Returns:
        (N,) 0 to 1.
    """
    tone = np.where(np.isfinite(vertex_tone), vertex_tone, background_tone)
    if not any(picture.levels for picture in pyramids.pictures):
        return tone
    texture, islands = pyramids.face_texture[face], pyramids.face_island.astype(np.int32)
    for number, picture in enumerate(pyramids.pictures):
        points = np.flatnonzero(texture == number)
        if not len(points):
            continue
        for start in range(0, len(points), _CHUNK_POINTS):
            part = points[start : start + _CHUNK_POINTS]
            at, faces = uv[part], face[part]
            if pyramids.texture_filter == "lanczos":
                paint, alpha = _nearest(picture, at)
            else:
                paint, alpha = _trilinear(picture, at, islands[faces], pyramids.face_level[faces])
            tone[part] = paint + (1.0 - alpha) * background_tone
    return np.clip(tone, 0.0, 1.0)


def _nearest(picture: Picture, uv: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Paint and alpha (n,) of the texel that each point lies in."""
    level = picture.levels[0]
    place = _within(picture, uv) * [level.width, level.height]
    column = np.clip(np.floor(place[:, 0]), 0, level.width - 1).astype(np.int64)
    row = np.clip(np.floor(place[:, 1]), 0, level.height - 1).astype(np.int64)
    index = row * level.width + column
    alpha = np.ones(len(index)) if level.alpha is None else level.alpha[index].astype(np.float64)
    return level.paint[index].astype(np.float64), alpha


def _trilinear(
    picture: Picture, uv: FloatArray, island: LabelImage, level: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Paint and alpha (n,), between the two levels nearest to each point's own.

    From the coarsest level down: points for which a level is the finer one of the two are asked there, with those
    whose island the level above did not know; a coarser level that does not know the island is left out.
    """
    x, y = (_within(picture, uv) * [picture.width, picture.height]).T.copy()
    finer = np.floor(level).astype(np.int64)
    part = level - finer
    paint, alpha = np.zeros(len(uv)), np.zeros(len(uv))
    coarse_paint, coarse_alpha = np.zeros(len(uv)), np.zeros(len(uv))
    lost = np.zeros(len(uv), dtype=bool)
    for number in range(min(int(finer.max()) + 1, len(picture.levels) - 1), -1, -1):
        above = np.flatnonzero((finer == number - 1) & (part > 0))
        if len(above):
            answer = _bilinear(picture, number, x[above], y[above], island[above])
            coarse_paint[above], coarse_alpha[above], known = answer
            part[above[~known]] = 0.0
        here = np.flatnonzero((finer == number) | lost)
        if len(here):
            paint[here], alpha[here], known = _bilinear(picture, number, x[here], y[here], island[here])
            lost[here] = ~known
    part[lost] = 0.0
    paint += part * (coarse_paint - paint)
    alpha += part * (coarse_alpha - alpha)
    rest = np.flatnonzero(lost)
    if len(rest):
        paint[rest], alpha[rest], _ = _bilinear(picture, 0, x[rest], y[rest], None)
    return paint, alpha


def _within(picture: Picture, uv: FloatArray) -> FloatArray:
    """UVs inside the picture: wrapped around where it repeats."""
    return uv - np.floor(uv) if picture.repeats else uv


def _bilinear(
    picture: Picture, number: int, x: FloatArray, y: FloatArray, island: LabelImage | None
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Paint and alpha (n,) from the four texels around each point, and the points (n,) whose island they know.

    Texels count by how much of them the island covers; with `island` None all count alike.
    """
    level, scale = picture.levels[number], 0.5**number
    x, y = x * scale - 0.5, y * scale - 0.5
    left, below = np.floor(x), np.floor(y)
    right_share, upper_share = x - left, y - below
    columns = _neighbours(left, level.width, picture.repeats)
    rows = _neighbours(below, level.height, picture.repeats)
    paint, alpha, weight = np.zeros(len(x)), np.zeros(len(x)), np.zeros(len(x))
    for row, across in zip(rows, (1.0 - upper_share, upper_share), strict=True):
        for column, along in zip(columns, (1.0 - right_share, right_share), strict=True):
            index = row * level.width + column
            share = across * along
            if island is not None:
                share *= level.island[index] == island
                if level.coverage is not None:
                    share *= level.coverage[index]
            paint += share * level.paint[index]
            if level.alpha is not None:
                alpha += share * level.alpha[index]
            weight += share
    known = weight > _NO_WEIGHT
    divisor = np.where(known, weight, 1.0)
    return paint / divisor, known * 1.0 if level.alpha is None else alpha / divisor, known


def _neighbours(first: FloatArray, count: int, repeats: bool) -> tuple[IntArray, IntArray]:
    """Texel numbers `first` and the next, brought into 0 to count - 1 by wrapping or by staying at the border."""
    low = first.astype(np.int64)
    if repeats:
        return low % count, (low + 1) % count
    return np.clip(low, 0, count - 1), np.clip(low + 1, 0, count - 1)
