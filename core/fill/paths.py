"""Everything inside the waved outline as paths: inner walls, skins and sparse fill."""

from __future__ import annotations

import numpy as np
import shapely

from ..model import BoolArray, FloatArray, IntArray, Shapes
from ..parallel import geos_in_threads
from ..paths import Feature, Paths, way_ahead
from ..ragged import sums
from ..records import dataclass
from ..settings import PrintSettings
from ..slicing.planes import line_widths, middle_heights
from .bridges import Bridges, bridged
from .concentric import nested
from .gap_fill import gap_paths, gaps_between, margins, narrow_fill
from .gyroid import gyroid_paths
from .hatch import crossings, long_enough, rotated, spans
from .joining import LinkLimits, joined
from .offsets import offset_outlines
from .skins import Skins, solid_and_sparse
from .walls import boundary_paths, wall_paths, walls_and_fill

_LONGEST_SPARSE_LINK = 3.0  # in spacings, along the wall
_CROWDED, _LEAST_SHARE = 0.97, 0.7  # of a line's width
_LONGEST_SOLID_LINK = 4.0  # in line widths, along the lines; beside a boundary that they run along links would pile up

# Turns of the lines of one layer against `infill_angle`, °.
_STRAIGHT_PATTERNS = {"rectilinear": (0.0,), "grid": (0.0, 90.0), "triangles": (0.0, 60.0, 120.0)}


@dataclass(frozen=True)
class Hatching:
    """Regions to hatch, N of them, and how.

    Attributes:
        regions: (N,) Polygon or MultiPolygon.
        island: (N,) int64.
        feature: (N,) int64, SKIN or INFILL.
        angle_deg: (N,) direction of the lines.
        spacing_mm: (N,) distance of the lines.
        width_mm: (N,) of the lines.
    """

    regions: Shapes
    island: IntArray
    feature: IntArray
    angle_deg: FloatArray
    spacing_mm: FloatArray
    width_mm: FloatArray


def wall_areas(
    islands: Shapes, straight: Shapes, island_layer: IntArray, settings: PrintSettings
) -> tuple[Shapes, ...]:
    """Divide each island into walls, gaps and what is to be filled; no island depends on another.

    Args:
        islands: (I,) valid Polygon or MultiPolygon, maybe empty, simplified: what lies inside the innermost center line
            of the waved wall of each connected region.
        straight: (I,) where the outer wall has no wave beside others that do, see `outer_wall.straight_parts`.
        island_layer: (I,) int64.
        settings: walls, P = `perimeters` of them, and fill.

    Returns:
        2 P + 3 arrays (I,): P + 1 of regions, the islands and what each wall's center line bounds, from the outside in;
        P + 1 of gaps, between each of these and the next, and inside the last; one of what is to be filled.
    """

    def chunk(islands: Shapes, straight: Shapes, layer: IntArray) -> tuple[Shapes, ...]:
        width = line_widths(layer, settings)
        walls, fill, steps = walls_and_fill(islands, width, settings)
        narrow, fill = narrow_fill(fill, straight, width, settings)
        return *walls, *gaps_between(walls, steps, straight, width, settings), narrow, fill

    return geos_in_threads(chunk, islands, straight, island_layer)


def fill_areas(fill: Shapes, solid: Shapes, whole: BoolArray, settings: PrintSettings) -> tuple[Shapes, Shapes]:
    """Divide what is to be filled of each island into skins and sparse fill, (I,) each; no island depends on another.

    Args:
        fill: (I,) as of `wall_areas`.
        solid: (I,) where these are to be solid, see `Skins.regions`.
        whole: (I,) bool, islands that are solid throughout.
        settings: of the fill.
    """

    def chunk(fill: Shapes, solid: Shapes, whole: BoolArray) -> tuple[Shapes, ...]:
        return solid_and_sparse(fill, Skins(solid, whole), settings)

    skins, sparse = geos_in_threads(chunk, fill, solid, whole)
    return skins, sparse


def fill_lines(
    walls: tuple[Shapes, ...],
    fill: tuple[Shapes, Shapes],
    over_air: Bridges,
    island_layer: IntArray,
    settings: PrintSettings,
) -> Paths:
    """The lines that fill areas.

    Args:
        walls: (I,) each, as of `wall_areas`.
        fill: (I,) each, as of `fill_areas`.
        over_air: the bridges among the skins.
        island_layer: (I,) int64.
        settings: walls, skins and fill.

    Returns:
        INNER_WALL loops whose first center line lies a line width inside the island's boundary, and SKIN, BRIDGE
        and INFILL lines. Islands are numbered by their place in `island_layer`.
    """
    width, count = line_widths(island_layer, settings), settings.perimeters + 1
    centers, gaps = walls[1:count], walls[count : 2 * count]
    with gap_paths(gaps, margins(settings), island_layer, width) as along_gaps:  # GEOS triangulates, numpy hatches
        lines = _hatched(*fill, over_air, island_layer, settings)
        return Paths.joined([wall_paths(centers, island_layer, width), *along_gaps(), *lines])


