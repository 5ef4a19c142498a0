"""Where the inside is solid: the skins that close the print above and below, following its shape."""

from __future__ import annotations

import numpy as np
import shapely

from ..model import BoolArray, IntArray, Shapes
from ..records import dataclass
from ..settings import PrintSettings
from ..slicing.regions import gathered
from .offsets import offset, polygonal

_GRID_MM = 1e-4  # the safe but slow way of overlaying: vertices on a grid
_AREA_ERROR_MM2 = 0.01  # of an overlay that went right


@dataclass(frozen=True)
class Skins:
    """Where the fill of I islands is to be solid.

    Attributes:
        regions: (I,) Polygon or MultiPolygon, beyond the region to fill as well; empty where nothing is.
        whole: (I,) bool, islands that are solid throughout; their `regions` are empty.
    """

    regions: Shapes
    whole: BoolArray


def skins(inside: Shapes, island_layer: IntArray, outlines: Shapes, settings: PrintSettings) -> Skins:
    """Find what any of the `top_solid_layers` layers above and `bottom_solid_layers` layers below leaves uncovered.

    But for slivers, which are dropped, it is grown by a line width, so that it rests on what is beside sparse fill.

    Args:
        inside: (I,) the region to fill of each island, or somewhat more.
        island_layer: (I,) layer of each island.
        outlines: (L,) whole cross-section of each layer.
        settings: the numbers of solid layers, `is_solid` and `extrusion_width` are read.
    """
    regions = np.full(len(inside), shapely.Polygon(), dtype=object)
    if settings.is_solid:
        return Skins(regions, np.ones(len(inside), dtype=bool))
    steps = [*range(-settings.bottom_solid_layers, 0), *range(settings.top_solid_layers, 0, -1)]
    width_mm = settings.extrusion_width
    sliver_mm2 = np.pi * (0.25 * width_mm) ** 2  # below this nothing is left half a width wide
    pieces, owner = uncovered(inside, island_layer, outlines, steps, sliver_mm2)
    whole = np.bincount(owner, shapely.area(pieces), len(inside)) >= shapely.area(inside) - _AREA_ERROR_MM2
    pieces, owner = pieces[~whole[owner]], owner[~whole[owner]]
    cores, piece = shapely.get_parts(offset(pieces, -0.25 * width_mm), return_index=True)
    wide = ~shapely.is_empty(cores)
    grown = gathered(cores[wide], owner[piece[wide]], len(inside))
    rows = np.flatnonzero(~shapely.is_empty(grown))
    regions[rows] = offset(grown[rows], 1.25 * width_mm)
    return Skins(regions, whole)


def solid_and_sparse(fill: Shapes, found: Skins, settings: PrintSettings) -> tuple[Shapes, Shapes]:
    """Divide the region to fill of every island into its skins and its sparse inside.

    Sparse fill too small to hold more than a line or two becomes solid.

    Args:
        fill: (I,) region to fill of each island.
        found: where these are to be solid.
        settings: `is_hollow` and `solid_infill_below_area` are read.

    Returns:
        (I,) solid and (I,) sparse regions; they do not overlap, and together they are `fill`.
    """
    remnant_mm2 = 0.0 if settings.is_hollow else settings.solid_infill_below_area
    solid, sparse = fill.copy(), np.full(len(fill), shapely.Polygon(), dtype=object)
    open_inside = ~found.whole & (shapely.area(fill) >= remnant_mm2)
    plain = open_inside & shapely.is_empty(found.regions)
    solid[plain], sparse[plain] = shapely.Polygon(), fill[plain]
    cut = np.flatnonzero(open_inside & ~plain)
    solid[cut], sparse[cut] = _parted(fill[cut], found.regions[cut])
    return _with_remnants(fill, solid, sparse, remnant_mm2)


