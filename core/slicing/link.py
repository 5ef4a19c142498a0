"""Segments → closed loops, by pointer jumping over all layers at once."""

from __future__ import annotations

import numpy as np

from ..mesh.corners import complex_uv
from ..model import FloatArray, IntArray, TriangleMesh
from ..parallel import CHUNK_ROWS
from ..ragged import ahead
from .cycles import cycles
from .gaps import close_chains
from .intersect import Segments, between, columns_of, cut_edges, ends_of, faces_of
from .outlines import Outlines


def link(segments: Segments, gap_closing_radius: float) -> tuple[Outlines, IntArray]:
    """Join segments that meet on the same mesh edge into closed loops, ordered by layer.

    Args:
        segments: of all layers.
        gap_closing_radius: mm; open chains whose ends lie within twice this are closed.

    Returns:
        The loops, and (K,) the layers in which an open chain had to be left out.
    """
    open_layers = np.zeros(0, dtype=np.int64)
    has_gaps = bool((segments.successor < 0).any())
    if has_gaps:
        segments, open_layers = close_chains(segments, 2 * gap_closing_radius)
    order, start = cycles(segments.successor, segments.layer)
    layer = segments.layer.take(order[start[:-1]])
    mesh, plane = segments.mesh, np.repeat(segments.planes.take(layer), np.diff(start))
    tail = segments.tail.take(order)
    del segments, order  # the system hands freed memory out again faster than new memory
    points, share = _cut(mesh, tail, plane)
    # Where a segment ends, the next one starts: on the same edge, seen from the face beyond.
    arrival = _cut(mesh, tail ^ 1, plane)[1] if has_gaps else ahead(share, start)
    del plane
    carried = _carried(mesh, tail, (share, arrival))
    return Outlines(points, start, layer, faces_of(tail), carried), open_layers


def _cut(mesh: TriangleMesh, edge: IntArray, plane: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where planes cut edges: (N, 2) mm, and (N,) the share of the way up the edge."""
    count, columns = len(edge), columns_of(mesh)
    points, share = np.empty(count, dtype=np.complex128), np.empty(count)
    for begin in range(0, count, CHUNK_ROWS):
        some = slice(begin, begin + CHUNK_ROWS)
        points[some], share[some] = cut_edges(*columns, *ends_of(edge[some]), plane[some])
    return points.view(np.float64).reshape(-1, 2), share


def _carried(mesh: TriangleMesh, tail: IntArray, shares: tuple[FloatArray, FloatArray]) -> FloatArray:
    """(N, 2, C) u, v and, if there is any, tone at both ends of segments, which lie at `shares` (N,) of their edges."""
    count = len(tail)
    uv = complex_uv(mesh.face_uv).ravel()
    tone = None if np.isnan(mesh.face_tone).all() else mesh.face_tone.ravel()
    carried = np.empty((count, 2, 2 if tone is None else 3))
    places = carried[..., :2].view(np.complex128)[..., 0]
    for begin in range(0, count, CHUNK_ROWS):
        some = slice(begin, begin + CHUNK_ROWS)
        for end in range(2):
            ends, share = ends_of(tail[some] ^ end), shares[end][some]
            places[some, end] = between(uv, *ends, share)
            if tone is not None:
                carried[some, end, 2] = between(tone, *ends, share)
    return carried
