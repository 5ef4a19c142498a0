"""Shapes to show a picture on: an upright plate, a cylinder, a lamp shade, with one texel per two layers."""

from __future__ import annotations

import math

import numpy as np

from ..errors import MeshError
from ..model import BoolArray, FloatArray, IntArray, SurfaceModel, ToneImage
from ..ragged import starts
from ..records import dataclass
from ..settings import PrintSettings
from ..texture.lanczos import resized

PLATE_BRIM_MM = 5.0  # a thin plate that stands upright needs a foot
_FACET_MM = 1.0  # length of the sides of round shapes
_LEAST_FACETS = 48
_PAINTED = 0.5  # least alpha of texels that count for automatic contrast
_LEAST_CONTRAST = 0.02  # less is noise, not a picture


@dataclass(frozen=True)
class PictureShape:
    """A closed surface, standing on z = 0 about the z axis, part of which a picture covers.

    Attributes:
        vertices: (V, 3) mm.
        polygon_start: (P + 1,) int64.
        corner_vertex: (C,) int64, counterclockwise seen from outside.
        corner_uv: (C, 2), zeros where there is no picture.
        has_picture: (P,) bool.
        columns: texels of the picture along the layers, the frame's included.
        rows: texels up the shape, one a layer pair, the frame's included.
        frame: texels of the frame on each side.
        size: (width, height) mm of the picture on the surface, the frame included.
    """

    vertices: FloatArray
    polygon_start: IntArray
    corner_vertex: IntArray
    corner_uv: FloatArray
    has_picture: BoolArray
    columns: int
    rows: int
    frame: int
    size: tuple[float, float]


@dataclass(frozen=True)
class _Ladder:
    """Heights `z` (L,) mm, and the picture's `v` (L,) there; in between, v is linear in z.

    The rows of texels are pairs of layers. If the first layer has another height, so has the first row.
    """

    z: FloatArray
    v: FloatArray
    rows: int

    @staticmethod
    def of(height: float, settings: PrintSettings) -> _Ladder:
        pair = 2 * settings.layer_height
        rows = max(round(height / pair), 1)
        first = settings.first_layer_height + settings.layer_height
        top = first + (rows - 1) * pair
        if rows == 1 or math.isclose(first, pair):
            return _Ladder(np.array([0.0, top]), np.array([0.0, 1.0]), rows)
        return _Ladder(np.array([0.0, first, top]), np.array([0.0, 1 / rows, 1.0]), rows)


def picture_plate(
    width: float, height: float, thickness: float, settings: PrintSettings, frame: float = 0.0
) -> PictureShape:
    """A plate that stands upright, its picture in front (-Y); width and height become whole texels, one at least.

    A texel is as wide as it is high, two layers (paper, Figure 1: 60 × 71 texels on 142 layers). Its rows coincide with
    pairs of a black and a white layer.

    Args:
        width: mm, without the frame.
        height: mm, without the frame.
        thickness: mm.
        settings: the layer heights are used.
        frame: mm on all sides of the picture, whole texels of it.

    Raises:
        MeshError: a length is not positive.
    """
    _check_lengths(width=width, height=height, thickness=thickness)
    texel = 2 * settings.layer_height
    border = max(round(frame / texel), 0)
    columns = max(round(width / texel), 1) + 2 * border
    ladder = _Ladder.of(height + 2 * border * texel, settings)
    x, y = columns * texel / 2, thickness / 2
    loop = np.array([[-x, -y], [x, -y], [x, y], [-x, y]])
    rings = np.concatenate(
        [np.tile(loop, (len(ladder.z), 1, 1)), np.broadcast_to(ladder.z[:, None, None], (len(ladder.z), 4, 1))], axis=2
    )
    # The sides continue the picture's edges around the corners, where these would fade otherwise.
    u = np.array([[0.0, 1.0], [1.0, 1.0], [np.nan, np.nan], [0.0, 0.0]])
    wall, uv, pictured = _wall(rings, ladder.v, u)
    return _shape(rings, wall, _ends(rings), uv, pictured, columns, ladder, border)


