"""Finding the corner marks of the step wedge in a photograph.

The crossing of a mark's squares is a saddle of the brightness, for any camera position and light. The strongest saddles
are tried four at a time, and the four between which the wedge's tones are found are the marks.
"""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np

from ..errors import CalibrationError
from ..model import BoolArray, FloatArray, IntArray
from ..pictures.viewing import blurred
from ..settings import PrintSettings
from .homography import is_clockwise, projected, square_to
from .photograph import Photograph
from .step_wedge import MARKS, patch_tones, patches, quarter_tones

_LONG_SIDE = 900  # pixels of the reduced photograph in which marks are looked for
_SIGMAS = (2.5, 3.2, 4.0)  # of the blur, in pixels of that size, then in pixels twice and four times as large
_COARSER = (1, 2, 4)
_LEAST_SIDE = 16  # pixels; smaller pictures cannot show a tile
_CANDIDATES = 22  # saddles; all fours of them are tried: 7,315
_PROPORTIONS = (1.2, 5.0)  # width / height in the picture of the rectangle between the marks, whose own is 2.5
_MOST_CONVERGENT = 2.0  # most that a side may look longer than the opposite one
_DARKEST = 3e-3  # linear; 8-bit pictures do not resolve less
_LEAST_SIMILAR, _LEAST_SIMILAR_CLICKED = 0.8, 0.4  # correlation with the wedge, of found marks and of clicked ones
_LEAST_PATCH_PX = 16.0  # least height or width of a patch
_LEAST_SHARE = 0.01  # of the picture that the wedge fills
_REFINED_MM = (1.2, 0.9, 0.9)  # sigma of the window around a mark, step by step
_FARTHEST_MM = 4.0  # a refinement that moves a mark farther is dropped
_CLICK_MM, _STEPS = 3.0, 9  # how far a user's corners may be off, and steps of the search there along each axis
_FINEST_PX = 60  # side of the window around a mark; larger ones are averaged first


def find_marks(photo: Photograph, settings: PrintSettings) -> FloatArray:
    """(4, 2) pixels of the marks' crossings, x to the right and y down, in the order of `MARKS`.

    Args:
        photo: of the whole wedge.
        settings: that the wedge was printed with.

    Raises:
        CalibrationError: they are not found.
    """
    factor = max(math.ceil(max(photo.light.shape) / _LONG_SIDE), 1)
    small = photo.reduced(factor)
    best, marks = _LEAST_SIMILAR, None
    for coarser in _COARSER:
        if min(small.light.shape) < _LEAST_SIDE * coarser:
            break
        light = np.log(np.maximum(small.reduced(coarser).light.astype(np.float64), _DARKEST))
        for sigma in _SIGMAS:
            smooth = blurred(blurred(light, sigma, 0), sigma, 1)
            quads = _quadrilaterals(_saddles(smooth), smooth.shape)
            similar = similarity(smooth, quads)
            if similar.max(initial=0.0) > best:
                best, marks = float(similar.max()), (quads[similar.argmax()] + 0.5) * coarser * factor
    if marks is None:
        raise CalibrationError(
            "the corner marks were not found in the photograph",
            "photograph the whole tile from the front on a plain ground, or give its four corners",
        )
    patch_pixels(marks)
    return refined(photo, marks, settings)


def checked_corners(photo: Photograph, corners: FloatArray, settings: PrintSettings) -> FloatArray:
    """(4, 2) the crossings near corners that a user has pointed at, in the order of `MARKS`.

    Args:
        photo: of the wedge.
        corners: (4, 2) pixels, clockwise, starting at any mark.
        settings: that the wedge was printed with.

    Raises:
        CalibrationError: they are no corners of a quadrilateral in the picture, or there is no wedge between them.
    """
    high, wide = photo.light.shape
    if not (np.isfinite(corners).all() and (corners >= 0).all() and (corners <= (wide, high)).all()):
        raise CalibrationError("a corner lies outside of the photograph", "give pixels from its upper left")
    if not is_clockwise(corners):
        raise CalibrationError("the corners cross or run counterclockwise", "give them clockwise around the tile")
    sigma = max(float(np.sqrt(_area(corners)) / 80), 0.5)
    part, begin = photo.cropped(corners, 8 * sigma)
    factor = max(int(sigma / 4), 1)
    light = np.log(np.maximum(part.reduced(factor).light.astype(np.float64), _DARKEST))
    light = blurred(blurred(light, sigma / factor, 0), sigma / factor, 1)
    turned = np.stack([np.roll(corners, -turn, axis=0) for turn in range(4)])
    similar = similarity(light, (turned - begin) / factor - 0.5)
    if similar.max() < _LEAST_SIMILAR_CLICKED:
        raise CalibrationError(
            "the tile's patches are not seen between the corners", "give the places where the squares of each mark meet"
        )
    marks = turned[similar.argmax()]
    patch_pixels(marks)
    return refined(photo, marks, settings, _CLICK_MM)


