"""The supports of the whole print."""

from __future__ import annotations

import shapely
from shapely import Geometry

from ..contours.contours import Contours, reach_of
from ..fill.bridges import Bridges
from ..model import FloatArray, Shapes, TriangleMesh
from ..paths import Paths
from ..records import dataclass
from ..settings import PrintSettings
from ..slicing.planes import first_line_width
from ..slicing.slices import Slices
from .columns import columns, standing_on_bed
from .grid_overlay import nothing
from .lines import interface, support_lines
from .marks import marks
from .overhangs import contacts
from .room import taken_room
from .stability import steady


@dataclass(frozen=True)
class Supports:
    """The supports of a print of L layers.

    Attributes:
        paths: of feature SUPPORT and SUPPORT_INTERFACE, in the layers' own colors: they add no tool change.
        areas: (L,) what the center lines of their lines cover.
    """

    paths: Paths
    areas: Shapes


def supports(
    mesh: TriangleMesh,
    cut: Slices,
    lines: Contours,
    depth: FloatArray,
    settings: PrintSettings,
    spanned: Bridges | None = None,
) -> Supports:
    """Support all overhangs, except where the user blocks it; nothing without `support_enable`.

    Args:
        mesh: what was sliced, with the user's marks.
        cut: the slices.
        lines: contours of its outlines.
        depth: (N,) mm, of the wave at each contour point.
        settings: those of supports and walls, and the layer heights.
        spanned: bridges that get none, unless the user enforces them.

    Raises:
        MeshError: a volume that enforces or blocks supports is open.
    """
    if not settings.support_enable:
        return Supports(Paths.empty(), nothing(len(cut.regions)))
    needed = contacts(cut, settings, marks(mesh, cut.layers.plane), spanned)
    taken = taken_room(cut, lines, depth, needed.gap, settings)
    found = columns(needed, taken)
    if settings.support_from == "bed":
        found = standing_on_bed(found)
    found = steady(found, needed, taken, settings.layer_height)
    close, below = interface(found, needed.area, settings)
    return Supports(support_lines(below, close, settings), found)


def on_bed(region: Geometry, area: Geometry, settings: PrintSettings) -> Geometry:
    """The first layer of the object and its supports; for a brim what lies behind its walls wherever these may lie.

    Args:
        region: cross-section of the object.
        area: of the supports' center lines.
        settings: the width of the first layer's lines, `brim_width` and what moves walls inwards are used.
    """
    own = shapely.buffer(region, -reach_of(settings).inwards) if settings.brim_width else region
    return shapely.union(own, shapely.buffer(area, first_line_width(settings) / 2, quad_segs=2))
