"""The edges that bound the charts of a UV map: borders, and folds where the map turns over."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..mesh.corners import complex_uv, following_corner
from ..model import BoolArray, FloatArray, IntArray
from ..parallel import CHUNK_ROWS
from ..records import dataclass
from .islands import LabelImage


@dataclass(frozen=True)
class ChartEdges:
    """Edges of the charts, E of them, each from its lower to its upper end.

    Attributes:
        low: (E, 2) texels, the lower end.
        high: (E, 2) texels, the upper end.
        ends: (E,) whether the chart is on the left of the edge; else it is on the right.
        island: (E,) that the edge bounds.
    """

    low: FloatArray
    high: FloatArray
    ends: BoolArray
    island: LabelImage


def chart_edges(
    face_uv: FloatArray, side: FloatArray, place: IntArray, island: LabelImage, size: IntArray
) -> ChartEdges:
    """The edges of triangles (T, 3, 2) that bound charts, or fold them, and cross a row of texels.

    Args:
        face_uv: (T, 3, 2).
        side: (T,) 1 for triangles that turn left in the picture, -1 for those that turn right, 0 without an area.
        place: (T, 3) see `labels.rasterized`.
        island: (T,).
        size: width and height, texels.
    """
    places = int(place.max(initial=-1)) + 1
    corner = _on_borders(place, side, places)
    face, after = corner // 3, following_corner(corner)
    one, other, uv = place.take(corner), place.take(after), complex_uv(face_uv)
    own = np.empty(places, dtype=np.complex128)  # the same to the last digit on either side, so that borders are closed
    own[one], own[other] = uv.take(corner), uv.take(after)
    start, end = (own.take(corners).view(np.float64).reshape(-1, 2) * size for corners in (one, other))
    turn = side[face]
    crossing = np.flatnonzero((first_center(start[:, 1]) != first_center(end[:, 1])) & (turn != 0))
    face, one, other, start, end, turn = _some(crossing, face, one, other, start, end, turn)
    # Two triangles on either side of an edge run along it in opposite directions.
    pair = np.unique(np.minimum(one, other) * places + np.maximum(one, other), return_inverse=True)[1]
    single = np.flatnonzero((np.bincount(pair, np.where(one < other, turn, -turn)) != 0).take(pair))
    face, start, end, turn = _some(single, face, start, end, turn)
    up = start[:, 1] < end[:, 1]
    low, high = np.where(up[:, None], start, end), np.where(up[:, None], end, start)
    return ChartEdges(low, high, up == (turn > 0), island[face])


def _some(rows: IntArray, *columns: NDArray[Any]) -> Iterator[NDArray[Any]]:
    """Some of the rows of each column; several times as fast as by indexing."""
    return (column.take(rows, axis=0) for column in columns)


def _on_borders(place: IntArray, side: FloatArray, places: int) -> IntArray:
    """The edges both of whose ends lie on a border or a fold of a chart, as the corners that they start from.

    The triangles around a place inside a chart form a closed ring: each begins at the place where the one before ends.
    With a random number for every place, the sum of end less begin over the ring is 0; on borders it is not. In
    mirrored triangles begin and end are swapped, so folds are found as well.
    """
    number = np.random.default_rng(0).integers(1 << 44, size=places).astype(np.float64)
    difference = np.empty(place.shape)
    for begin in range(0, len(place), CHUNK_ROWS):
        part = slice(begin, begin + CHUNK_ROWS)
        numbers = number.take(place[part])
        for k in range(3):
            np.multiply(numbers[:, k - 2] - numbers[:, k - 1], side[part], out=difference[part, k])
    total = np.bincount(place.ravel(), difference.ravel(), places)  # of whole numbers, so that nothing is rounded
    outside = (total != 0).take(place)
    return np.concatenate([3 * np.flatnonzero(outside[:, k] & outside[:, k - 2]) + k for k in range(3)])


def first_center(edge: FloatArray) -> FloatArray:
    """The first texel whose center is not before an edge."""
    return np.asarray(np.ceil(edge - 0.5))
