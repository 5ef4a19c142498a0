"""Sample points all over the faces of a mesh, to integrate or draw something over its surface."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray, IntArray
from ..ragged import ranges
from ..records import dataclass


@dataclass(frozen=True)
class FacePoints:
    """Q places on F triangles, at least one on each.

    Attributes:
        face: (Q,) int64, not decreasing.
        share: (Q, 3) of the face's corners; sums to 1.
        weight: (Q,) share of the face's area that each stands for; those of a face sum to 1.
    """

    face: IntArray
    share: FloatArray
    weight: FloatArray


def points_on_faces(corners: FloatArray, step: float) -> FacePoints:
    """Cover triangles with places no farther apart than about `step`.

    Rows run from the corner opposite the shortest edge to that edge, so needles get few places.

    Args:
        corners: (F, 3, D) of each triangle, in any number of dimensions.
        step: in the same unit.
    """
    edges = np.linalg.norm(corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]], axis=2)
    apex = np.argmin(edges, axis=1)
    rows = np.maximum(np.ceil(edges.max(axis=1) / step), 1).astype(np.int64)
    columns = np.maximum(np.ceil(edges.min(axis=1) / step), 1).astype(np.int64)
    count = rows * columns
    face = np.repeat(np.arange(len(corners)), count)
    number = ranges(0, count)
    row, column = np.divmod(number, columns[face])
    away = (row + 0.5) / rows[face]
    across = away * (column + 0.5) / columns[face]
    share = np.empty((len(face), 3))
    place, order = np.arange(len(face)), apex[face]
    share[place, order] = 1.0 - away
    share[place, (order + 1) % 3] = away - across
    share[place, (order + 2) % 3] = across
    return FacePoints(face, share, 2.0 * away / count[face])
