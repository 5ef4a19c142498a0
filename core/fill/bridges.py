"""Bridges: skins over air that span it from side to side, and the direction in which their lines run."""

from __future__ import annotations

import numpy as np
import shapely

from ..model import BoolArray, FloatArray, IntArray, Shapes
from ..records import dataclass
from ..settings import PrintSettings
from .hatch import crossings, spans
from .offsets import offset
from .skins import Skins, remainder, uncovered

_SMALLEST_MM2 = 5.0  # a strand or two hold over less by themselves
_LEAST_HELD = 0.6  # share of a bridge whose lines are held at both ends
_AS_GOOD = 0.02  # of that share: then the shorter lines are better
_DIRECTIONS = 36  # that are tried, besides those of the narrowest rectangle around it
_LINES_TRIED = 24  # across a square of the same area, or as many as are printed
_EDGE_MM = 0.5  # or the lines' distance; edges are held or not as a whole
_ANCHOR = 2.5  # line widths by which a bridge reaches into what carries it, and within which walls carry it


@dataclass(frozen=True)
class Bridges:
    """Skins over air, B of them.

    Attributes:
        regions: (B,) Polygon or MultiPolygon, what carries their ends included.
        island: (B,) int64, not decreasing.
        angle_deg: (B,) direction of the lines.
    """

    regions: Shapes
    island: IntArray
    angle_deg: FloatArray

    def selected(self, keep: BoolArray) -> Bridges:
        """The bridges that `keep` (B,) marks."""
        return Bridges(self.regions[keep], self.island[keep], self.angle_deg[keep])


def bridges(inside: Shapes, found: Skins, outlines: Shapes, island_layer: IntArray, settings: PrintSettings) -> Bridges:
    """Find the skins that nothing lies under and that two sides hold.

    Args:
        inside: (I,) the region to fill of each island, or somewhat more.
        found: the skins in it.
        outlines: (L,) cross-section of each layer, simplified by a twentieth of a millimeter or less.
        island_layer: (I,) layer of each island.
        settings: `is_hollow` and `extrusion_width` are used.

    Returns:
        Bridges whose regions reach beyond what is filled, see `bridged`.
    """
    below = _walls_only(inside, found, outlines, island_layer) if settings.is_hollow else outlines
    parts, island = _over_air(inside, found, below, island_layer, settings.extrusion_width)
    if not len(parts):
        return Bridges(parts, island, np.zeros(0))
    carrying = below[island_layer[island] - 1]
    held, angle = _directions(parts, carrying, settings.extrusion_width)
    grown = offset(parts[held], _ANCHOR * settings.extrusion_width)
    return Bridges(grown, island[held], angle[held])


def bridged(found: Bridges, solid: Shapes, sparse: Shapes) -> tuple[Bridges, Shapes, Shapes]:
    """Take bridges out of the skins and the sparse fill.

    Args:
        found: bridges, which may reach beyond what is filled.
        solid: (I,) skins of the islands.
        sparse: (I,) sparse fill of the islands.

    Returns:
        The bridges' part of both; (I,) what is left of the skins and (I,) of the sparse fill.
    """
    whole = shapely.union(solid[found.island], sparse[found.island])
    inside = Bridges(_apart(shapely.intersection(found.regions, whole), found.island), found.island, found.angle_deg)
    return inside, _without(solid, inside), _without(sparse, inside)


def _without(regions: Shapes, found: Bridges) -> Shapes:
    """(I,) regions of the islands less the bridges in them."""
    rest = regions.copy()
    for island in np.unique(found.island):
        spanned = shapely.union_all(found.regions[found.island == island])
        part = shapely.intersection(rest[island : island + 1], spanned)
        rest[island : island + 1] = remainder(rest[island : island + 1], part)
    return rest


def _walls_only(inside: Shapes, found: Skins, outlines: Shapes, island_layer: IntArray) -> Shapes:
    """(L,) cross-sections less the hollow inside."""
    rows = np.flatnonzero(~found.whole)
    hollow = shapely.difference(inside[rows], found.regions[rows])
    below = outlines.copy()
    for layer in np.unique(island_layer[rows]):
        below[layer] = shapely.difference(below[layer], shapely.union_all(hollow[island_layer[rows] == layer]))
    return below


