"""The lines that supports are printed with: sparse ones that break away, close ones under the object."""

from __future__ import annotations

import numpy as np
import shapely

from ..fill.hatch import crossings, long_enough, rotated, spans
from ..fill.joining import LinkLimits, joined
from ..fill.offsets import offset
from ..model import BoolArray, FloatArray, IntArray, Shapes
from ..parallel import geos_in_threads
from ..paths import Feature, Paths
from ..records import dataclass
from ..settings import PrintSettings
from ..slicing.planes import first_line_width
from ..slicing.regions import gathered, ring_points
from ..toolpaths.loops import FirstIsland
from .grid_overlay import areas, nothing, once, overlapping, thickness

# Lines run along X, and the close ones across them, so that they do not fall between.
_ANGLE_DEG, _INTERFACE_ANGLE_DEG = 0.0, 90.0
_ARC_SEGMENTS = 4
_NARROW = 2.5  # thickness in spacings below which a support gets a loop
_LONGEST_LINK = 3.0  # in spacings, along the edge of the support
_TUBE_MM = 6.5  # thickness up to which a support with a loop needs lines inside only near its top
_TOP_MM = 1.5  # of a tube that has lines inside: the lowest sag from side to side, the highest carry
_STRAIGHTNESS_MM = 0.01  # links that stray from the edge by more follow it


@dataclass(frozen=True)
class Areas:
    """Areas of support to fill alike. S of them.

    Attributes:
        shapes: (S,) areas of center lines.
        layer: (S,) int64.
        feature: SUPPORT or SUPPORT_INTERFACE.
        spacing_mm: distance of the lines.
        width_mm: of the lines.
        angle_deg: their direction.
    """

    shapes: Shapes
    layer: IntArray
    feature: Feature
    spacing_mm: float
    width_mm: float
    angle_deg: float


def interface(found: Shapes, contact: Shapes, settings: PrintSettings) -> tuple[Shapes, Shapes]:
    """The part of the supports that lies right under the object, (L,), and the rest of them, (L,).

    Args:
        found: (L,) areas of support.
        contact: (L,) what supports that end on each layer carry.
        settings: `support_interface_layers` and `support_interface_spacing` are used.
    """
    count, layers = len(found), settings.support_interface_layers
    if not layers:
        return nothing(count), found
    rows = np.arange(count)[:, None] + np.arange(layers)
    near = np.append(contact, shapely.Polygon())[np.minimum(rows, count)]
    some = np.flatnonzero(~shapely.is_empty(near).all(axis=1) & ~shapely.is_empty(found))
    close, below = nothing(count), found.copy()

    def chunk(parts: Shapes, carried: Shapes) -> tuple[Shapes, Shapes]:
        pieces, owner = shapely.get_parts(carried.ravel(), return_index=True)
        whole = gathered(pieces, owner // layers, len(parts))
        # Grown by a spacing, so that narrow stripes under a slope join and thickened columns are covered.
        under = shapely.buffer(whole, settings.support_interface_spacing, quad_segs=_ARC_SEGMENTS)
        return areas(shapely.intersection(parts, under)), areas(shapely.difference(parts, under))

    close[some], below[some] = geos_in_threads(chunk, found[some], near[some])
    return close, below


def support_lines(below: Shapes, close: Shapes, settings: PrintSettings) -> Paths:
    """Lines in all areas of support.

    Args:
        below: (L,) areas of support, for the center lines, that do not carry the object directly.
        close: (L,) those that do.
        settings: the supports' spacings and the widths of lines are used.

    Returns:
        Paths of feature SUPPORT and SUPPORT_INTERFACE on the island `FirstIsland.SUPPORT`.
    """
    layer = np.arange(len(below))
    wide, fine = settings.support_spacing, min(settings.support_interface_spacing, settings.support_spacing)
    first, usual = first_line_width(settings), settings.extrusion_width
    dense = max(fine, first)  # the first layer holds on to the bed
    parts = []
    for rows, spacing, width, shapes, feature, angle in (
        (layer[:1], dense, first, below, Feature.SUPPORT, _ANGLE_DEG),
        (layer[1:], wide, usual, below, Feature.SUPPORT, _ANGLE_DEG),
        (layer[:1], dense, first, close, Feature.SUPPORT_INTERFACE, _INTERFACE_ANGLE_DEG),
        (layer[1:], fine, usual, close, Feature.SUPPORT_INTERFACE, _INTERFACE_ANGLE_DEG),
    ):
        parts += _filled(Areas(shapes[rows], rows, feature, spacing, width, angle), settings)
    return Paths.joined(parts)


def _filled(areas: Areas, settings: PrintSettings) -> list[Paths]:
    """Lines, and a loop around each part that is too narrow for them to stand without it; tubes have the loop alone."""
    width = areas.width_mm
    parts, owner = shapely.get_parts(areas.shapes, return_index=True)
    printable = shapely.length(parts) > 2 * width
    parts, owner = parts[printable], owner[printable]
    narrow = thickness(parts) < _NARROW * areas.spacing_mm
    ribbed = narrow.copy()
    ribbed[narrow] &= ~_tubes(parts[narrow], areas.layer[owner[narrow]], settings)
    within = once(lambda some: (offset(some, -width),), parts[ribbed])  # its lines lie beside the loop's
    inside = np.concatenate([parts[~narrow], within])
    of_layer = np.concatenate([owner[~narrow], owner[ribbed]])
    return [_hatched(areas, inside, of_layer), _loops(areas, parts[narrow], owner[narrow])]


def _tubes(parts: Shapes, layer: IntArray, settings: PrintSettings) -> BoolArray:
    """(P,) bool, narrow parts that go on as such above, so that nothing rests on what is inside.

    Args:
        parts: (P,) Polygons.
        layer: (P,) of each, not decreasing.
        settings: the height of layers and the width of lines are used.
    """
    ahead = int(np.ceil(_TOP_MM / settings.layer_height))
    upper, lower = overlapping(parts, layer, parts, layer - ahead)
    around = once(lambda some: (offset(some, settings.extrusion_width),), parts)
    found = np.zeros(len(parts), dtype=bool)
    found[lower[shapely.covers(around[upper], parts[lower])]] = True
    return found & (thickness(parts) < _TUBE_MM)


def _hatched(areas: Areas, shapes: Shapes, owner: IntArray) -> Paths:
    """Parallel lines in shapes (H,), joined along their edges; `owner` (H,) is the row of each in the areas."""
    everywhere = np.ones(len(shapes))
    angle, spacing = areas.angle_deg * everywhere, areas.spacing_mm * everywhere
    cut = crossings(shapes, angle, spacing)
    found = spans(cut)
    limits = LinkLimits(_STRAIGHTNESS_MM, 2 * spacing, _LONGEST_LINK * spacing)
    keep = long_enough(cut, found, areas.width_mm)
    points, start, row = joined(cut, found, keep, 0 * everywhere, limits)
    points = rotated(points, angle, np.repeat(row, np.diff(start)))
    return _paths(areas, points, start, areas.layer[owner[row]], closed=False)


def _loops(areas: Areas, parts: Shapes, owner: IntArray) -> Paths:
    """One loop along the outer boundary of each of parts (P,)."""
    points, start = ring_points(shapely.get_exterior_ring(parts))
    return _paths(areas, points, start, areas.layer[owner], closed=True)


def _paths(areas: Areas, points: FloatArray, start: IntArray, layer: IntArray, closed: bool) -> Paths:
    feature, island, width = areas.feature, FirstIsland.SUPPORT, areas.width_mm
    return Paths.alike(points, start, layer, feature=feature, island=island, closed=closed, width=width)
