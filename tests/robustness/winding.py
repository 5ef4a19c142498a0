"""Inside or outside a mesh by counting what rays cross: shares nothing with the slicing that it is held against."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from dualcolor.core.model import TriangleMesh
from dualcolor.core.slicing.regions import gathered, regions_of
from dualcolor.core.slicing.slices import REGION_TOLERANCE, Slices


@dataclass(frozen=True)
class Agreement:
    """Random points in the layers' planes, in the slices and in the mesh.

    Attributes:
        tried: how many points.
        left_out: of them, those in layers of which the slices say that outlines were left out; not compared.
        unambiguous: of the others, those that all six rays count alike.
        disagreements: of these, those that the outlines place on the other side, or the regions, which have fewer
            points, by more than their tolerance.
        inside: of these, those within.
    """

    tried: int
    left_out: int
    unambiguous: int
    disagreements: int
    inside: int


def agreement(mesh: TriangleMesh, cut: Slices, count: int, seed: int = 1) -> Agreement:
    """Compare slices with the mesh at random points of the bounding box, each at the height of a layer's plane."""
    random = np.random.default_rng(seed)
    low, high = mesh.bounds
    layer = random.integers(0, len(cut.layers), count)
    points = np.column_stack([random.uniform(low[:2], high[:2], (count, 2)), cut.layers.plane[layer]])
    exact = regions_of(cut.outlines)
    outlined, filled = (
        shapely.contains_xy(regions[layer], points[:, 0], points[:, 1])
        for regions in (gathered(exact.polygons, exact.polygon_layer, len(cut.layers)), cut.regions)
    )
    near = shapely.dwithin(shapely.boundary(cut.regions)[layer], shapely.points(points[:, :2]), REGION_TOLERANCE)
    triangles = mesh.vertices[mesh.faces]
    counts = np.concatenate([ray_windings(triangles, points, axis) for axis in range(3)])
    left_out = np.isin(layer, cut.open_layers)
    clear = (counts == counts[0]).all(axis=0) & ~left_out
    within = counts[0] != 0
    wrong = (within != outlined) | ((within != filled) & ~near)
    return Agreement(
        tried=count,
        left_out=int(left_out.sum()),
        unambiguous=int(clear.sum()),
        disagreements=int((clear & wrong).sum()),
        inside=int((clear & within).sum()),
    )


def ray_windings(triangles: np.ndarray, points: np.ndarray, axis: int) -> np.ndarray:
    """(2, P) winding numbers of points (P, 3) by rays towards the end and towards the beginning of an axis."""
    flat = [(axis + 1) % 3, (axis + 2) % 3]
    corners, places = triangles[:, :, flat], points[:, flat]
    low, high = corners.min(axis=1), corners.max(axis=1)
    tree = shapely.STRtree(shapely.points(places))
    face, point = tree.query(shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1]))
    a, b, c = corners[face].transpose(1, 0, 2)
    at = places[point]
    whole, of_a, of_b, of_c = _cross(a, b, c), _cross(b, c, at), _cross(c, a, at), _cross(a, b, at)
    hit = ((of_a > 0) & (of_b > 0) & (of_c > 0)) | ((of_a < 0) & (of_b < 0) & (of_c < 0))
    face, point = face[hit], point[hit]
    weights = np.stack([of_a[hit], of_b[hit], of_c[hit]], axis=1) / whole[hit, None]
    height = np.einsum("ij,ij->i", weights, triangles[face, :, axis])
    sign, above = np.sign(whole[hit]), height > points[point, axis]
    upwards = np.bincount(point[above], sign[above], len(points))
    downwards = -np.bincount(point[~above], sign[~above], len(points))
    return np.rint([upwards, downwards]).astype(np.int64)


def _cross(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    first, second = b - a, c - a
    return first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
