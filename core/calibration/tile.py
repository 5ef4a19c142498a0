"""The calibration tile: a slab whose front leans back and shows all tones side by side (paper, section 6.1)."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ..model import FloatArray, SurfaceModel, ToneImage
from ..pattern.modulation import PERIOD_LAYERS
from ..records import dataclass

DEPTH_MM = 4.0

_EDGE_MM = 5.0  # between the tones and the tile's edges, which are lit and printed differently
_LEAST_MEASURED_MM = 4.0  # height up the face
_TEXEL_MM = 0.1
_GRADIENT_MM = 60.0  # length of the gradient
_STEP_MM = 6.0  # width of a patch


@dataclass(frozen=True)
class Tile:
    """A tile to print, and the places of its tones.

    The tile stands at the origin, its front to -Y. Positions in the face are mm from the face's middle, to the right.

    Attributes:
        model: the mesh with its picture.
        slant_deg: 0 an upright face, towards 90 one that looks up.
        center: (3,) mm, the middle of the face, relative to the least corner of the model's bounds.
        width: mm, of the part that is measured.
        height: mm up the face, of the part that is measured: whole periods of the pattern.
        layers: that the measured part is high.
        place: (T,) mm in the face where each tone is to be read.
        tone: (T,) 0 black to 1 white, ascending.
    """

    model: SurfaceModel
    slant_deg: float
    center: tuple[float, float, float]
    width: float
    height: float
    layers: int
    place: FloatArray
    tone: FloatArray


def gradient_tile(slant_deg: float, layer_height: float, tones: int, window: float) -> Tile:
    """A tile with a gradient from black at the left to white at the right.

    Args:
        slant_deg: of the face, from 0 up to 85.
        layer_height: mm.
        tones: how many are to be read, evenly spread from 0 to 1.
        window: mm, over which each is averaged; at the gradient's ends only the end tone lies in it.
    """
    tone = np.linspace(0.0, 1.0, tones)
    place = (tone - 0.5) * _GRADIENT_MM
    place[[0, -1]] += np.array([-0.5, 0.5]) * window
    half = place[-1] + window / 2

    def at(x: FloatArray) -> FloatArray:
        return np.clip(x / _GRADIENT_MM + 0.5, 0.0, 1.0)

    return _tile(slant_deg, layer_height, at, half, place, tone)


def step_tile(slant_deg: float, layer_height: float, tone: FloatArray) -> Tile:
    """A tile with patches of even tone, 6 mm wide, in the given order from the left.

    Args:
        slant_deg: of the face, from 0 up to 85.
        layer_height: mm.
        tone: (T,) of the patches.
    """
    place = (np.arange(len(tone)) - (len(tone) - 1) / 2) * _STEP_MM
    half = len(tone) * _STEP_MM / 2

    def at(x: FloatArray) -> FloatArray:
        return np.asarray(tone[np.clip((x + half) // _STEP_MM, 0, len(tone) - 1).astype(np.int64)])

    return _tile(slant_deg, layer_height, at, half, place, tone)


def profile_tile(slant_deg: float, layer_height: float, tone: FloatArray, width: float) -> Tile:
    """A tile whose tones are given from left to right, evenly spread.

    Args:
        slant_deg: of the face, from 0 up to 85.
        layer_height: mm.
        tone: (T,); between them it is interpolated.
        width: mm, from the first tone to the last.
    """
    place = np.linspace(-width / 2, width / 2, len(tone))
    return _tile(slant_deg, layer_height, lambda x: np.interp(x, place, tone), width / 2, place, tone)


def _tile(
    slant_deg: float,
    layer_height: float,
    at: Callable[[FloatArray], FloatArray],
    half: float,
    place: FloatArray,
    tone: FloatArray,
) -> Tile:
    """A tile whose picture shows the tone `at(x)`, mm from the middle of its face, measured within `half` mm of it."""
    slant = math.radians(slant_deg)
    period = PERIOD_LAYERS * layer_height / math.cos(slant)
    periods = max(2, math.ceil(_LEAST_MEASURED_MM / period))
    measured = periods * period
    length, width = measured + 2 * _EDGE_MM, 2 * (half + _EDGE_MM)
    columns, rows = round(width / _TEXEL_MM), round(length / _TEXEL_MM)
    shown = at((np.arange(columns) + 0.5) * (width / columns) - width / 2).astype(np.float32)
    picture = ToneImage(np.repeat(shown[None, :], rows, axis=0), np.ones((rows, columns), dtype=np.float32))
    model = leaning_slab(width, length, slant_deg, picture, f"Tile {slant_deg:g}")
    center = (width / 2, length / 2 * math.sin(slant), length / 2 * math.cos(slant))
    return Tile(model, slant_deg, center, 2 * half, measured, periods * PERIOD_LAYERS, place, tone)


def leaning_slab(width: float, length: float, slant_deg: float, picture: ToneImage, name: str) -> SurfaceModel:
    """A slab with a picture on its front, which leans back; the back is upright, so that it prints without supports.

    Args:
        width: mm, of the front.
        length: mm, of the front, from its foot to its top.
        slant_deg: how far the front leans back.
        picture: fills the front.
        name: of the object.
    """
    back, top = length * math.sin(math.radians(slant_deg)), length * math.cos(math.radians(slant_deg))
    outline = [(0.0, 0.0), (back + DEPTH_MM, 0.0), (back + DEPTH_MM, top), (back, top)]
    vertices = np.array([(x, y, z) for x in (0.0, width) for y, z in outline])
    # The front comes first: its corners from the lower left on, as the picture's are.
    faces = np.array([(0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7)])
    uv = np.zeros((24, 2))
    uv[:4] = [(0, 0), (1, 0), (1, 1), (0, 1)]
    texture = np.array([0, -1, -1, -1, -1, -1], dtype=np.int64)
    start = np.arange(0, 25, 4, dtype=np.int64)
    return SurfaceModel(vertices, start, faces.ravel().astype(np.int64), uv, None, texture, (picture,), name)
