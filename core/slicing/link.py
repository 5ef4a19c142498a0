"""Segments → closed loops, by pointer jumping over all layers at once."""

from __future__ import annotations

import numpy as np

from ..model import IntArray
from ..pattern.chunks import CHUNK_ROWS, in_threads
from ..texture.islands import complex_uv
from .cycles import cycles
from .gaps import close_chains
from .intersect import Segments, between, edge_shares, following_corner
from .outlines import Outlines, starts


def link(segments: Segments, gap_closing_radius: float) -> tuple[Outlines, IntArray]:
    """Join segments that meet on the same mesh edge into closed loops, ordered by layer.

    Args:
        segments: of all layers.
        gap_closing_radius: mm; open chains whose ends lie within twice this are closed.

    Returns:
        The loops, and (K,) the layers in which an open chain had to be left out.
    """
    open_layers = np.zeros(0, dtype=np.int64)
    if (segments.successor < 0).any():
        segments, open_layers = close_chains(segments, 2 * gap_closing_radius)
    root, rank = cycles(segments.successor)
    return _in_order(segments, root, rank), open_layers


def _in_order(segments: Segments, root: IntArray, rank: IntArray) -> Outlines:
    roots = np.flatnonzero(root == np.arange(len(root)))
    by_layer = np.argsort(segments.layer[roots], kind="stable")
    place = np.empty(len(root), dtype=np.int64)
    place[roots[by_layer]] = np.arange(len(roots))
    loop = place[root]
    count = np.bincount(loop, minlength=len(roots))
    start = starts(count)
    order = np.empty(len(root), dtype=np.int64)
    order[start[loop] + rank] = np.arange(len(root))
    return _cut(segments, order, start, segments.layer[roots[by_layer]])


def _cut(segments: Segments, order: IntArray, start: IntArray, layer: IntArray) -> Outlines:
    """The outlines that segments, in their order (N,), make up; M + 1 starts and M layers, see `Outlines`."""
    mesh, count = segments.mesh, len(order)
    # Numbers in one piece are read and worked out several times as fast as short rows: two as a complex one.
    height = mesh.vertices[:, 2].copy()
    place, uv = complex_uv(mesh.vertices[:, :2]), complex_uv(mesh.face_uv).ravel()
    tone = None if np.isnan(mesh.face_tone).all() else mesh.face_tone.ravel()
    points, face = np.empty((count, 2)), np.empty(count, dtype=np.int64)
    carried = np.empty((count, 2, 3))

    def cut(begin: int) -> None:
        """Some of the segments."""
        some = slice(begin, begin + CHUNK_ROWS)
        plane = segments.planes.take(segments.layer.take(order[some]))
        for end, edges in enumerate((segments.tail, segments.head)):
            edge = edges.take(order[some])
            after = following_corner(edge)
            low, high, share, along = edge_shares(mesh.faces, height, edge, after, plane)
            if end == 0:
                face[some] = edge // 3
                points[some] = between(place, low, high, share).view(np.float64).reshape(-1, 2)
            carried[some, end, :2] = between(uv, edge, after, along).view(np.float64).reshape(-1, 2)
            carried[some, end, 2] = np.nan if tone is None else between(tone, edge, after, along)

    in_threads(cut, range(0, count, CHUNK_ROWS))
    return Outlines(points, start, layer, face, carried)
