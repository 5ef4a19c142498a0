"""Where the inside is solid: the skins that close the print above and below, following its shape."""

from __future__ import annotations

import numpy as np
import shapely

from ..model import IntArray
from ..settings import PrintSettings
from .parallel import Shapes, in_chunks
from .walls import offset

_GRID_MM = 1e-4  # the safe but slow way of overlaying: vertices on a grid
_AREA_ERROR_MM2 = 0.01  # of an overlay that went right
_SMALLEST_SPARSE_MM2 = 10.0  # a sparse remnant below this holds a line or two at best


def solid_and_sparse(
    outlines: Shapes, fill: Shapes, island_layer: IntArray, settings: PrintSettings
) -> tuple[Shapes, Shapes]:
    """Divide the region to fill of every island into its skins and its sparse inside.

    Solid is what is not covered by all of the `top_solid_layers` layers above and the `bottom_solid_layers` below,
    less slivers, grown by a line width so that it stands on the sparse fill's neighbours. Remnants of sparse fill too
    small to hold a line become solid.

    Args:
        outlines: (L,) whole cross-section of each layer.
        fill: (I,) region to fill of each island.
        island_layer: (I,) layer of each island.
        settings: the numbers of solid layers, `infill_density` and `extrusion_width` are read.

    Returns:
        (I,) solid and (I,) sparse regions; they do not overlap, and together they are `fill`.
    """
    if settings.infill_density >= 100.0:
        return fill, np.full(len(fill), shapely.Polygon(), dtype=object)
    steps = [*range(-settings.bottom_solid_layers, 0), *range(settings.top_solid_layers, 0, -1)]
    width_mm = settings.extrusion_width
    sliver_mm2 = np.pi * (0.25 * width_mm) ** 2  # below this nothing is left half a width wide
    remnant_mm2 = _SMALLEST_SPARSE_MM2 if settings.infill_density > 0.0 else 0.0

    def chunk(inside: Shapes, layer: IntArray) -> tuple[Shapes, Shapes]:
        pieces, owner = uncovered(inside, layer, outlines, steps, sliver_mm2)
        solid, sparse = _divided(inside, pieces, owner, width_mm)
        return _with_remnants(inside, solid, sparse, remnant_mm2)

    solid, sparse = fill.copy(), np.full(len(fill), shapely.Polygon(), dtype=object)
    rows = np.flatnonzero(shapely.area(fill) >= remnant_mm2)
    solid[rows], sparse[rows] = in_chunks(chunk, fill[rows], island_layer[rows])
    return solid, sparse


def uncovered(
    inside: Shapes, layer: IntArray, outlines: Shapes, steps: list[int], smallest_mm2: float
) -> tuple[Shapes, IntArray]:
    """What of regions is not covered by all of some other layers.

    Most regions lie well inside their neighbours' outlines, which a prepared predicate tells ten times faster than an
    overlay; so only the others are cut, and of them only what is left. The farthest layers should come first, as they
    leave the least.

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
    """What of regions lies within others and what beyond, (N,) all.

    Where boundaries run along each other within rounding errors, GEOS is now and then wrong by a large piece without
    a word; the areas tell, and then it works on a grid of 0.1 µm, which is safe but takes twice the time.
    """
    within, beyond = shapely.intersection(cutters, whole), shapely.difference(whole, cutters)
    wrong = np.abs(shapely.area(whole) - shapely.area(within) - shapely.area(beyond)) > _AREA_ERROR_MM2
    within[wrong] = shapely.intersection(cutters[wrong], whole[wrong], grid_size=_GRID_MM)
    beyond[wrong] = shapely.difference(whole[wrong], cutters[wrong], grid_size=_GRID_MM)
    return _polygonal(within), _polygonal(beyond)


def remainder(whole: Shapes, parts: Shapes) -> Shapes:
    """Regions less parts of them, (N,) both; checked as in `_parted`."""
    rest: Shapes = shapely.difference(whole, parts)
    wrong = np.abs(shapely.area(whole) - shapely.area(parts) - shapely.area(rest)) > _AREA_ERROR_MM2
    rest[wrong] = shapely.difference(whole[wrong], parts[wrong], grid_size=_GRID_MM)
    return _polygonal(rest)


def _polygonal(shapes: Shapes) -> Shapes:
    """Without the lines and points where shapes only touch."""
    mixed = shapely.get_type_id(shapes) == shapely.GeometryType.GEOMETRYCOLLECTION
    mixed |= shapely.get_dimensions(shapes) < 2
    shapes[mixed] = shapely.buffer(shapes[mixed], 0.0)
    return shapes


def _divided(inside: Shapes, pieces: Shapes, owner: IntArray, width_mm: float) -> tuple[Shapes, Shapes]:
    """The regions' part within a width of (P,) uncovered pieces, slivers apart, and the rest of them."""
    solid, sparse = np.full(len(inside), shapely.Polygon(), dtype=object), inside.copy()
    bare = np.bincount(owner, shapely.area(pieces), len(inside)) >= shapely.area(inside) - _AREA_ERROR_MM2
    solid[bare], sparse[bare] = inside[bare], shapely.Polygon()
    pieces, owner = pieces[~bare[owner]], owner[~bare[owner]]
    cores, piece = shapely.get_parts(offset(pieces, -0.25 * width_mm), return_index=True)
    wide = ~shapely.is_empty(cores)
    if wide.any():
        of_region = owner[piece[wide]]
        order = np.argsort(of_region, kind="stable")
        rows, group = np.unique(of_region[order], return_inverse=True)
        gathered = shapely.multipolygons(cores[wide][order], indices=group)
        solid[rows], sparse[rows] = _parted(inside[rows], offset(gathered, 1.25 * width_mm))
    return solid, sparse


def _with_remnants(inside: Shapes, solid: Shapes, sparse: Shapes, smallest_mm2: float) -> tuple[Shapes, Shapes]:
    """Give sparse parts below an area to the solid region."""
    parts, owner = shapely.get_parts(sparse, return_index=True)
    large = (shapely.area(parts) >= smallest_mm2) & (shapely.get_dimensions(parts) == 2)
    poor = np.unique(owner[~large & ~shapely.is_empty(parts)])
    kept = large & np.isin(owner, poor) & ~shapely.is_empty(parts)
    solid[poor], sparse[poor] = inside[poor], shapely.Polygon()
    if kept.any():
        rows, group = np.unique(owner[kept], return_inverse=True)
        sparse[rows] = shapely.multipolygons(parts[kept], indices=group)
        solid[rows] = remainder(inside[rows], sparse[rows])
    return solid, sparse
