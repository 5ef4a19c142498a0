"""Mip pyramids that keep UV islands apart: gutters do not bleed and neighboring charts do not mix."""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, Float32Array, FloatArray, IntArray, ToneImage, TriangleMesh
from ..parallel import CHUNK_ROWS
from ..records import dataclass
from .charts import Charts, uv_charts
from .island_levels import BAND_TEXELS, IslandLevel, children, island_levels
from .islands import NO_ISLAND, LabelImage
from .lanczos import reduced, texel_spacing


@dataclass(frozen=True)
class Level:
    """One level of a pyramid; its texels are 2^level texels of the picture wide. Flat arrays of h · w texels.

    Attributes:
        height: h, rows.
        width: w, columns.
        paint: tone times alpha, mean over the texel with 0 where its island does not cover it.
        alpha: likewise, or None where the whole picture is opaque.
        coverage: share of the texel that its island covers, or None where that is 1 for every texel with an island.
        island: (h · w,) the island that covers most of the texel, `NO_ISLAND` for none.
        uniform: (h · w,) whether the texel, its right neighbor and the two above are wholly of one island, or of none.
    """

    height: int
    width: int
    paint: Float32Array
    alpha: Float32Array | None
    coverage: Float32Array | None
    island: LabelImage
    uniform: BoolArray


@dataclass(frozen=True)
class Picture:
    """A texture made ready for look-ups.

    Attributes:
        levels: from the finest; only one for the Lanczos filter, none for a texture that no face uses.
        height: of the original picture, texels.
        width: of the original picture, texels.
        repeats: whether UVs leave 0 to 1 and wrap around; otherwise they are clamped to the border.
    """

    levels: tuple[Level, ...]
    height: int
    width: int
    repeats: bool


@dataclass(frozen=True)
class TexturePyramids:
    """All textures of a mesh, filtered for one footprint, for any background tone.

    Attributes:
        texture_filter: "trilinear" or "lanczos".
        pictures: one per texture.
        face_texture: (F,) int64, -1 for none.
        face_island: (F,).
        face_level: (F,) float64, level (0 the finest) whose texels are a footprint wide on the face.
    """

    texture_filter: str
    pictures: tuple[Picture, ...]
    face_texture: IntArray
    face_island: LabelImage
    face_level: FloatArray


def build_pyramids(
    mesh: TriangleMesh,
    textures: tuple[ToneImage, ...],
    footprint_mm: float,
    texture_filter: str,
    charts: Charts | None = None,
    islands: tuple[tuple[IslandLevel, ...], ...] | None = None,
) -> TexturePyramids:
    """Filter all textures of a mesh.

    Args:
        mesh: its UVs and faces define the islands and the size of a texel on the object.
        textures: one for each number in `mesh.face_texture`.
        footprint_mm: the width on the object over which a look-up averages.
        texture_filter: "trilinear": mip maps; "lanczos": each picture is reduced once to texels of the footprint.
        charts: those of the mesh, if they are known.
        islands: their levels, if they are known.

    Raises:
        TextureError: a face has a texture that is not there.
    """
    charts = charts or uv_charts(mesh, sizes_of(textures))
    islands = islands or island_levels(charts, texture_filter)
    level = np.zeros(len(mesh.faces))
    pictures = []
    for number, (image, own) in enumerate(zip(textures, islands, strict=True)):
        height, width = image.tone.shape
        if not own:
            pictures.append(Picture((), height, width, False))
            continue
        faces = np.flatnonzero(mesh.face_texture == number)
        uv = mesh.face_uv if len(faces) == len(mesh.faces) else mesh.face_uv[faces]
        base = _finest(image, own[0])
        if texture_filter == "lanczos":
            corners = mesh.vertices[mesh.faces[faces]]
            levels: tuple[Level, ...] = (_reduced_level(base, corners, uv, footprint_mm),)
        else:
            levels = _averaged(base, own[1:])
            for begin in range(0, len(faces), CHUNK_ROWS):
                some = faces[begin : begin + CHUNK_ROWS]
                texels = charts.face_area.take(some) * (width * height)
                level[some] = _levels(mesh.face_area.take(some), texels, footprint_mm, len(levels))
        pictures.append(Picture(levels, height, width, bool(uv.min() < -1e-6 or uv.max() > 1 + 1e-6)))
    return TexturePyramids(texture_filter, tuple(pictures), mesh.face_texture, charts.face_island, level)


