"""Pictures of an object with curves on it, drawn without a renderer: parallel projection and a depth buffer."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..mesh.surface_points import points_on_faces
from ..model import FloatArray, IntArray, TriangleMesh
from ..pictures.viewing import Picture
from ..ragged import ranges
from ..records import dataclass
from .surface_curves import Rgb, SurfaceCurves

CLAY: Rgb = (0.86, 0.85, 0.83)
"""Faces that nothing is said about."""

_OVERSAMPLING = 2
_STEP_PIXELS = 0.7
_FACES_AT_ONCE = 4096
_MARGIN = 0.04
_BIAS_MM = 0.4
_DEPTH_STEP_MM = 1e-3
_PAPER = (1.0, 1.0, 1.0)
_LIGHT = (-0.35, 0.45, 0.82)  # to the right, up, towards the viewer
_AMBIENT = 0.45
_TEXT_HEIGHT = 15
_INK = (40, 40, 40)


@dataclass(frozen=True)
class Stroke:
    """Curves or dots of a picture; later ones are drawn over earlier ones.

    Attributes:
        curves: what to draw; a curve of a single point is a dot.
        colors: (N, 3) sRGB of each point, or one for all.
        radius: pixels.
    """

    curves: SurfaceCurves
    colors: FloatArray | Rgb
    radius: float = 1.0


@dataclass(frozen=True)
class _Camera:
    axes: FloatArray  # (3, 3): right, up, towards the viewer
    scale: float  # pixels per mm
    shift: FloatArray  # (2,) pixels
    height: int
    width: int

    def seen(self, points: FloatArray) -> FloatArray:
        """(…, 3) pixels from the left, pixels from the top, mm towards the viewer."""
        turned = points @ self.axes.T
        turned[..., 0] = turned[..., 0] * self.scale + self.shift[0]
        turned[..., 1] = self.shift[1] - turned[..., 1] * self.scale
        return np.asarray(turned)


def draw(
    mesh: TriangleMesh,
    strokes: Sequence[Stroke],
    view: tuple[float, float],
    pixels: int = 900,
    face_colors: FloatArray | None = None,
    legend: Sequence[tuple[Rgb, str]] = (),
) -> Picture:
    """Draw an object in clay, or in its faces' colors, with curves on it and a line that explains their colors.

    Args:
        mesh: F faces.
        strokes: on its surface.
        view: azimuth and elevation, degrees, as in `viewing.VIEWS`.
        pixels: of the longer side.
        face_colors: (F, 3) sRGB.
        legend: colors and what they mean.
    """
    from PIL import Image

    camera = _camera(mesh, view, pixels * _OVERSAMPLING)
    depth, face = _depth_buffer(mesh, camera)
    image = _shaded(mesh, camera, face, face_colors)
    for stroke in strokes:
        _draw_stroke(image, depth, camera, stroke)
    size = (camera.width // _OVERSAMPLING, camera.height // _OVERSAMPLING)
    whole = Image.fromarray(np.asarray(np.rint(image * 255), dtype=np.uint8)).resize(size, Image.Resampling.LANCZOS)
    return _with_legend(np.asarray(whole), legend)


def dots(points: FloatArray) -> SurfaceCurves:
    """Points (n, 3) as curves of a single point."""
    return SurfaceCurves(points, np.arange(len(points) + 1), np.zeros(len(points)))


def _camera(mesh: TriangleMesh, view: tuple[float, float], pixels: int) -> _Camera:
    azimuth, elevation = np.radians(view)
    towards = np.array(
        [np.sin(azimuth) * np.cos(elevation), -np.cos(azimuth) * np.cos(elevation), np.sin(elevation)]
    )  # fmt: skip
    right = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    axes = np.stack([right, np.cross(towards, right), towards])
    turned = mesh.vertices @ axes[:2].T
    low, high = turned.min(axis=0), turned.max(axis=0)
    scale = pixels * (1 - 2 * _MARGIN) / float((high - low).max())
    room = (high - low) * scale + 2 * _MARGIN * pixels
    width, height = (int(_OVERSAMPLING * np.ceil(side / _OVERSAMPLING)) for side in room)
    middle = (low + high) / 2 * scale
    return _Camera(axes, scale, np.array([width / 2 - middle[0], height / 2 + middle[1]]), height, width)


def _depth_buffer(mesh: TriangleMesh, camera: _Camera) -> tuple[FloatArray, IntArray]:
    """(H, W) mm towards the viewer, and the face that is seen, -1 for none."""
    corners = camera.seen(mesh.vertices)[mesh.faces]
    # y counts downwards, so that faces towards the viewer run clockwise.
    ahead, behind = corners[:, 1, :2] - corners[:, 0, :2], corners[:, 2, :2] - corners[:, 0, :2]
    seen = np.flatnonzero(ahead[:, 0] * behind[:, 1] - ahead[:, 1] * behind[:, 0] < 0)
    nearest = np.full(camera.height * camera.width, -1, dtype=np.int64)
    lowest = float(corners[..., 2].min()) - 1.0
    for some in np.split(seen, np.arange(_FACES_AT_ONCE, len(seen), _FACES_AT_ONCE)):
        on = points_on_faces(corners[some][..., :2], _STEP_PIXELS)
        place = np.einsum("qc,qcd->qd", on.share, corners[some][on.face])
        pixel = _pixels(place, camera)
        deep = np.asarray((place[:, 2] - lowest) / _DEPTH_STEP_MM, dtype=np.int64)
        np.maximum.at(nearest, pixel, deep << 32 | some[on.face])
    shown = nearest >= 0
    depth = np.where(shown, (nearest >> 32) * _DEPTH_STEP_MM + lowest, -np.inf)
    face = np.where(shown, nearest & 0xFFFFFFFF, -1)
    return depth.reshape(camera.height, camera.width), face.reshape(camera.height, camera.width)


def _pixels(place: FloatArray, camera: _Camera) -> IntArray:
    column = np.clip(place[:, 0].astype(np.int64), 0, camera.width - 1)
    row = np.clip(place[:, 1].astype(np.int64), 0, camera.height - 1)
    return np.asarray(row * camera.width + column)


def _shaded(mesh: TriangleMesh, camera: _Camera, face: IntArray, face_colors: FloatArray | None) -> NDArray[np.float32]:
    corners = mesh.vertices[mesh.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-12)[:, None]
    light = np.array(_LIGHT) / np.linalg.norm(_LIGHT)
    bright = _AMBIENT + (1 - _AMBIENT) * np.maximum(normal @ camera.axes.T @ light, 0.0)
    colors = np.broadcast_to(CLAY, normal.shape) if face_colors is None else face_colors
    palette = np.concatenate([bright[:, None] * colors, [_PAPER]]).astype(np.float32)
    return np.asarray(palette[face])


def _draw_stroke(image: NDArray[np.float32], depth: FloatArray, camera: _Camera, stroke: Stroke) -> None:
    """Draw discs along the curves, where nothing hides them."""
    if not len(stroke.curves.points):
        return
    place, before = _along(camera.seen(stroke.curves.points), stroke.curves.start)
    colors = np.broadcast_to(stroke.colors, (len(stroke.curves.points), 3))[before]
    behind = depth.ravel()[_pixels(place, camera)]
    visible = np.isfinite(behind) & (place[:, 2] >= behind - _BIAS_MM)
    place, colors, value = place[visible], colors[visible], stroke.curves.value[before][visible]
    order = np.argsort(value, kind="stable")  # what matters most is drawn last
    place, colors = place[order], colors[order]
    radius = stroke.radius * _OVERSAMPLING
    reach = int(np.ceil(radius))
    flat = image.reshape(-1, 3)
    for down in range(-reach, reach + 1):
        for across in range(-reach, reach + 1):
            if down**2 + across**2 <= radius**2:
                flat[_pixels(place + np.array([across, down, 0.0]), camera)] = colors


def _along(seen: FloatArray, start: IntArray) -> tuple[FloatArray, IntArray]:
    """Places less than a pixel apart along polylines of pixels, and the point before each."""
    last = np.zeros(len(seen), dtype=bool)
    last[start[1:] - 1] = True
    after = np.where(last, np.arange(len(seen)), np.arange(len(seen)) + 1)
    step = seen[after] - seen
    count = np.maximum(np.ceil(np.hypot(step[:, 0], step[:, 1])), 1).astype(np.int64)
    before = np.repeat(np.arange(len(seen)), count)
    share = ranges(0, count) / count[before]
    return seen[before] + share[:, None] * step[before], before


def _with_legend(picture: Picture, legend: Sequence[tuple[Rgb, str]]) -> Picture:
    """The picture with a line below it; the entries go on in further lines where the width asks for it."""
    from PIL import Image, ImageDraw, ImageFont

    if not legend:
        return picture
    font = ImageFont.load_default(_TEXT_HEIGHT * 0.85)
    rows: list[list[tuple[Rgb, str, int]]] = [[]]
    left = _TEXT_HEIGHT
    for color, text in legend:
        width = int(font.getlength(text)) + 3 * _TEXT_HEIGHT
        if left + width > picture.shape[1] and rows[-1]:
            rows.append([])
            left = _TEXT_HEIGHT
        rows[-1].append((color, text, left))
        left += width
    height, line = picture.shape[0], int(1.5 * _TEXT_HEIGHT)
    sheet = Image.new("RGB", (picture.shape[1], height + line * len(rows) + _TEXT_HEIGHT // 2), (255, 255, 255))
    sheet.paste(Image.fromarray(picture))
    pen = ImageDraw.Draw(sheet)
    for number, row in enumerate(rows):
        top = height + line * number
        for color, text, left in row:
            pen.rectangle((left, top + 3, left + _TEXT_HEIGHT - 2, top + _TEXT_HEIGHT), _byte(color))
            pen.text((left + int(1.3 * _TEXT_HEIGHT), top), text, _INK, font)
    return np.asarray(sheet)


def _byte(color: Rgb) -> tuple[int, int, int]:
    red, green, blue = (round(255 * value) for value in color)
    return red, green, blue
