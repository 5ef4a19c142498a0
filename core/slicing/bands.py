"""Cuts a mesh and links the cuts in bands of layers, so that memory does not grow with the number of cuts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..mesh.inner_walls import inner_walls
from ..model import FloatArray, IntArray, TriangleMesh
from .intersect import crossings
from .link import link
from .outlines import Outlines

_MOST_CUTS = 1 << 19


def linked_outlines(
    mesh: TriangleMesh, planes: FloatArray, gap_closing_radius: float, most_cuts: int = _MOST_CUTS
) -> tuple[Outlines, IntArray]:
    """Cut a mesh with all planes and link the cuts into closed loops.

    If some layers stay open, this is done again without the walls inside the solid and the fins on its outside; the
    result with fewer open layers counts.

    Args:
        mesh: F faces.
        planes: (L,) mm, increasing.
        gap_closing_radius: mm, see `link`.
        most_cuts: of faces with planes that are worked on at once; a layer with more is a band of its own.

    Returns:
        The loops, and (K,) the layers in which an open chain had to be left out, as `link` returns them.
    """
    loops, left_open = _linked(mesh, planes, gap_closing_radius, most_cuts)
    inner = inner_walls(mesh) if len(left_open) else left_open
    if len(inner):
        faces = mesh.faces.copy()
        faces[inner] = faces[inner, :1]  # which no plane cuts
        without, still_open = _linked(replace(mesh, faces=faces), planes, gap_closing_radius, most_cuts)
        if len(still_open) < len(left_open):
            return without, still_open
    return loops, left_open


def _linked(
    mesh: TriangleMesh, planes: FloatArray, gap_closing_radius: float, most_cuts: int
) -> tuple[Outlines, IntArray]:
    cut = crossings(mesh, planes)
    if int((cut.high - cut.low).sum()) <= most_cuts:
        segments = cut.segments()
        del cut  # the system hands freed memory out again faster than new memory
        return link(segments, gap_closing_radius)
    begins, ends = (np.bincount(at, minlength=len(planes) + 1)[: len(planes)] for at in (cut.low, cut.high))
    cuts = np.cumsum(np.cumsum(begins - ends))
    parts, open_layers = [], []
    low = 0
    while low < len(planes):
        done = cuts[low - 1] if low else 0
        high = max(int(np.searchsorted(cuts, done + most_cuts, side="right")), low + 1)
        loops, left_open = link(cut.between(low, high).segments(), gap_closing_radius)
        parts.append(loops)
        open_layers.append(left_open)
        low = high
    return Outlines.joined(parts), np.concatenate(open_layers)