def picture_tube(
    bottom_diameter: float,
    top_diameter: float,
    height: float,
    settings: PrintSettings,
    wall: float | None = None,
) -> PictureShape:
    """A cylinder or cone with a picture wrapped around it once, its middle in front (-Y), its edges meeting behind.

    Args:
        bottom_diameter: mm.
        top_diameter: mm.
        height: mm, made whole layer pairs.
        settings: the layer heights are used.
        wall: mm of a shell that is open below and above, like a lamp shade; None for a solid.

    Raises:
        MeshError: a length is not positive, or the wall leaves no room inside.
    """
    _check_lengths(bottom_diameter=bottom_diameter, top_diameter=top_diameter, height=height)
    narrow = min(bottom_diameter, top_diameter)
    if wall is not None and not 0 < wall < narrow / 2:
        raise MeshError(f"a wall of {wall:g} mm leaves no room inside {narrow:g} mm", "make it thinner")
    ladder = _Ladder.of(height, settings)
    around = math.pi * (bottom_diameter + top_diameter) / 2
    facets = max(math.ceil(math.pi * max(bottom_diameter, top_diameter) / _FACET_MM), _LEAST_FACETS)
    radius = np.interp(ladder.z, ladder.z[[0, -1]], [bottom_diameter / 2, top_diameter / 2])
    outer = _circles(radius, ladder.z, facets)
    turn = np.arange(facets + 1) / facets
    shown, uv, pictured = _wall(outer, ladder.v, np.stack([turn[:-1], turn[1:]], axis=1))
    if wall is None:
        rings, plain = outer, _ends(outer)
    else:
        inner = _circles(radius - wall, ladder.z, facets)
        rings, plain = np.concatenate([outer, inner]), _inside_and_rims(outer)
    columns = max(round(around / (2 * settings.layer_height)), 1)
    return _shape(rings, shown, plain, uv, pictured, columns, ladder, 0, around)


def fitted(image: ToneImage, shape: PictureShape, *, auto_contrast: bool = False, frame_tone: float = 1.0) -> ToneImage:
    """A picture cut to a shape's proportions about its middle, and filtered by Lanczos to its texels.

    Everything is done in linear light, with tones weighted by alpha.

    Args:
        image: of any size.
        shape: columns, rows and frame are used.
        auto_contrast: stretch the tones so that the 1st and 99th percentile become black and white.
        frame_tone: of the frame.
    """
    columns, rows = shape.columns - 2 * shape.frame, shape.rows - 2 * shape.frame
    high, wide = image.tone.shape
    scale = min(wide / columns, high / rows)
    # Of the side that sets the scale nothing is cut; rounding could make that a bit less than nothing.
    margin = max((wide - columns * scale) / 2, 0.0), max((high - rows * scale) / 2, 0.0)
    box = margin[0], margin[1], wide - margin[0], high - margin[1]
    alpha = np.clip(resized(image.alpha, (columns, rows), box), 0.0, 1.0)
    paint = np.clip(resized(image.tone * image.alpha, (columns, rows), box), 0.0, alpha)
    tone = np.divide(paint, alpha, out=np.zeros_like(paint), where=alpha > 0)
    if auto_contrast and (alpha > _PAINTED).any():
        low, high_tone = np.percentile(tone[alpha > _PAINTED], [1, 99])
        if high_tone - low > _LEAST_CONTRAST:
            tone = np.clip((tone - low) / (high_tone - low), 0.0, 1.0).astype(np.float32)
    around = ((shape.frame, shape.frame), (shape.frame, shape.frame))
    framed = np.pad(tone, around, constant_values=frame_tone), np.pad(alpha, around, constant_values=1.0)
    return ToneImage(*framed)


def surface_of(shape: PictureShape, picture: ToneImage, plain_tone: float, name: str) -> SurfaceModel:
    """The shape with its picture as the job's input; the rest of the surface has one tone."""
    return SurfaceModel(
        vertices=shape.vertices,
        polygon_start=shape.polygon_start,
        corner_vertex=shape.corner_vertex,
        corner_uv=shape.corner_uv,
        corner_tone=np.full(len(shape.corner_vertex), plain_tone),
        polygon_texture=np.where(shape.has_picture, 0, -1),
        textures=(picture,),
        name=name,
    )


