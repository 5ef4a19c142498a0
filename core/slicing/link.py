"""Segments → closed loops, by pointer jumping over all layers at once."""

from __future__ import annotations

import numpy as np

from ..model import FloatArray, IntArray
from ..pattern.chunks import in_chunks
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
    layer = segments.layer[roots][by_layer]
    tail = segments.tail[order]
    points, carried = _cut(segments, tail, segments.head[order], segments.planes.take(np.repeat(layer, count)))
    return Outlines(points, start, layer, tail // 3, carried)


def _cut(segments: Segments, tail: IntArray, head: IntArray, plane: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(N, 2) mm, where segments start, and (N, 2, 3) what they carry, see `Outlines`."""
    mesh = segments.mesh
    # Columns in one piece are read and worked out several times as fast as short rows.
    x, y, z = np.ascontiguousarray(mesh.vertices.T)
    values = [mesh.face_uv[..., 0].ravel(), mesh.face_uv[..., 1].ravel()]
    if not np.isnan(mesh.face_tone).all():
        values.append(mesh.face_tone.ravel())

    def chunk(tail: IntArray, head: IntArray, plane: FloatArray) -> tuple[FloatArray, FloatArray]:
        points, carried = np.empty((len(tail), 2)), np.full((len(tail), 2, 3), np.nan)
        for end, edge in enumerate((tail, head)):
            low, high, share = edge_shares(mesh.faces, z, edge, plane)
            if end == 0:
                points[:, 0], points[:, 1] = (between(column, low, high, share) for column in (x, y))
            after = following_corner(edge)
            share = np.where(low == mesh.faces.take(edge), share, 1 - share)
            for number, value in enumerate(values):
                carried[:, end, number] = between(value, edge, after, share)
        return points, carried

    points, carried = in_chunks(chunk, tail, head, plane)
    return points, carried
