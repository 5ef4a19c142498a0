"""Where supports must not be: at the waved walls, with some air around them."""

from __future__ import annotations

import numpy as np
import shapely

from ..contours.contours import Contours
from ..fill.offsets import offset_outlines
from ..model import FloatArray, Shapes
from ..parallel import geos_in_threads
from ..pattern.wave import valley_lines
from ..settings import PrintSettings
from ..slicing.planes import line_widths
from ..slicing.regions import gathered
from ..slicing.slices import Slices
from ..toolpaths.outer_wall import inside_of_lines
from .grid_overlay import GRID_MM, SIMPLIFY_MM

# The object's outlines may differ from the true ones by this much, mm.
_TOLERANCE_MM = 0.03
# Distances are longer by all that the shapes may be off, and by what sharp edges stand out of the smooth contour.
_MARGIN_MM = 3 * _TOLERANCE_MM + 2 * SIMPLIFY_MM + 2 * GRID_MM


def taken_room(cut: Slices, lines: Contours, depth: FloatArray, gap: int, settings: PrintSettings) -> Shapes:
    """(L,) where the object leaves no room for the center lines of supports.

    That is, on the same layer, all that is nearer to the waved outline than the distance asked for, and on the layers
    of air above and below all that would touch a strand.

    Args:
        cut: the slices.
        lines: contours of its outlines.
        depth: (N,) mm, of the wave at each contour point, peak to peak.
        gap: layers of air between a support and the object, above and below.
        settings: the widths of lines and `support_xy_distance` are used.
    """
    # What lies inside the line through the valleys of the opposite wave lies inside the line through the crests.
    crest = valley_lines(lines, -depth, np.zeros_like(depth))
    outside = inside_of_lines(lines, crest, len(cut.polygons), _TOLERANCE_MM)
    parts, owner = shapely.get_parts(outside, return_index=True)
    crests = gathered(parts, cut.polygon_layer[owner], len(cut.regions))
    # Half a line of the wall and half a line of the support.
    room = line_widths(np.arange(len(cut.regions)), settings) + _MARGIN_MM

    def chunk(crest: Shapes, room: FloatArray) -> tuple[Shapes, Shapes]:
        touching = offset_outlines(crest, room)
        return touching, offset_outlines(touching, np.full(len(room), settings.support_xy_distance))

    touching, beside = geos_in_threads(chunk, crests, room)
    return _with_neighbors(beside, touching, gap)


def _with_neighbors(beside: Shapes, touching: Shapes, gap: int) -> Shapes:
    """(L,) a layer's own areas and those of the layers up to `gap` above and below."""
    taken = beside.copy()
    for step in (*range(-gap, 0), *range(1, gap + 1)):
        row = np.arange(max(-step, 0), len(taken) - max(step, 0))

        def chunk(whole: Shapes, more: Shapes) -> tuple[Shapes]:
            result = whole.copy()
            # Steep walls stay within the distance to the sides.
            shapely.prepare(whole)
            rows = np.flatnonzero(~shapely.covers(whole, more))
            result[rows] = shapely.union(whole[rows], more[rows])
            return (result,)

        (taken[row],) = geos_in_threads(chunk, taken[row], touching[row + step])
    return taken
