"""Which layers a change of the pictures may touch: a stroke is looked for in tiles of texels."""

from __future__ import annotations

from concurrent.futures import Future

import numpy as np

from ..contours.contours import Contours
from ..model import BoolArray, Float32Array, FloatArray, IntArray, ToneImage
from ..texture.pyramid import TexturePyramids

_TILES = 64  # along the longer side of a picture
_MOST_PAINTED = 0.5  # of a picture; with more of it, it is taken for another one


def other_layers(
    columns: tuple[FloatArray, ...], lines: Contours, layers: int, former: tuple[FloatArray, ...]
) -> BoolArray:
    """(L,) layers on which columns (N,) of numbers at the contour points differ from the former ones."""
    return _layers_of(
        np.logical_or.reduce([one != other for one, other in zip(former, columns, strict=True)]), lines, layers
    )


def repainted_layers(
    pictures: tuple[ToneImage, ...],
    made: Future[TexturePyramids],
    lines: Contours,
    layers: int,
    former: tuple[ToneImage, ...],
) -> BoolArray | None:
    """(L,) layers on which tones may differ, no such layer left out; None if that may be all or most layers.

    Args:
        pictures: as they are.
        made: pyramids of these, which may still be being built.
        lines: N contour points.
        layers: L.
        former: the pictures as they were.
    """
    if len(former) != len(pictures):
        return None
    painted = [_painted_tiles(one, other) for one, other in zip(former, pictures, strict=True)]
    pyramids, touched = made.result(), np.zeros(len(lines.face), dtype=bool)
    if pyramids.texture_filter == "lanczos":
        return None
    # A look-up reads four texels of the next coarser level at most, one and a half of its texels away.
    reach = 2.0 ** (np.ceil(pyramids.face_level.max(initial=0.0)) + 1)
    for number, found in enumerate(painted):
        if found is None:
            return None
        tiles, rows, columns = found
        if not tiles.any():
            continue
        others = (pyramids.face_texture != number).any()
        own = np.flatnonzero(pyramids.face_texture.take(lines.face) == number) if others else slice(None)
        near = _grown(tiles, int(np.ceil(reach / _tile_texels(pictures[number]))) + 1)
        row, column = _tile_of(lines.carried[own, 1], rows), _tile_of(lines.carried[own, 0], columns)
        touched[own] |= near.ravel().take(row * near.shape[1] + column)
    return _layers_of(touched, lines, layers)


def _painted_tiles(former: ToneImage, picture: ToneImage) -> tuple[BoolArray, float, float] | None:
    """(R, C) tiles in which a picture differs from the former one, and how many rows and columns of them it has.

    None where that is not enough to know (pictures of another size, or one of both being opaque) or not worth it.
    """
    if former.tone.shape != picture.tone.shape:
        return None
    tile, (height, width) = _tile_texels(picture), picture.tone.shape
    sampled = former.tone[::tile] != picture.tone[::tile]
    if np.count_nonzero(sampled) > _MOST_PAINTED * sampled.size:
        return None
    veiled = _differing(former.alpha, picture.alpha, tile)
    if veiled.any() and (former.alpha.min() == 1) != (picture.alpha.min() == 1):
        return None
    return veiled | _differing(former.tone, picture.tone, tile), height / tile, width / tile


def _tile_texels(picture: ToneImage) -> int:
    """The side of a picture's tiles, texels."""
    return max(*(side // _TILES for side in picture.tone.shape), 1)


def _differing(one: Float32Array, other: Float32Array, tile: int) -> BoolArray:
    """(R, C) tiles of so many texels either way in which two pictures differ."""
    height, width = one.shape
    columns = np.arange(0, width, tile)
    tiles = np.zeros((-(-height // tile), len(columns)), dtype=bool)
    for row in range(len(tiles)) if one is not other else ():
        band = slice(row * tile, (row + 1) * tile)
        if not np.array_equal(one[band], other[band]):
            tiles[row] = np.logical_or.reduceat((one[band] != other[band]).any(axis=0), columns)
    return tiles


def _grown(tiles: BoolArray, reach: int) -> BoolArray:
    """(R, C) tiles and those up to `reach` around them, wrapped at the borders, as pictures may repeat."""
    grown = tiles
    for axis in (0, 1):
        steps = range(-min(reach, tiles.shape[axis]), min(reach, tiles.shape[axis]) + 1)
        grown = np.logical_or.reduce([np.roll(grown, step, axis=axis) for step in steps])
    return grown


def _tile_of(place: FloatArray, tiles: float) -> IntArray:
    """(N,) the row or column of tiles in which U or V lies, wrapped around; there may be a part of a last one."""
    inside = place - np.floor(place)
    inside *= tiles
    found: IntArray = inside.astype(np.int64)
    return found


def _layers_of(points: BoolArray, lines: Contours, layers: int) -> BoolArray:
    """(layers,) those with points that are marked (N,)."""
    found = np.zeros(layers, dtype=bool)
    if len(points):
        found[lines.layer[np.logical_or.reduceat(points, lines.start[:-1])]] = True
    return found
