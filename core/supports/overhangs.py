"""Which areas of each layer hang over air, and where the support that they need has its top."""

from __future__ import annotations

import numpy as np
import shapely

from ..fill.bridges import Bridges
from ..fill.offsets import offset, offset_outlines, simplified
from ..model import FloatArray, IntArray, Shapes
from ..parallel import geos_in_threads
from ..records import dataclass
from ..settings import PrintSettings
from ..slicing.planes import Layers
from ..slicing.regions import gathered
from ..slicing.slices import Slices
from .grid_overlay import areas, nothing, thickness
from .marks import Marks

# Outlines are simplified by this much, mm, before layers are compared.
TOLERANCE_MM = 0.02
# Overhangs below this area (mm²) are roundings.
_SMALLEST_MM2 = 0.02
_GREATEST_SLANT = 8  # a support that ends lower than this carries nothing
# Walls that lean out by less than half of this a layer, mm, carry themselves, whatever is wished.
_THINNEST_MM = 0.1


@dataclass(frozen=True)
class Contacts:
    """What supports have to carry, by the layer on which the support ends. L layers.

    Attributes:
        area: (L,) where the object hangs over the support's top.
        islands: (P,) polygons of the object that begin in the air, or that are held by the user's wish: worth a
            support however small they are.
        island_layer: (P,) int64, the layer on which the support of each ends.
        gap: layers of air between a support and the object.
        slant: layers by which the support of a slope may end lower, where the air beside the object takes its top.
    """

    area: Shapes
    islands: Shapes
    island_layer: IntArray
    gap: int
    slant: int


def contacts(
    cut: Slices, settings: PrintSettings, wished: Marks | None = None, spanned: Bridges | None = None
) -> Contacts:
    """Find the overhangs of all layers.

    Args:
        cut: the slices.
        settings: `support_auto`, `support_threshold_angle`, the distances of supports, `layer_height`,
            `extrusion_width`, `perimeters` and those of the waves are used.
        wished: where supports are enforced and blocked.
        spanned: bridges that hold without supports, unless these are enforced.
    """
    # What is to keep apart must not melt together because layers are thick.
    gap = max(round(settings.support_z_distance / settings.layer_height), int(settings.support_z_distance > 0))
    count = len(cut.regions)
    hanging = overhangs(cut.regions, _reach(cut.layers, settings)) if settings.support_auto else nothing(count)
    if spanned is not None:
        hanging = _without_bridges(hanging, spanned, cut.polygon_layer, settings)
    forced, forced_layer = nothing(0), np.zeros(0, dtype=np.int64)
    if wished:
        hanging, forced, forced_layer = _as_wished(cut.regions, hanging, wished)
    shift = gap + 1  # an overhang of layer i lies on top of layer i - 1
    area = nothing(count)
    area[: max(count - shift, 0)] = hanging[shift:]
    islands, layer = _islands(cut, hanging)
    islands, layer = np.concatenate([islands, forced]), np.concatenate([layer, forced_layer])
    kept = layer >= shift
    slant = _GREATEST_SLANT if len(forced) else _slant(settings)
    return Contacts(area, islands[kept], layer[kept] - shift, gap, gap + slant)


def _without_bridges(hanging: Shapes, spanned: Bridges, polygon_layer: IntArray, settings: PrintSettings) -> Shapes:
    """(L,) overhangs less bridges and the walls along them, which are held at the same ends."""
    left, layer = hanging.copy(), polygon_layer[spanned.island]
    rows = np.unique(layer[~shapely.is_empty(hanging[layer])])
    with_walls = offset(spanned.regions, (settings.perimeters + 1) * settings.extrusion_width)
    united = [shapely.union_all(with_walls[layer == row]) for row in rows.tolist()]
    left[rows] = _sizeable(areas(shapely.difference(hanging[rows], united)))
    return left


