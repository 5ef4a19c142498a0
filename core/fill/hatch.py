"""Hatching of all regions of all layers at once: parallel scan lines cut by the regions' edges."""

from __future__ import annotations

import numpy as np
import shapely

from ..model import BoolArray, FloatArray, IntArray, Shapes
from ..records import dataclass

_STEPS_A_MM = 1 << 14  # on scan lines, to tell what comes first


@dataclass(frozen=True)
class Crossings:
    """Where scan lines cut the boundaries of regions. X crossings in the order of the boundary, ring by ring.

    Everything is in the frame of the region's scan lines: x runs along them and line k lies at y = k · spacing.

    Attributes:
        x: (X,) mm.
        places: (X, 2) mm, x and y together.
        line: (X,) int64, number of the scan line, counted from the origin of the bed.
        ring: (X,) int64, ascending.
        edge: (X,) int64, index into `vertices` of the start of the edge cut, ascending.
        region: (X,) int64.
        vertices: (V, 2) mm, of all rings, each with its first vertex repeated at its end.
        vertex_ring: (V,) int64.
    """

    x: FloatArray
    places: FloatArray
    line: IntArray
    ring: IntArray
    edge: IntArray
    region: IntArray
    vertices: FloatArray
    vertex_ring: IntArray


@dataclass(frozen=True)
class Spans:
    """The pieces of scan lines inside regions, S of them, ordered by region, line and x.

    Attributes:
        left: (S,) int64, the crossing at the lesser x.
        right: (S,) int64, the crossing at the greater x.
    """

    left: IntArray
    right: IntArray


def crossings(regions: Shapes, angle_deg: FloatArray, spacing_mm: FloatArray) -> Crossings:
    """Cut the boundary of every region by its own family of scan lines.

    A line takes the edges that start at or below it and end above it, or the reverse. So a vertex on a line counts
    for one of its two edges or for both or none, and every line cuts every ring an even number of times.

    Args:
        regions: (N,) Polygon or MultiPolygon, maybe empty.
        angle_deg: (N,) direction of the lines, counter-clockwise from +X.
        spacing_mm: (N,) distance of the lines.
    """
    parts, part_region = shapely.get_parts(regions, return_index=True)
    rings, ring_part = shapely.get_rings(parts, return_index=True)
    ring_region = part_region[ring_part].astype(np.int64)
    points, vertex_ring = shapely.get_coordinates(rings, return_index=True)
    vertex_region = ring_region[vertex_ring]
    vertices = rotated(points, -angle_deg, vertex_region)
    height = vertices[:, 1] / spacing_mm[vertex_region]
    above = np.ceil(height).astype(np.int64)  # first line at or above each vertex
    edge = np.flatnonzero(vertex_ring[1:] == vertex_ring[:-1])
    count = above[edge + 1] - above[edge]
    edge, count = edge[count != 0], count[count != 0]

    times = np.abs(count)
    step = np.arange(times.sum()) - np.repeat(np.cumsum(times) - times, times)
    upwards = np.repeat(count > 0, times)
    edge = np.repeat(edge, times)
    line = np.where(upwards, above[edge] + step, above[edge] - 1 - step)
    share = (line - height[edge]) / (height[edge + 1] - height[edge])
    x = vertices[edge, 0] + share * (vertices[edge + 1, 0] - vertices[edge, 0])
    ring = vertex_ring[edge].astype(np.int64)
    region = ring_region[ring]
    places = np.stack([x, line * spacing_mm[region]], axis=1)
    return Crossings(x, places, line, ring, edge, region, vertices, vertex_ring.astype(np.int64))


def spans(cut: Crossings) -> Spans:
    """Pair the crossings of each line of each region: from an odd one to the next one is inside."""
    lowest = int(cut.line.min(initial=0))
    lines = int(cut.line.max(initial=0)) - lowest + 1
    place = np.floor(cut.x * _STEPS_A_MM).astype(np.int64)
    place -= place.min(initial=0)
    # All in one number, line after line.
    place += (cut.region * lines + cut.line - lowest) * (int(place.max(initial=0)) + 1)
    order = np.argsort(place, kind="stable")
    return Spans(order[0::2], order[1::2])


def rotated(points: FloatArray, angle_deg: FloatArray, group: IntArray) -> FloatArray:
    """(N, 2) points turned counter-clockwise about the origin by the angle (G,) of each one's group (N,)."""
    turned = np.ascontiguousarray(points).view(np.complex128).ravel() * np.exp(1j * np.radians(angle_deg))[group]
    return np.asarray(turned.view(np.float64).reshape(-1, 2))


def long_enough(cut: Crossings, found: Spans, least_mm: float) -> BoolArray:
    """(S,) bool, spans that are worth a move."""
    keep: BoolArray = cut.x[found.right] - cut.x[found.left] >= least_mm
    return keep
