"""Mip pyramids that keep UV islands apart: gutters do not bleed and neighbouring charts do not mix."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..model import Float32Array, FloatArray, IntArray, ToneImage, TriangleMesh
from .islands import NO_ISLAND, LabelImage
from .labels import Charts, uv_charts
from .lanczos import reduced, texel_spacing


@dataclass(frozen=True)
class Level:
    """One level of a pyramid; its texels are 2^level texels of the picture wide. Flat arrays of h · w texels.

    Attributes:
        height: h, rows.
        width: w, columns.
        paint: tone times alpha, mean over the part of the texel that its island covers.
        alpha: likewise, or None where the whole picture is opaque.
        coverage: share of the texel that its island covers, or None where that is 1 for every texel with an island.
        island: (h · w,) int32 the island that covers most of the texel, `NO_ISLAND` for none.
    """

    height: int
    width: int
    paint: Float32Array
    alpha: Float32Array | None
    coverage: Float32Array | None
    island: LabelImage


@dataclass(frozen=True)
class Picture:
    """A texture made ready for look-ups.

    Attributes:
        levels: from the finest; only one for the Lanczos filter, none for a texture that no face uses.
        height: of the original picture, texels.
        width: of the original picture, texels.
        repeats: UVs leave 0 to 1 and wrap around; otherwise the border's texels are the last.
    """

    levels: tuple[Level, ...]
    height: int
    width: int
    repeats: bool


_BAND_TEXELS, _CHUNK_FACES = 1 << 22, 1 << 17  # worked on at once


@dataclass(frozen=True)
class TexturePyramids:
    """All textures of a mesh, filtered for one footprint; look-ups with other backgrounds can share it.

    Attributes:
        texture_filter: "trilinear" or "lanczos".
        pictures: one a texture.
        face_texture: (F,) int64, -1 for none.
        face_island: (F,) int64.
        face_level: (F,) float64, level (0 the finest) whose texels are a footprint wide on the face.
    """

    texture_filter: str
    pictures: tuple[Picture, ...]
    face_texture: IntArray
    face_island: IntArray
    face_level: FloatArray


def build_pyramids(
    mesh: TriangleMesh,
    textures: tuple[ToneImage, ...],
    footprint_mm: float,
    texture_filter: str,
    charts: Charts | None = None,
) -> TexturePyramids:
    """Filter all textures of a mesh.

    Args:
        mesh: its UVs and faces tell the islands and the size of a texel on the object.
        textures: one for each number in `mesh.face_texture`.
        footprint_mm: the width on the object over which a look-up averages.
        texture_filter: "trilinear": mip maps; "lanczos": each picture is reduced once to texels of the footprint.
        charts: those of the mesh, if they are known.

    Raises:
        TextureError: a face has a texture that is not there.
    """
    charts = charts or uv_charts(mesh, sizes_of(textures))
    level = np.zeros(len(mesh.faces))
    pictures = []
    for number, (image, labels) in enumerate(zip(textures, charts.labels, strict=True)):
        height, width = image.tone.shape
        if not labels.size:
            pictures.append(Picture((), height, width, False))
            continue
        faces = np.flatnonzero(mesh.face_texture == number)
        uv = mesh.face_uv if len(faces) == len(mesh.faces) else mesh.face_uv[faces]
        base = _finest(image, labels)
        if texture_filter == "lanczos":
            corners = mesh.vertices[mesh.faces[faces]]
            levels: tuple[Level, ...] = (_reduced_level(base, corners, uv, footprint_mm),)
        else:
            levels = _halved_to_one(base)
            level[faces] = _levels(mesh, faces, (width, height), footprint_mm, len(levels))
        pictures.append(Picture(levels, height, width, bool(uv.min() < -1e-6 or uv.max() > 1 + 1e-6)))
    return TexturePyramids(texture_filter, tuple(pictures), mesh.face_texture, charts.face_island, level)


def sizes_of(textures: tuple[ToneImage, ...]) -> tuple[tuple[int, int], ...]:
    """Rows and columns of each texture."""
    return tuple((image.tone.shape[0], image.tone.shape[1]) for image in textures)


def _finest(image: ToneImage, labels: LabelImage) -> Level:
    """The picture itself, alpha premultiplied."""
    tone = np.ascontiguousarray(image.tone).ravel()
    height, width = labels.shape
    if image.alpha.min() == 1:
        return Level(height, width, tone, None, None, labels.ravel())
    alpha = np.ascontiguousarray(image.alpha).ravel()
    return Level(height, width, tone * alpha, alpha, None, labels.ravel())


def _reduced_level(base: Level, corners: FloatArray, uv: FloatArray, footprint_mm: float) -> Level:
    """The picture reduced by Lanczos to texels of a footprint; as a level, so that both filters look up alike."""
    across, up = texel_spacing(corners, uv * [base.width, base.height])
    paint, alpha = reduced(
        base.paint.reshape(base.height, base.width),
        np.ones((base.height, base.width), np.float32)
        if base.alpha is None
        else base.alpha.reshape(base.height, base.width),
        (base.island != NO_ISLAND).reshape(base.height, base.width),
        (across / footprint_mm, up / footprint_mm),
    )
    height, width = paint.shape
    return Level(height, width, paint.ravel(), alpha.ravel(), None, np.zeros(paint.size, dtype=np.int32))


def _levels(mesh: TriangleMesh, faces: IntArray, size: tuple[int, int], footprint_mm: float, count: int) -> FloatArray:
    """Level (T,) of some faces, 0 to count - 1, from their areas in mm² and in texels; 0 where either is nothing."""
    level = np.zeros(len(faces))
    for begin in range(0, len(faces), _CHUNK_FACES):
        part = faces[begin : begin + _CHUNK_FACES]
        corners, texels = mesh.vertices[mesh.faces[part]], mesh.face_uv[part] * size
        a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        area_mm2 = np.linalg.norm(np.cross(a, b), axis=1)
        p, q = texels[:, 1] - texels[:, 0], texels[:, 2] - texels[:, 0]
        area_texels = np.abs(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])
        sound = (area_mm2 > 0) & (area_texels > 0)
        ratio = np.where(sound, area_texels, 1.0) / np.where(sound, area_mm2, 1.0)
        level[begin : begin + len(part)] = np.where(sound, np.log2(footprint_mm) + 0.5 * np.log2(ratio), 0.0)
    return np.clip(level, 0.0, count - 1.0)


def _halved_to_one(base: Level) -> tuple[Level, ...]:
    """The level and all coarser ones, down to a single texel."""
    levels = [base]
    while levels[-1].height > 1 or levels[-1].width > 1:
        levels.append(_halved(levels[-1]))
    return tuple(levels)


def _halved(level: Level) -> Level:
    """The next coarser level, made some million texels at a time to hold little more than it takes."""
    rows = max(2, _BAND_TEXELS // level.width // 2 * 2)
    if rows >= level.height:
        return _halved_band(level)
    bands = [_halved_band(_band(level, row, min(row + rows, level.height))) for row in range(0, level.height, rows)]
    paint, island = (np.concatenate(parts) for parts in zip(*((b.paint, b.island) for b in bands), strict=True))
    coverage = np.concatenate([band.coverage for band in bands if band.coverage is not None])
    alpha = None if level.alpha is None else np.concatenate([band.alpha for band in bands if band.alpha is not None])
    return Level(sum(band.height for band in bands), bands[0].width, paint, alpha, coverage, island)


def _band(level: Level, first: int, end: int) -> Level:
    """Some rows of a level."""
    part = slice(first * level.width, end * level.width)
    coverage, alpha = (None if each is None else each[part] for each in (level.coverage, level.alpha))
    return Level(end - first, level.width, level.paint[part], alpha, coverage, level.island[part])


def _halved_band(level: Level) -> Level:
    """The next coarser level; odd sizes are filled up with texels that nothing covers, so no texel is stretched.

    A texel belongs to the island that covers most of it, and only that island's texels are averaged in it, each
    weighted by its coverage.
    """
    height, width = (level.height + 1) // 2, (level.width + 1) // 2
    covered = (level.island != NO_ISLAND).astype(np.float32) if level.coverage is None else level.coverage
    island, weight = (
        _children(part, level.height, level.width, filler) for part, filler in ((level.island, NO_ISLAND), (covered, 0))
    )
    values = [_children(part, level.height, level.width, 0) for part in (level.paint, level.alpha) if part is not None]
    total = weight.sum(axis=0)
    scale = np.divide(1.0, total, out=np.zeros_like(total), where=total > 0)
    means = [_weighted(weight, each) * scale for each in values]
    owner = island[0].copy()
    mixed = np.flatnonzero((island[1:] != island[0]).any(axis=0))
    labels, shares = island[:, mixed], weight[:, mixed]
    votes = np.stack([np.where(labels == mine, shares, 0).sum(axis=0) for mine in labels])
    owner[mixed] = np.take_along_axis(labels, votes.argmax(axis=0)[None], axis=0)[0]
    shares = np.where(labels == owner[mixed], shares, np.float32(0))
    total[mixed] = shares.sum(axis=0)  # more than 0: mixed texels have an island, and nothing but islands has votes
    for mean, each in zip(means, values, strict=True):
        mean[mixed] = _weighted(shares, each[:, mixed]) / total[mixed]
    return Level(height, width, means[0], means[1] if len(means) > 1 else None, total * np.float32(0.25), owner)


def _children(flat: np.ndarray, height: int, width: int, filler: int) -> np.ndarray:  # type: ignore[type-arg]
    """(4, h · w) the four texels that each coarser texel is made of."""
    image = flat.reshape(height, width)
    if height % 2 or width % 2:
        image = np.pad(image, ((0, height % 2), (0, width % 2)), constant_values=filler)
    return np.stack([image[row::2, column::2].ravel() for row in (0, 1) for column in (0, 1)])


def _weighted(weight: Float32Array, value: Float32Array) -> Float32Array:
    """Sum over the four children of weight times value."""
    total: Float32Array = weight[0] * value[0]
    for child in (1, 2, 3):
        total += weight[child] * value[child]
    return total
