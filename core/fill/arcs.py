"""The arcs of a region's boundary between neighboring crossings with scan lines."""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..ragged import summable
from ..records import dataclass
from .hatch import Crossings


@dataclass(frozen=True)
class Arcs:
    """One arc for each crossing, from it to the next one around the same ring. X crossings, V vertices.

    Attributes:
        end: (X,) int64, the crossing where the arc ends.
        length: (X,) mm, along the boundary.
        of_vertex: (V,) int64, the arc on which each vertex lies; -1 on a ring that no line cuts and for a vertex that
            only repeats its ring's first one.
    """

    end: IntArray
    length: FloatArray
    of_vertex: IntArray


def arcs(cut: Crossings) -> Arcs:
    """The arcs between the crossings."""
    end = np.arange(1, len(cut.ring) + 1)
    last = np.flatnonzero(np.append(cut.ring[1:] != cut.ring[:-1], True)[: len(cut.ring)])
    end[last] = np.concatenate([[0], last[:-1] + 1])[: len(last)]

    ring_size = np.bincount(cut.ring, minlength=int(cut.vertex_ring[-1]) + 1 if len(cut.vertex_ring) else 0)
    ring_end = np.cumsum(ring_size)
    of_edge = np.bincount(cut.edge, minlength=len(cut.vertices))
    passed = np.cumsum(of_edge) - of_edge  # crossings before each vertex
    of_vertex = np.where(passed > (ring_end - ring_size)[cut.vertex_ring], passed, ring_end[cut.vertex_ring]) - 1
    repeats = np.append(cut.vertex_ring[1:] != cut.vertex_ring[:-1], True)[: len(cut.vertices)]
    of_vertex[(ring_size == 0)[cut.vertex_ring] | repeats] = -1

    steps = summable(np.hypot(np.diff(cut.vertices[:, 0]), np.diff(cut.vertices[:, 1])))
    traveled = np.concatenate([[0.0], np.cumsum(np.where(repeats[:-1], 0.0, steps))])[: len(cut.vertices)]
    place = traveled[cut.edge] + summable(np.hypot(*(cut.places - cut.vertices.take(cut.edge, axis=0)).T))
    length = place[end] - place
    closing = np.flatnonzero(repeats)[cut.vertex_ring[cut.edge[last]]]
    opening = np.concatenate([[0], np.flatnonzero(repeats)[:-1] + 1])[cut.vertex_ring[cut.edge[last]]]
    length[last] += traveled[closing] - traveled[opening]
    return Arcs(end, length, of_vertex)


def strays(cut: Crossings, along: Arcs, asked: BoolArray, closeness_mm: float) -> BoolArray:
    """Which arcs stray from the straight line between their ends.

    An arc is a curve from one end to the other, so if all of it is near the line, then all of the line is near it.

    Args:
        cut: the crossings.
        along: the arcs between them.
        asked: (X,) bool, arcs to look at.
        closeness_mm: how far an arc may stray.

    Returns:
        (X,) bool, False for those not asked for.
    """
    vertex = np.flatnonzero(along.of_vertex >= 0)
    vertex = vertex[asked[along.of_vertex[vertex]]]
    arc = along.of_vertex[vertex]
    start = cut.places.take(arc, axis=0)
    line = cut.places.take(along.end[arc], axis=0) - start
    offset = cut.vertices.take(vertex, axis=0) - start
    share = np.clip(np.einsum("ij,ij->i", offset, line) / np.einsum("ij,ij->i", line, line), 0.0, 1.0)
    distance = np.hypot(*(offset - share[:, None] * line).T)
    result = np.zeros(len(cut.x), dtype=bool)
    result[arc[distance > closeness_mm]] = True
    return result
