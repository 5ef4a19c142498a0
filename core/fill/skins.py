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
    remnant_mm2 = _SMALLEST_SPARSE_MM2 if settings.infill_density > 0.0 else 0.0

    def chunk(inside: Shapes, layer: IntArray) -> tuple[Shapes, Shapes]:
        solid, sparse = _divided(inside, *covered(inside, layer, outlines, steps), settings.extrusion_width)
        return _with_remnants(inside, solid, sparse, remnant_mm2)

    solid, sparse = in_chunks(chunk, fill, island_layer)
    return solid, sparse


def covered(inside: Shapes, layer: IntArray, outlines: Shapes, steps: list[int]) -> tuple[Shapes, Shapes]:
    """What is left of regions where all of some other layers cover them, and what is not.

    Most regions lie well inside their neighbours' outlines, which a prepared predicate tells twenty times faster than
    an intersection; so only the others are cut. The farthest layers should come first, as they leave the least. What
    is not covered is cut out by the neighbour's outline and not by what is left, whose edges are the region's own: such
    an overlay takes five times as long.

    Args:
        inside: (I,) regions.
        layer: (I,) layer of each region.
        outlines: (L,) cross-sections; below the first and above the last there is nothing.
        steps: the other layers, relative to a region's own.

    Returns:
        (I,) Polygon or MultiPolygon, the very objects of `inside` where nothing is uncovered; (I,) the rest of them.
    """
    left, bared = inside.copy(), np.full(len(inside), shapely.Polygon(), dtype=object)
    if not len(inside):
        return left, bared
    low = max(int(layer.min()) + min(steps, default=0), 0)
    near = shapely.force_2d(outlines[low : int(layer.max()) + max(steps, default=0) + 1])  # a copy: see below
    shapely.prepare(near)  # a prepared shape must not be shared between threads
    for step in steps:
        other = layer + step
        bare = (other < 0) | (other >= len(outlines))
        left[bare], bared[bare] = shapely.Polygon(), inside[bare]
        rows = np.flatnonzero(~bare & ~shapely.is_empty(left))
        rows = rows[~shapely.contains_properly(near[other[rows] - low], left[rows])]
        again = left[rows] != inside[rows]  # cut before, along an outline that may be nearly the same
        for part, grid_mm in ((rows[~again], None), (rows[again], _GRID_MM)):
            cutters = near[other[part] - low]
            left[part] = _polygonal(shapely.intersection(cutters, left[part], grid_size=grid_mm))
            cut_off = shapely.difference(inside[part], cutters)
            bared[part] = _polygonal(shapely.union(bared[part], cut_off) if grid_mm else cut_off)
    wrong = np.abs(shapely.area(inside) - shapely.area(left) - shapely.area(bared)) > _AREA_ERROR_MM2
    bared[wrong] = remainder(inside[wrong], left[wrong])
    return left, bared


def remainder(whole: Shapes, parts: Shapes) -> Shapes:
    """Regions less parts of them, (N,) both.

    Where boundaries run along each other within rounding errors, GEOS is now and then wrong by a large piece without
    a word; the areas tell, and then it works on a grid of 0.1 µm, which is safe but takes twice the time.
    """
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


def _divided(inside: Shapes, cover: Shapes, bared: Shapes, width_mm: float) -> tuple[Shapes, Shapes]:
    """The regions' part within a width of what is not covered, slivers apart, and the rest of them."""
    solid, sparse = np.full(len(inside), shapely.Polygon(), dtype=object), inside.copy()
    bare = shapely.is_empty(cover)
    solid[bare], sparse[bare] = inside[bare], shapely.Polygon()
    rows = np.flatnonzero((cover != inside) & ~bare)
    core = offset(bared[rows], -0.25 * width_mm)
    wide = ~shapely.is_empty(core)
    rows = rows[wide]
    whole, grown = inside[rows], offset(core[wide], 1.25 * width_mm)
    # Both overlays with the same shape: the difference of a region and its own part takes five times as long.
    skin, rest = shapely.intersection(whole, grown), shapely.difference(whole, grown)
    wrong = np.abs(shapely.area(whole) - shapely.area(skin) - shapely.area(rest)) > _AREA_ERROR_MM2
    skin[wrong] = shapely.intersection(whole[wrong], grown[wrong], grid_size=_GRID_MM)
    rest[wrong] = shapely.difference(whole[wrong], grown[wrong], grid_size=_GRID_MM)
    solid[rows], sparse[rows] = _polygonal(skin), _polygonal(rest)
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
