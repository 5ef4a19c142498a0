"""The supports of the whole print."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from ..fill.parallel import Shapes
from ..model import FloatArray, TriangleMesh
from ..pattern.contours import Contours
from ..settings import PrintSettings
from ..slicing.slices import Slices
from ..toolpaths.moves import Paths
from .columns import columns, standing_on_bed
from .lines import interface, support_lines
from .marks import marks
from .overhangs import contacts
from .overlay import distinct, nothing
from .room import taken_room
from .stability import steady


@dataclass(frozen=True)
class Supports:
    """The supports of a print of L layers.

    Attributes:
        paths: of feature SUPPORT and SUPPORT_INTERFACE, in the layers' own colours: they add no tool change.
        areas: (L,) what the centre lines of their lines cover.
    """

    paths: Paths
    areas: Shapes


def supports(mesh: TriangleMesh, cut: Slices, lines: Contours, depth: FloatArray, settings: PrintSettings) -> Supports:
    """Support all overhangs, as far as the user does not wish otherwise; or nothing without `support_enable`.

    Args:
        mesh: what was sliced, with the user's marks.
        cut: the slices.
        lines: contours of its outlines.
        depth: (N,) mm, of the wave at each contour point.
        settings: those of supports, and the extrusion width and layer heights.

    Raises:
        MeshError: a volume that enforces or blocks supports is open.
    """
    if not settings.support_enable:
        return Supports(Paths.empty(), nothing(len(cut.regions)))
    needed = contacts(cut, settings, marks(mesh, cut.layers.plane))
    taken = taken_room(cut, lines, depth, needed.gap, settings)
    found = columns(needed, taken)
    if settings.support_from == "bed":
        found = standing_on_bed(found)
    found = steady(found, needed, taken, settings.layer_height)
    close = interface(found, needed.area, settings)
    return Supports(support_lines(found, close, settings), found)


def with_supports(regions: Shapes, areas: Shapes, settings: PrintSettings) -> Shapes:
    """Cross-sections of the object and its supports, (R,), those of the first layer in one at the beginning.

    Args:
        regions: (L,) of the object.
        areas: (L,) of the supports' centre lines.
        settings: `extrusion_width` is used.
    """
    half = settings.extrusion_width / 2
    first = shapely.union(regions[0], shapely.buffer(areas[0], half, quad_segs=2))
    # Columns hardly change from layer to layer.
    others = shapely.buffer(distinct(shapely.get_parts(areas[1:])), half, quad_segs=2)
    return np.concatenate([[first], regions[1:], others])
