"""Objects of one plate that run into each other."""

from __future__ import annotations

import numpy as np
import shapely

from ..model import IntArray, TriangleMesh
from .outlines import Outlines
from .regions import solid_regions

# Objects that share less than this in a layer (mm²) only touch.
_SMALLEST_MM2 = 0.05


def overlaps(outlines: Outlines, mesh: TriangleMesh, layers: int) -> IntArray:
    """(K, 3) pairs of objects that overlap, and in how many layers they do.

    Args:
        outlines: loops of all objects, each of one object alone: not united yet.
        mesh: that they were cut from.
        layers: how many there are.
    """
    none = np.zeros((0, 3), dtype=np.int64)
    if mesh.face_object is None or not len(outlines.layer):
        return none
    first, second = _near(mesh, int(mesh.face_object.max()) + 1)
    owner = mesh.face_object[outlines.face[outlines.start[:-1]]]
    solid = {number: solid_regions(outlines.selected(owner == number), layers) for number in {*first, *second}}
    found = []
    for one, other in zip(first, second, strict=True):
        shared = shapely.area(shapely.intersection(solid[one], solid[other])) > _SMALLEST_MM2
        found.append((one, other, int(shared.sum())))
    return np.array([row for row in found if row[2]], dtype=np.int64).reshape(-1, 3)


def _near(mesh: TriangleMesh, count: int) -> tuple[list[int], list[int]]:
    """Pairs of objects whose bounding boxes meet."""
    low, high = np.stack([mesh.bounds_of(number) for number in range(count)], axis=1)
    meet = (low[:, None] < high[None]).all(axis=2)
    first, second = np.nonzero(np.triu(meet & meet.T, 1))
    return first.tolist(), second.tolist()