def uncovered(
    inside: Shapes, layer: IntArray, outlines: Shapes, steps: list[int], smallest_mm2: float
) -> tuple[Shapes, IntArray]:
    """The parts of regions that at least one of some other layers leaves uncovered.

    Most regions lie well inside the other outlines, which a prepared predicate tells ten times as fast as an overlay.
    Only the others are cut, and each time only what is still covered. The farthest layers should come first, as they
    cover the least.

    Args:
        inside: (I,) regions.
        layer: (I,) layer of each region.
        outlines: (L,) cross-sections; below the first and above the last there is nothing.
        steps: the other layers, relative to a region's own.
        smallest_mm2: pieces below this are left out.

    Returns:
        (P,) Polygon, pieces that do not overlap; what different layers leave bare may touch. (P,) int64, the region of
        each.
    """
    other = layer + np.asarray(steps, dtype=np.int64)[:, None]
    alone = ((other < 0) | (other >= len(outlines))).any(axis=0)
    rows = np.flatnonzero(~alone)
    left, pieces, owner = inside[rows], [inside[alone]], [np.flatnonzero(alone)]
    if len(rows) and steps:
        other = other[:, rows]
        low = other.min()
        near = shapely.force_2d(outlines[low : other.max() + 1])  # a copy: see below
        shapely.prepare(near)  # a prepared shape must not be shared between threads
        for cutters in near[other - low]:
            cut = np.flatnonzero(~shapely.contains_properly(cutters, left) & ~shapely.is_empty(left))
            left[cut], piece = _parted(left[cut], cutters[cut])
            pieces.append(piece)
            owner.append(rows[cut])
    parts, piece_of = shapely.get_parts(np.concatenate(pieces), return_index=True)
    large = (shapely.area(parts) >= smallest_mm2) & ~shapely.is_empty(parts)
    return parts[large], np.concatenate(owner)[piece_of[large]].astype(np.int64)


def _parted(whole: Shapes, cutters: Shapes) -> tuple[Shapes, Shapes]:
    """The parts of regions inside others and the parts outside them; all (N,).

    Where boundaries coincide up to rounding, GEOS now and then loses a large piece without an error. The areas tell;
    then the overlay is repeated on a grid of 0.1 µm, which is safe but takes twice the time.
    """
    within, beyond = shapely.intersection(cutters, whole), shapely.difference(whole, cutters)
    wrong = _wrong(whole, within, beyond)
    within[wrong] = shapely.intersection(cutters[wrong], whole[wrong], grid_size=_GRID_MM)
    beyond[wrong] = shapely.difference(whole[wrong], cutters[wrong], grid_size=_GRID_MM)
    return polygonal(within), polygonal(beyond)


def _wrong(whole: Shapes, *parts: Shapes) -> BoolArray:
    """(N,) bool, where the areas of parts do not add up."""
    return np.asarray(np.abs(shapely.area(whole) - sum(map(shapely.area, parts))) > _AREA_ERROR_MM2)


def remainder(whole: Shapes, parts: Shapes) -> Shapes:
    """Regions less parts of them, (N,) both; checked as in `_parted`."""
    rest: Shapes = shapely.difference(whole, parts)
    wrong = _wrong(whole, parts, rest)
    rest[wrong] = shapely.difference(whole[wrong], parts[wrong], grid_size=_GRID_MM)
    return polygonal(rest)


def _with_remnants(inside: Shapes, solid: Shapes, sparse: Shapes, smallest_mm2: float) -> tuple[Shapes, Shapes]:
    """Give sparse parts that are smaller than an area to the solid region."""
    parts, owner = shapely.get_parts(sparse, return_index=True)
    large = (shapely.area(parts) >= smallest_mm2) & (shapely.get_dimensions(parts) == 2)
    poor = np.unique(owner[~large & ~shapely.is_empty(parts)])
    kept = large & np.isin(owner, poor) & ~shapely.is_empty(parts)
    solid[poor], sparse[poor] = inside[poor], shapely.Polygon()
    left = gathered(parts[kept], owner[kept], len(sparse))
    rows = np.flatnonzero(~shapely.is_empty(left))
    sparse[rows] = left[rows]
    solid[rows] = remainder(inside[rows], left[rows])
    return solid, sparse