def patch_pixels(marks: FloatArray) -> float:
    """The least height or width of a patch along the grid's edges, in pixels.

    Args:
        marks: (4, 2) pixels, in the order of `MARKS`, the upper left one first.

    Raises:
        CalibrationError: it is too small to be read.
    """
    patches_wide, patches_high = MARKS[2] - MARKS[0]
    edge = np.linalg.norm(np.roll(marks, -1, axis=0) - marks, axis=1)
    least = float(min(edge[0] / patches_wide, edge[2] / patches_wide, edge[1] / patches_high, edge[3] / patches_high))
    if least < _LEAST_PATCH_PX:
        raise CalibrationError(
            f"the tile is too small in the photograph, its patches are {least:.0f} pixels high",
            f"move closer, for {_LEAST_PATCH_PX:.0f} pixels or more",
        )
    return least


def similarity(light: FloatArray, quads: FloatArray) -> FloatArray:
    """(K,) similarity of a picture between marks to the wedge: correlation with its tones, uneven light removed.

    Args:
        light: (H, W) logarithm of the light, blurred to the size of the marks' squares.
        quads: (K, 4, 2) pixels, in the order of `MARKS`.
    """
    places, tone = _samples()
    pixel = np.rint(projected(square_to(quads), (places - MARKS[0]) / (MARKS[2] - MARKS[0])))
    high, wide = light.shape
    inside = ((pixel >= 0) & (pixel < (wide, high))).all(axis=(1, 2))
    at = np.where(inside[:, None, None], pixel, 0).astype(np.int64)
    seen = light[at[..., 1], at[..., 0]]
    x, y = (places - places.mean(axis=0)).T
    uneven, _ = np.linalg.qr(np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1))
    seen = seen - (seen @ uneven) @ uneven.T
    wanted = tone - uneven @ (uneven.T @ tone)
    length = np.linalg.norm(seen, axis=1) * np.linalg.norm(wanted)
    return np.where(inside & (length > 1e-9), seen @ wanted / np.maximum(length, 1e-9), -1.0)


def _samples() -> tuple[FloatArray, FloatArray]:
    """(P, 2) the middles of all patches and of the marks' squares, as in `MARKS`, and (P,) their tones."""
    tone = patch_tones()
    row, column = np.nonzero(~np.isnan(tone))
    squares = (MARKS[:, None] + np.array([(-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25)])).reshape(-1, 2)
    across, down = np.floor(2 * squares).astype(np.int64).T
    places = np.concatenate([np.stack([column + 0.5, row + 0.5], axis=1), squares])
    return places, np.concatenate([tone[row, column], quarter_tones()[down, across]])


def refined(photo: Photograph, marks: FloatArray, settings: PrintSettings, search: float = 0.0) -> FloatArray:
    """Marks (4, 2) moved to the middle of their crossings; one that cannot be seen clearly stays where it is.

    Around each, a plane and a saddle are fitted to the light, with weights wide enough for the pattern to average out.

    Args:
        photo: of the wedge.
        marks: (4, 2) pixels, in the order of `MARKS`.
        settings: that the wedge was printed with.
        search: mm to all sides of each where the strongest saddle is looked for first.
    """
    size = patches(settings)
    mm = np.array([size.width, size.height])
    span = MARKS[2] - MARKS[0]
    moved = marks
    if search:
        to_photo = square_to(marks)
        offset = np.stack([_strongest(photo, to_photo, mark, mm, search) for mark in MARKS])
        moved = projected(to_photo, (MARKS + offset / mm - MARKS[0]) / span)
    for sigma in _REFINED_MM:
        to_photo = square_to(moved)
        fits = [_fit(photo, to_photo, mark, mm, sigma) for mark in MARKS]
        moved = projected(to_photo, (MARKS + np.stack([_saddle_of(fit, sigma) for fit in fits]) / mm - MARKS[0]) / span)
    there = projected(np.linalg.inv(square_to(marks)), moved) * span * mm
    here = (MARKS - MARKS[0]) * mm
    return np.where((np.abs(there - here).max(axis=1) < _FARTHEST_MM)[:, None], moved, marks)


def _strongest(photo: Photograph, to_photo: FloatArray, mark: FloatArray, mm: FloatArray, reach: float) -> FloatArray:
    """(2,) mm from the assumed place of a mark to the strongest saddle within reach that is black at its upper left."""
    steps = np.linspace(-reach, reach, _STEPS)
    offsets = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    strength = [-_fit(photo, to_photo, mark + offset / mm, mm, _REFINED_MM[-1])[3] for offset in offsets]
    return np.asarray(offsets[int(np.argmax(strength))])