def sizes_of(textures: tuple[ToneImage, ...]) -> tuple[tuple[int, int], ...]:
    """Rows and columns of each texture."""
    return tuple((image.tone.shape[0], image.tone.shape[1]) for image in textures)


def _finest(image: ToneImage, islands: IslandLevel) -> Level:
    """The picture itself, alpha premultiplied; texels outside the islands stay as they are, nothing reads them."""
    tone = np.ascontiguousarray(image.tone).ravel()
    if image.alpha.min() == 1:
        return _level(tone, None, islands)
    alpha = np.ascontiguousarray(image.alpha).ravel()
    return _level(tone * alpha, alpha, islands)


def _level(paint: Float32Array, alpha: Float32Array | None, islands: IslandLevel) -> Level:
    return Level(islands.height, islands.width, paint, alpha, islands.coverage, islands.island, islands.uniform)


def _reduced_level(base: Level, corners: FloatArray, uv: FloatArray, footprint_mm: float) -> Level:
    """The picture reduced by Lanczos to texels of a footprint, as a level, so that both filters are looked up alike."""
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
    none = np.zeros(0, dtype=bool)
    return Level(height, width, paint.ravel(), alpha.ravel(), None, none.astype(np.int8), none)


def _levels(area_mm2: FloatArray, area_texels: FloatArray, footprint_mm: float, count: int) -> FloatArray:
    """Level (T,) of some faces, 0 to count - 1, from their areas in mm² and in texels; 0 where either is zero."""
    area_texels = np.abs(area_texels)
    sound = (area_mm2 > 0) & (area_texels > 0)
    # A face without an area in either counts as if its texels were as wide as the footprint.
    ratio = np.divide(area_texels, area_mm2, out=np.full(len(sound), 1 / footprint_mm**2), where=sound)
    level = 0.5 * np.log2(ratio) + np.log2(footprint_mm)
    return np.asarray(np.clip(level, 0.0, count - 1.0))


def _averaged(base: Level, coarser: tuple[IslandLevel, ...]) -> tuple[Level, ...]:
    """The level and all coarser ones: a texel averages only texels of its own island, weighted by coverage."""
    levels = [base]
    for islands in coarser:
        finer, values = levels[-1], []
        child, _ = children(finer.height, finer.width, islands.mixed)
        for value in (finer.paint, finer.alpha):
            if value is not None:
                mean = _mean_of_fours(value.reshape(finer.height, finer.width)).ravel()
                if finer.coverage is None and islands.coverage is not None:
                    mean *= islands.coverage
                mean[islands.mixed] = np.where(islands.own, value.take(child), 0).sum(axis=0) / 4
                values.append(mean)
        levels.append(_level(values[0], values[1] if len(values) > 1 else None, islands))
    return tuple(levels)


def _mean_of_fours(image: Float32Array) -> Float32Array:
    """Means of 2 by 2 texels; 0 where some are beyond the picture."""
    height, width = image.shape
    mean = np.zeros(((height + 1) // 2, (width + 1) // 2), dtype=np.float32)
    inner, image = mean[: height // 2, : width // 2], image[: height // 2 * 2, : width // 2 * 2]
    rows = max(1, BAND_TEXELS // width)
    for row in range(0, len(inner), rows):
        both = image[2 * row : 2 * (row + rows) : 2] + image[2 * row + 1 : 2 * (row + rows) : 2]
        both *= np.float32(0.25)
        np.add(both[:, ::2], both[:, 1::2], out=inner[row : row + rows])
    return mean