def _as_wished(regions: Shapes, hanging: Shapes, wished: Marks) -> tuple[Shapes, Shapes, IntArray]:
    """(L,) the overhangs with what is enforced and without what is blocked; enforced parts (P,), layer of each (P,)."""
    hanging = hanging.copy()
    rows = np.flatnonzero(~shapely.is_empty(wished.enforced[1:])) + 1
    jutting = shapely.difference(regions[rows], regions[rows - 1])
    found = areas(shapely.intersection(jutting, wished.enforced[rows]))
    parts, owner = shapely.get_parts(areas(shapely.difference(found, wished.blocked[rows])), return_index=True)
    large = shapely.area(parts) > _SMALLEST_MM2
    parts, owner = parts[large], owner[large]
    wide = thickness(parts) > _THINNEST_MM
    parts, owner = parts[wide], owner[wide]
    hanging[rows] = areas(shapely.union(hanging[rows], gathered(parts, owner, len(rows))))
    rows_blocked = np.flatnonzero(~shapely.is_empty(wished.blocked) & ~shapely.is_empty(hanging))
    hanging[rows_blocked] = _sizeable(areas(shapely.difference(hanging[rows_blocked], wished.blocked[rows_blocked])))
    return hanging, parts, rows[owner].astype(np.int64)


def _reach(layers: Layers, settings: PrintSettings) -> FloatArray:
    """(L,) mm, how far each layer may jut out over the layer below without support."""
    rise = np.diff(layers.plane, prepend=0.0)
    return np.asarray(rise / np.tan(np.radians(settings.support_threshold_angle)))


def _slant(settings: PrintSettings) -> int:
    """Layers within which the steepest supported slope leaves the air that is kept free beside the object."""
    beside = settings.wave_crest + settings.support_xy_distance + settings.extrusion_width
    rise = beside * np.tan(np.radians(settings.support_threshold_angle))
    return int(min(np.ceil(rise / settings.layer_height), _GREATEST_SLANT))


def overhangs(regions: Shapes, reach: FloatArray) -> Shapes:
    """(L,) the parts of each layer that hang over air, wherever they jut out too far.

    A layer that juts out less than the reach carries itself. Where one juts out farther, all of the part in the air is
    an overhang, up to the edge that it hangs on, so that overhangs of neighboring layers join.

    Args:
        regions: (L,) cross-sections.
        reach: (L,) mm.
    """
    (outlines,) = geos_in_threads(lambda part: (simplified(part, TOLERANCE_MM),), regions)

    def chunk(above: Shapes, below: Shapes, allowed: FloatArray) -> tuple[Shapes]:
        held = offset_outlines(below, allowed)
        shapely.prepare(held)
        found = nothing(len(above))
        rows = np.flatnonzero(~shapely.covers(held, above))
        seeds = _sizeable(areas(shapely.difference(above[rows], held[rows])))
        rows, seeds = rows[~shapely.is_empty(seeds)], seeds[~shapely.is_empty(seeds)]
        jutting = areas(shapely.difference(above[rows], below[rows]))
        around = offset(seeds, allowed[rows] + 2 * TOLERANCE_MM)
        found[rows] = areas(shapely.intersection(jutting, around))
        return (found,)

    hanging = nothing(len(regions))
    if len(regions) > 1:
        (hanging[1:],) = geos_in_threads(chunk, outlines[1:], outlines[:-1], reach[1:])
    return hanging


def _sizeable(shapes: Shapes) -> Shapes:
    """Without parts of next to no area."""
    parts, owner = shapely.get_parts(shapes, return_index=True)
    kept = shapely.area(parts) > _SMALLEST_MM2
    return gathered(parts[kept], owner[kept], len(shapes))


def _islands(cut: Slices, hanging: Shapes) -> tuple[Shapes, IntArray]:
    """The sliced polygons that begin in the air, and the layer of each."""
    candidates = (cut.polygon_layer > 0) & ~shapely.is_empty(hanging[cut.polygon_layer])
    rows = np.flatnonzero(candidates)
    layer = cut.polygon_layer[rows]
    alone = ~shapely.intersects(cut.regions[layer - 1], cut.polygons[rows])
    return cut.polygons[rows[alone]], layer[alone].astype(np.int64)
