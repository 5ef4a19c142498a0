"""All that lies behind the waved outline, as paths: inner walls, skins and sparse fill."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..model import FloatArray, IntArray
from ..settings import PrintSettings
from ..toolpaths.moves import Feature, Paths
from .hatch import crossings, long_enough, rotated, spans
from .joining import LinkLimits, joined
from .parallel import Shapes
from .skins import solid_and_sparse
from .walls import wall_paths, walls_and_fill

_LONGEST_SPARSE_LINK = 3.0  # in spacings, along the wall
_LONGEST_SOLID_LINK = 4.0  # in line widths, along the lines; beside a boundary that they run along links would pile up


@dataclass(frozen=True)
class Hatching:
    """Regions to hatch, N of them, and how.

    Attributes:
        regions: (N,) Polygon or MultiPolygon.
        island: (N,) int64.
        feature: (N,) int64, SKIN or INFILL.
        angle_deg: (N,) direction of the lines.
        spacing_mm: (N,) distance of the lines.
    """

    regions: Shapes
    island: IntArray
    feature: IntArray
    angle_deg: FloatArray
    spacing_mm: FloatArray


def fill_paths(sliced: Shapes, islands: Shapes, island_layer: IntArray, settings: PrintSettings) -> Paths:
    """Walls, skins and sparse fill of the whole print.

    Args:
        sliced: (L,) Polygon or MultiPolygon, the whole cross-section of each layer, maybe empty; mm.
        islands: (I,) Polygon or MultiPolygon, maybe empty: what lies inside the innermost centre line of the waved
            wall of each connected region.
        island_layer: (I,) int64 layer of each island.
        settings: walls, skins and fill.

    Returns:
        INNER_WALL loops whose first centre line lies a line width inside the island's boundary, and SKIN and INFILL
        polylines. Islands are numbered by their place in `islands`; every line is `extrusion_width` wide.
    """
    walls, fill = walls_and_fill(islands, settings)
    solid, sparse = solid_and_sparse(sliced, fill, island_layer, settings)
    hatching = planned(solid, sparse, island_layer, settings)
    return Paths.joined(
        [wall_paths(walls, island_layer, settings.extrusion_width), hatch_paths(hatching, island_layer, settings)]
    )


def planned(solid: Shapes, sparse: Shapes, island_layer: IntArray, settings: PrintSettings) -> Hatching:
    """Angles and spacings: skins are lines side by side, sparse fill has the width's share that the density asks for.

    Args:
        solid: (I,) regions of the islands.
        sparse: (I,) regions of the islands.
        island_layer: (I,) layer of each island.
        settings: the infill's density, pattern and angle and the extrusion width are read.
    """
    width, angle = settings.extrusion_width, settings.infill_angle
    alternating = np.where(island_layer % 2 == 0, angle, -angle)
    everywhere = np.ones(len(island_layer))
    rows = [(solid, Feature.SKIN, alternating, width)]
    if settings.infill_density > 0.0:
        spacing = width * 100.0 / settings.infill_density
        if settings.infill_pattern == "grid":
            rows.append((sparse, Feature.INFILL, angle * everywhere, 2.0 * spacing))
            rows.append((sparse, Feature.INFILL, (angle + 90.0) * everywhere, 2.0 * spacing))
        else:
            rows.append((sparse, Feature.INFILL, alternating, spacing))
    return Hatching(
        regions=np.concatenate([row[0] for row in rows]),
        island=np.tile(np.arange(len(island_layer)), len(rows)),
        feature=np.concatenate([np.full(len(island_layer), int(row[1])) for row in rows]),
        angle_deg=np.concatenate([row[2] for row in rows]),
        spacing_mm=np.concatenate([row[3] * everywhere for row in rows]),
    )


def hatch_paths(hatching: Hatching, island_layer: IntArray, settings: PrintSettings) -> Paths:
    """Hatch all regions and join the lines.

    The lines of skins end half a width before their region does, as the nozzle's line is round there and the link to
    the next line runs along; so the length of line times its width is the region's area. Sparse lines end on the
    boundary, where they hold on to the wall.
    """
    width = settings.extrusion_width
    cut = crossings(hatching.regions, hatching.angle_deg, hatching.spacing_mm)
    found = spans(cut)
    skin = hatching.feature == Feature.SKIN
    limits = LinkLimits(
        closeness_mm=0.5 * width,
        straight_mm=np.where(skin, _LONGEST_SOLID_LINK * width, np.inf),
        boundary_mm=np.where(skin, 0.0, _LONGEST_SPARSE_LINK * hatching.spacing_mm),
    )
    keep = long_enough(cut, found, 0.5 * width)
    points, start, region = joined(cut, found, keep, np.where(skin, 0.5 * width, 0.0), limits)
    island = hatching.island[region]
    return Paths(
        points=rotated(points, np.repeat(hatching.angle_deg[region], np.diff(start))),
        start=start,
        layer=island_layer[island].astype(np.int64),
        feature=hatching.feature[region].astype(np.int64),
        island=island.astype(np.int64),
        closed=np.zeros(len(region), dtype=bool),
        width=np.full(len(points), width),
    )