def _check_lengths(**lengths: float) -> None:
    for name, length in lengths.items():
        if not (math.isfinite(length) and length > 0):
            raise MeshError(f"the {name.replace('_', ' ')} is {length:g} mm", "give a length above zero")


def _circles(radius: FloatArray, z: FloatArray, facets: int) -> FloatArray:
    """(L, K, 3) circles one above the other, counterclockwise from behind (+Y), where the edges of a picture meet."""
    turn = math.pi / 2 + 2 * math.pi * np.arange(facets) / facets
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1) * radius[:, None, None]
    return np.concatenate([ring, np.broadcast_to(z[:, None, None], (len(z), facets, 1))], axis=2)


def _wall(rings: FloatArray, v: FloatArray, u: FloatArray) -> tuple[IntArray, FloatArray, BoolArray]:
    """Quadrilaterals between rings (L, K, 3) that run counterclockwise, seen from outside.

    Args:
        rings: from the bottom up.
        v: (L,) at each ring.
        u: (K, 2) where each side begins and ends in the picture, NaN if it bears none.

    Returns:
        corners ((L - 1) K, 4), UVs ((L - 1) K, 4, 2), and which of them bear the picture ((L - 1) K,).
    """
    levels, sides = rings.shape[:2]
    level, side = (part.ravel() for part in np.indices((levels - 1, sides)))
    along = (side + 1) % sides
    lower = np.stack([level * sides + side, level * sides + along], axis=1)
    corners = np.concatenate([lower, lower[:, ::-1] + sides], axis=1)
    across = np.concatenate([u[side], u[side, ::-1]], axis=1)
    up = np.stack([v[level], v[level], v[level + 1], v[level + 1]], axis=1)
    pictured = np.isfinite(u[side]).all(axis=1)
    return corners, np.where(pictured[:, None, None], np.stack([across, up], axis=2), 0.0), pictured


def _ends(rings: FloatArray) -> list[IntArray]:
    """Bottom and top of a solid between rings (L, K, 3)."""
    levels, sides = rings.shape[:2]
    return [np.arange(sides)[::-1], np.arange(sides) + sides * (levels - 1)]


def _inside_and_rims(outer: FloatArray) -> list[IntArray]:
    """Quadrilaterals that close a shell, whose inner rings (L, K, 3) come after the outer ones."""
    levels, sides = outer.shape[:2]
    inner, top = levels * sides, (levels - 1) * sides
    inside, _, _ = _wall(outer, np.zeros(levels), np.full((sides, 2), np.nan))
    rims = _annulus(inner, 0, sides), _annulus(top, inner + top, sides)
    return [*(inner + inside[:, ::-1]), *rims[0], *rims[1]]


def _annulus(outer: int, inner: int, count: int) -> IntArray:
    """(count, 4) quadrilaterals between two circles of vertices that start at these numbers, seen from above."""
    here = np.arange(count)
    along = (here + 1) % count
    return np.stack([outer + here, outer + along, inner + along, inner + here], axis=1)


def _shape(
    rings: FloatArray,
    wall: IntArray,
    plain: list[IntArray],
    uv: FloatArray,
    pictured: BoolArray,
    columns: int,
    ladder: _Ladder,
    frame: int,
    width: float | None = None,
) -> PictureShape:
    """The shape of rings (L, K, 3): quadrilaterals (Q, 4) with UVs (Q, 4, 2), (Q,) whether pictured, and plain rest."""
    vertices, polygons = rings.reshape(-1, 3), [*wall, *plain]
    without_uv = np.zeros((sum(map(len, plain)), 2))
    return PictureShape(
        vertices=np.ascontiguousarray(vertices),
        polygon_start=starts(np.array([len(polygon) for polygon in polygons])),
        corner_vertex=np.concatenate(polygons).astype(np.int64),
        corner_uv=np.concatenate([uv.reshape(-1, 2), without_uv]),
        has_picture=np.append(pictured, np.zeros(len(plain), dtype=bool)),
        columns=columns,
        rows=ladder.rows,
        frame=frame,
        size=(float(np.ptp(vertices[:, 0])) if width is None else width, float(ladder.z[-1])),
    )
