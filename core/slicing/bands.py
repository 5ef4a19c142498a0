"""Cutting and linking in bands of layers, so that a large job never holds all its cuts with all that they need."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..model import FloatArray, IntArray, TriangleMesh
from .intersect import intersect
from .link import link
from .outlines import Outlines

_MOST_CUTS = 1 << 17


def linked_outlines(
    mesh: TriangleMesh, planes: FloatArray, gap_closing_radius: float, most_cuts: int = _MOST_CUTS
) -> tuple[Outlines, IntArray]:
    """The loops of all layers and the layers in which a chain is left open, as `link` gives them.

    Args:
        mesh: F faces.
        planes: (L,) mm, increasing.
        gap_closing_radius: mm, see `link`.
        most_cuts: of faces with planes that are worked on at once; a layer with more is a band of its own.
    """
    height = mesh.vertices[:, 2][mesh.faces]
    first = np.searchsorted(planes, height.min(axis=1), side="right")
    end = np.searchsorted(planes, height.max(axis=1), side="right")
    if int((end - first).sum()) <= most_cuts:
        return link(intersect(mesh, planes), gap_closing_radius)
    begins, ends = (np.bincount(at, minlength=len(planes) + 1)[: len(planes)] for at in (first, end))
    cuts = np.cumsum(np.cumsum(begins - ends))
    parts, open_layers = [], []
    low = 0
    while low < len(planes):
        done = cuts[low - 1] if low else 0
        high = max(int(np.searchsorted(cuts, done + most_cuts, side="right")), low + 1)
        rows = np.flatnonzero((first < high) & (end > low))
        cut = intersect(_part(mesh, rows), planes[low:high])
        loops, left_open = link(replace(cut, layer=cut.layer + low, face=rows[cut.face]), gap_closing_radius)
        parts.append(loops)
        open_layers.append(left_open)
        low = high
    return Outlines.joined(parts), np.concatenate(open_layers)


def _part(mesh: TriangleMesh, rows: IntArray) -> TriangleMesh:
    """Some of the faces, with what is carried along their cuts."""
    return TriangleMesh(
        mesh.vertices, mesh.faces[rows], mesh.face_uv[rows], mesh.face_tone[rows], mesh.face_texture[rows]
    )