def _saddle_of(fit: FloatArray, sigma: float) -> FloatArray:
    """(2,) mm from the middle to the level point of a fit; 0 if it is an edge rather than a saddle."""
    if abs(fit[3]) * sigma <= np.abs(fit[1:3]).max():
        return np.zeros(2)
    return np.asarray(np.array([-fit[2], -fit[1]]) / fit[3])


def _fit(photo: Photograph, to_photo: FloatArray, mark: FloatArray, mm: FloatArray, sigma: float) -> FloatArray:
    """(4,) coefficients of 1, x, y and xy (mm) fitted to the light around a place of the wedge."""
    span = MARKS[2] - MARKS[0]
    box = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * 3 * sigma / mm
    corners = projected(to_photo, (mark + box - MARKS[0]) / span)
    part, begin = photo.cropped(corners, 0.0)
    factor = max(int(np.sqrt(_area(corners)) / _FINEST_PX), 1)
    if min(part.light.shape) < factor:
        return np.zeros(4)
    part = part.reduced(factor)
    row, column = np.indices(part.light.shape)
    pixel = (np.stack([column.ravel(), row.ravel()], axis=1) + 0.5) * factor + begin
    x, y = ((projected(np.linalg.inv(to_photo), pixel) * span + MARKS[0] - mark) * mm).T
    weight = np.exp(-(x * x + y * y) / (4 * sigma * sigma))  # the root of a Gaussian
    terms = np.stack([np.ones_like(x), x, y, x * y], axis=1) * weight[:, None]
    return np.asarray(np.linalg.lstsq(terms, part.light.ravel() * weight, rcond=None)[0])


def _saddles(light: FloatArray) -> FloatArray:
    """(K, 2) pixels of the strongest saddles, x and y."""
    across = light[1:-1, 2:] - 2 * light[1:-1, 1:-1] + light[1:-1, :-2]
    down = light[2:, 1:-1] - 2 * light[1:-1, 1:-1] + light[:-2, 1:-1]
    both = (light[2:, 2:] - light[2:, :-2] - light[:-2, 2:] + light[:-2, :-2]) / 4
    strength = both * both - across * down
    # Much steeper in one direction than in the other: a bump on an edge.
    strength[(across + down) ** 2 > 4 * strength] = 0.0
    row, column = np.nonzero(_is_peak(strength))
    strongest = np.argsort(strength[row + 1, column + 1], kind="stable")[::-1][:_CANDIDATES]
    return np.asarray(np.stack([column[strongest], row[strongest]], axis=1) + 2.0)


def _is_peak(values: FloatArray) -> BoolArray:
    """(H - 2, W - 2) whether values are positive and greater than their eight neighbors."""
    high, wide = values.shape
    middle = values[1:-1, 1:-1]
    shifted = [values[r : high - 2 + r, c : wide - 2 + c] for r in range(3) for c in range(3) if (r, c) != (1, 1)]
    return np.asarray((middle > 0) & (middle > np.maximum.reduce(shifted)))


def _quadrilaterals(points: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """(K, 4, 2) quadrilaterals of four of the points that may be the marks: clockwise, the upper left one first."""
    chosen: IntArray = np.array(list(combinations(range(len(points)), 4)), dtype=np.int64).reshape(-1, 4)
    quads = points[chosen]
    from_middle = quads - quads.mean(axis=1, keepdims=True)
    around = np.argsort(np.arctan2(from_middle[..., 1], from_middle[..., 0]), axis=1)
    quads = np.take_along_axis(quads, around[..., None], axis=1)
    quads = quads[is_clockwise(quads) & (_area(quads) > _LEAST_SHARE * shape[0] * shape[1])]
    quads = np.concatenate([np.roll(quads, -turn, axis=1) for turn in range(4)])
    top, right, bottom, left = np.linalg.norm(np.roll(quads, -1, axis=1) - quads, axis=2).T
    wide = (top + bottom) / (left + right)
    is_seen_so = (wide > _PROPORTIONS[0]) & (wide < _PROPORTIONS[1])
    for one, other in ((top, bottom), (left, right)):
        is_seen_so &= (one < _MOST_CONVERGENT * other) & (other < _MOST_CONVERGENT * one)
    return np.asarray(quads[is_seen_so])


def _area(quads: FloatArray) -> FloatArray:
    """(…,) of quadrilaterals (…, 4, 2)."""
    one, other = quads[..., 2, :] - quads[..., 0, :], quads[..., 3, :] - quads[..., 1, :]
    return np.asarray(np.abs(one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]) / 2)
