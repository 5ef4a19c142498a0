"""The straight walls behind the waved outline, and the region that they leave to be filled."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from ..model import FloatArray, IntArray, Shapes
from ..paths import Feature, Paths
from ..settings import PrintSettings
from ..slicing.regions import ring_points
from .mitres import Moved, moved
from .offsets import completed, offset, polygonal, simplified

_SIMPLIFY_MM = 0.04  # a tenth of a line, and less than what fill overlaps walls by
_NARROWEST = 0.7  # line widths between the lines on both sides of a neck
_TIP = 0.2  # line widths, squared: sharp corners are no necks
_APART_MM = 1e-3  # overlays of edges that lie on one another take several times as long and leave slivers


def walls_and_fill(
    islands: Shapes, width_mm: FloatArray, settings: PrintSettings
) -> tuple[list[Shapes], Shapes, list[Moved]]:
    """Offset every island inwards, wall by wall.

    Args:
        islands: (I,) valid regions whose boundary is the center line of the outermost wall's inside.
        width_mm: (I,) of the lines.
        settings: `perimeters`, P, and `infill_overlap` are read.

    Returns:
        P + 1 arrays (I,): the islands, and then for each straight wall, from the outside in, regions bounded by its
        center line; (I,) regions to fill: what is inside the last wall's inner edge, grown by the overlap; and for each
        of the P walls how it came from the one before.
    """
    into_fill = (settings.infill_overlap / 100.0 - 0.5) * width_mm
    walls, steps = [islands], []
    for _ in range(settings.perimeters):
        steps.append(moved(walls[-1], -width_mm))
        walls.append(completed(steps[-1], walls[-1], -width_mm))
    inside = simplified(walls[-1], _SIMPLIFY_MM)
    filled = moved(inside, into_fill)
    fill = completed(filled, inside, into_fill)
    for number, onwards in enumerate([*steps, filled][1:], start=1):
        # A wall may have necks where edges have met on the way farther in, or nothing was left to go on with.
        rows = np.flatnonzero(~onwards.sound | (shapely.is_empty(onwards.shapes) & ~shapely.is_empty(walls[number])))
        half = _NARROWEST / 2 * width_mm[rows]
        if onwards is filled and np.allclose(into_fill[rows], -half):  # moved in by just that already
            cores, half = fill[rows], half + _SIMPLIFY_MM
        else:
            cores = offset(walls[number][rows], -half)
        opened = _open_necks(walls[number], rows, offset(cores, half + _APART_MM), width_mm[rows])
        steps[number - 1].sound[opened] = False  # gaps are looked for there
    return walls, fill, steps


def _open_necks(walls: Shapes, rows: IntArray, wide: Shapes, width_mm: FloatArray) -> IntArray:
    """Cut the rows (R,) of walls (I,), in place, back to where they are `wide` (R,), but not at sharp corners.

    Where both sides of a wall would be printed nearly on each other there is none: one line along the gap is as wide.
    """
    whole = walls[rows]
    opened = polygonal(shapely.intersection(whole, wide))
    lost_mm2, shorter_mm = shapely.area(whole) - shapely.area(opened), shapely.length(whole) - shapely.length(opened)
    necks = (lost_mm2 > _TIP * width_mm**2) | (shorter_mm > 2.0 * width_mm)
    necks |= shapely.get_num_geometries(opened) > shapely.get_num_geometries(whole)
    changed: IntArray = rows[necks]
    walls[changed] = opened[necks]
    return changed


def wall_paths(walls: Sequence[Shapes], island_layer: IntArray, width_mm: FloatArray) -> Paths:
    """The boundaries of the walls' regions as closed paths.

    Args:
        walls: for each wall, (I,) regions bounded by its center line.
        island_layer: (I,) layer of each island.
        width_mm: (I,) of the lines.

    Returns:
        INNER_WALL loops, outer ones counter-clockwise and holes clockwise, without those too short to be printed.
    """
    if not walls:
        return Paths.empty()
    island = np.tile(np.arange(len(island_layer)), len(walls))
    return boundary_paths(np.concatenate(walls), island, island_layer, width_mm, Feature.INNER_WALL)


def boundary_paths(
    regions: Shapes, island: IntArray, island_layer: IntArray, width_mm: FloatArray, feature: Feature
) -> Paths:
    """The boundaries of regions as closed paths.

    Args:
        regions: (R,) Polygon or MultiPolygon, maybe empty.
        island: (R,) int64.
        island_layer: (I,) layer of each island.
        width_mm: (I,) of each island's lines.
        feature: of all of them.

    Returns:
        Outer loops counter-clockwise and holes clockwise, without those too short to be printed.
    """
    parts, owner = shapely.get_parts(regions, return_index=True)
    rings, part = shapely.get_rings(parts, return_index=True)
    turned = shapely.is_ccw(rings) == np.append(False, part[1:] == part[:-1])[: len(part)]
    rings[turned] = shapely.reverse(rings[turned])
    island = island[owner][part]
    printable = shapely.length(rings) >= 2.0 * width_mm[island]
    rings, island = rings[printable], island[printable]
    points, start = ring_points(rings)
    width = np.repeat(width_mm[island], np.diff(start))
    return Paths.alike(points, start, island_layer[island], feature=feature, island=island, closed=True, width=width)