def _hatched(
    solid: Shapes, sparse: Shapes, over_air: Bridges, island_layer: IntArray, settings: PrintSettings
) -> list[Paths]:
    """Bridges, skins and sparse fill."""
    width = line_widths(island_layer, settings)
    spanned, solid, sparse = bridged(over_air, solid, sparse)
    if not settings.is_hollow and settings.infill_pattern != "concentric":  # whose loops keep off their walls anyway
        sparse = _beside_walls(sparse, width)
    lines = [hatch_paths(plain_hatching(solid, sparse, island_layer, settings), island_layer)]
    if len(spanned.island):
        lines.append(hatch_paths(bridge_hatching(spanned, island_layer, settings), island_layer))
    if not settings.is_hollow and settings.infill_pattern == "gyroid":
        height = middle_heights(island_layer, settings)
        lines.append(gyroid_paths(sparse, island_layer, height, width, settings))
    if not settings.is_hollow and settings.infill_pattern == "concentric":
        loops, island = nested(sparse, settings.extrusion_width * 100.0 / settings.infill_density)
        lines.append(boundary_paths(loops, island, island_layer, width, Feature.INFILL))
    return lines


def _beside_walls(sparse: Shapes, width_mm: FloatArray) -> Shapes:
    """(I,) sparse regions less half a width, where the middles of lines may be: links run beside walls, not on them."""
    inner, some = sparse.copy(), np.flatnonzero(~shapely.is_empty(sparse))
    inner[some] = offset_outlines(sparse[some], -0.5 * width_mm[some])
    return inner


def plain_hatching(solid: Shapes, sparse: Shapes, island_layer: IntArray, settings: PrintSettings) -> Hatching:
    """Angles and spacings of hatches: skins are lines side by side; of sparse fill, the density sets the spacing.

    Args:
        solid: (I,) regions of the islands.
        sparse: (I,) regions of the islands.
        island_layer: (I,) layer of each island.
        settings: the infill's density, pattern and angle and the widths are read.

    Returns:
        Skins, and sparse fill if its pattern is of straight lines.
    """
    angle, width = settings.infill_angle, line_widths(island_layer, settings)
    alternating = np.where(island_layer % 2 == 0, angle, -angle)
    rows = [(solid, Feature.SKIN, alternating, width)]
    turns = () if settings.is_hollow else _STRAIGHT_PATTERNS.get(settings.infill_pattern, ())
    for turn in turns:
        direction = alternating if len(turns) == 1 else np.full(len(island_layer), angle + turn)
        rows.append((sparse, Feature.INFILL, direction, len(turns) * width * 100.0 / settings.infill_density))
    return Hatching(
        regions=np.concatenate([row[0] for row in rows]),
        island=np.tile(np.arange(len(island_layer)), len(rows)),
        feature=np.concatenate([np.full(len(island_layer), int(row[1])) for row in rows]),
        angle_deg=np.concatenate([row[2] for row in rows]),
        spacing_mm=np.concatenate([row[3] for row in rows]),
        width_mm=np.tile(width, len(rows)),
    )


def bridge_hatching(found: Bridges, island_layer: IntArray, settings: PrintSettings) -> Hatching:
    """Bridges are lines side by side, each in its own direction; `bridge_flow` makes them thicker or thinner."""
    width = line_widths(island_layer[found.island], settings)
    feature = np.full(len(width), int(Feature.BRIDGE), dtype=np.int64)
    return Hatching(found.regions, found.island, feature, found.angle_deg, width, settings.bridge_flow * width)


def hatch_paths(hatching: Hatching, island_layer: IntArray) -> Paths:
    """Hatch all regions and join the lines.

    The lines of skins end half a width before the boundary, earlier where it slants, and the links to the next line
    run there; so length times width is the region's area. Sparse lines end on the boundary of their region.
    """
    width = hatching.width_mm
    half = 0.5 * float(width.min(initial=np.inf))
    cut = crossings(hatching.regions, hatching.angle_deg, hatching.spacing_mm)
    found = spans(cut)
    skin = hatching.feature != Feature.INFILL
    limits = LinkLimits(
        closeness_mm=half,
        straight_mm=np.where(skin, _LONGEST_SOLID_LINK * width, np.inf),
        boundary_mm=np.where(skin, 0.0, _LONGEST_SPARSE_LINK * hatching.spacing_mm),
    )
    keep = long_enough(cut, found, half)
    points, start, region = joined(cut, found, keep, np.where(skin, 0.5 * width, 0.0), limits)
    island, count = hatching.island[region], np.diff(start)
    width = width * _room_for_links(hatching, points, start, region)
    return Paths(
        points=rotated(points, hatching.angle_deg, np.repeat(region, count)),
        start=start,
        layer=island_layer[island].astype(np.int64),
        feature=hatching.feature[region].astype(np.int64),
        island=island.astype(np.int64),
        closed=np.zeros(len(region), dtype=bool),
        width=np.repeat(width[region], count),
    )


def _room_for_links(hatching: Hatching, points: FloatArray, start: IntArray, region: IntArray) -> FloatArray:
    """(N,) share of its width that a region's lines of skin take, 1 but where their links alone overfill it.

    Args:
        hatching: N regions.
        points: (P, 2) mm.
        start: (K + 1,) where each of the lines starts.
        region: (K,) of each line.
    """
    skin = hatching.feature == Feature.SKIN
    laid = np.bincount(region, sums(way_ahead(points, start[1:] - 1), start), len(skin)) * hatching.width_mm
    room = np.where(skin, shapely.area(hatching.regions), laid)
    share = np.divide(room, laid, out=np.ones(len(skin)), where=laid > 0)
    return np.where(share < _CROWDED, np.maximum(share, _LEAST_SHARE), 1.0)