def _over_air(
    inside: Shapes, found: Skins, below: Shapes, island_layer: IntArray, width_mm: float
) -> tuple[Shapes, IntArray]:
    """Connected parts of skins with nothing below, without narrow ones and small ones, and their islands."""
    rows = np.flatnonzero((found.whole | ~shapely.is_empty(found.regions)) & (island_layer > 0))
    pieces, owner = uncovered(inside[rows], island_layer[rows], below, [-1], _SMALLEST_MM2)
    island = rows[owner]
    some = ~found.whole[island]
    pieces[some] = shapely.intersection(pieces[some], found.regions[island[some]])
    parts, piece = shapely.get_parts(offset(offset(pieces, -width_mm), width_mm), return_index=True)
    large = shapely.area(parts) >= _SMALLEST_MM2
    return parts[large], island[piece[large]].astype(np.int64)


def _directions(parts: Shapes, carrying: Shapes, width_mm: float) -> tuple[BoolArray, FloatArray]:
    """Which parts are held from two sides, and the direction in which most of their lines take the shortest way across.

    Args:
        parts: (P,) Polygon.
        carrying: (P,) cross-section below each.
        width_mm: of the lines.
    """
    spacing = np.maximum(width_mm, np.sqrt(shapely.area(parts)) / _LINES_TRIED)
    parts = shapely.segmentize(parts, np.maximum(_EDGE_MM, spacing))
    held_edge = _held_edges(parts, carrying, _ANCHOR * width_mm)
    even = np.arange(_DIRECTIONS)[:, None] * (180.0 / _DIRECTIONS) + np.zeros(len(parts))
    along = _rectangle_angle(parts)
    angle = np.concatenate([along[None], along[None] + 90.0, even])
    tried = angle.size
    cut = crossings(np.tile(parts, len(angle)), angle.ravel(), np.tile(spacing, len(angle)))
    found = spans(cut)
    region = cut.region[found.left]
    length = cut.x[found.right] - cut.x[found.left]
    edge = cut.edge % len(held_edge)
    held = held_edge[edge[found.left]] & held_edge[edge[found.right]]
    whole = np.bincount(region, length, tried).reshape(angle.shape)
    carried = np.bincount(region, length * held, tried).reshape(angle.shape)
    longest = np.zeros(tried)
    np.maximum.at(longest, region, length * held)
    share = carried / np.maximum(whole, 1e-9)
    span = np.where(share >= share.max(axis=0) - _AS_GOOD, longest.reshape(angle.shape), np.inf)
    best = np.argmin(span, axis=0)
    return share.max(axis=0) >= _LEAST_HELD, angle[best, np.arange(len(parts))]


def _held_edges(parts: Shapes, carrying: Shapes, reach_mm: float) -> BoolArray:
    """(V,) bool, whether the edge that leaves each vertex of (P,) polygons lies near what carries its polygon."""
    vertices, part = shapely.get_coordinates(parts, return_index=True)
    middle = (vertices + np.roll(vertices, -1, axis=0)) / 2
    near = shapely.intersection(carrying, shapely.buffer(shapely.envelope(parts), 2 * reach_mm))
    shapely.prepare(near)
    return np.asarray(shapely.dwithin(near[part], shapely.points(middle), reach_mm))


def _rectangle_angle(parts: Shapes) -> FloatArray:
    """(P,) ° of the first side of the narrowest rectangle around each polygon."""
    corners = shapely.get_coordinates(shapely.oriented_envelope(parts)).reshape(len(parts), 5, 2)
    side = corners[:, 1] - corners[:, 0]
    return np.asarray(np.degrees(np.arctan2(side[:, 1], side[:, 0])))


def _apart(regions: Shapes, island: IntArray) -> Shapes:
    """Regions less what an earlier region of the same island covers already."""
    for row in np.flatnonzero(island[1:] == island[:-1]) + 1:
        earlier = shapely.union_all(regions[:row][island[:row] == island[row]])
        regions[row] = shapely.difference(regions[row], earlier)
    return regions
