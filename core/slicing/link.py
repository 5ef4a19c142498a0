"""Segments → closed loops, by pointer jumping over all layers at once."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray, IntArray
from ..pattern.chunks import CHUNK_ROWS, in_threads
from ..texture.islands import complex_uv
from .cycles import cycles
from .gaps import close_chains
from .intersect import Segments, between, columns, cut_edges, following_corner
from .outlines import Outlines, ahead


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
    plane = np.repeat(segments.planes.take(layer), np.diff(start))
    tail, head = segments.tail.take(order), segments.head.take(order)
    points, along, opposite = _cut(segments, tail, plane)
    # Where a segment ends, the next one starts: on the same edge, which leads the other way in the face beyond.
    arrival = _cut(segments, head, plane)[1] if has_gaps else ahead(opposite, start)
    face, carried = _carried(segments, (tail, head), (along, arrival))
    return Outlines(points, start, layer, face, carried), open_layers


def _cut(segments: Segments, edge: IntArray, plane: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Where planes cut edges: (N, 2) mm, (N,) the share of the way from corner to corner, and the other way round."""
    mesh, count = segments.mesh, len(edge)
    place, height = columns(mesh)
    points, along, opposite = np.empty(count, dtype=np.complex128), np.empty(count), np.empty(count)

    def cut(begin: int) -> None:
        """Some of the edges."""
        some = slice(begin, begin + CHUNK_ROWS)
        points[some], along[some], opposite[some] = cut_edges(mesh.faces, place, height, edge[some], plane[some])

    in_threads(cut, range(0, count, CHUNK_ROWS))
    return points.view(np.float64).reshape(-1, 2), along, opposite


def _carried(
    segments: Segments, edges: tuple[IntArray, IntArray], shares: tuple[FloatArray, FloatArray]
) -> tuple[IntArray, FloatArray]:
    """Face (N,) and carried values (N, 2, 3) of segments between two edges (N,) at shares (N,) of these."""
    mesh, count = segments.mesh, len(edges[0])
    uv = complex_uv(mesh.face_uv).ravel()
    tone = None if np.isnan(mesh.face_tone).all() else mesh.face_tone.ravel()
    face, carried = np.empty(count, dtype=np.int64), np.full((count, 2, 3), np.nan)

    def carry(begin: int) -> None:
        """Those of some segments."""
        some = slice(begin, begin + CHUNK_ROWS)
        np.floor_divide(edges[0][some], 3, out=face[some])
        for end in range(2):
            edge, share = edges[end][some], shares[end][some]
            after = following_corner(edge)
            place = between(uv, edge, after, share)
            carried[some, end, 0], carried[some, end, 1] = place.real, place.imag
            if tone is not None:
                carried[some, end, 2] = between(tone, edge, after, share)

    in_threads(carry, range(0, count, CHUNK_ROWS))
    return face, carried
