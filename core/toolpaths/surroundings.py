"""All that is printed around and below the object: skirt, tower, brim, ooze shield and raft, clear of each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from ..model import FloatArray, IntArray
from ..settings import PrintSettings
from ..slicing.planes import Layers, line_widths
from .brim import brim_area, brim_paths
from .loops import exterior_rings
from .moves import Paths
from .placement import placed, turned
from .raft import raft_area, raft_paths
from .shield import shield_area, shield_paths
from .skirt import skirt_paths
from .tower import tower_brim, tower_loops, tower_paths

# A shadow is wider by these, and what sticks out by no more may be missing from it.
_SIMPLIFY_MM = 0.1
_SLIVER_MM = 0.1
_SPREAD = 64  # shapes that cover most of the others


@dataclass(frozen=True)
class Ground:
    """What the object and its supports cover, seen from above, in mm.

    Attributes:
        shadow: all layers together, holes filled, waves included.
        first: the first layer, as wide as its lines; the raft where there is one.
    """

    shadow: shapely.Geometry
    first: shapely.Geometry


def shadow(regions: NDArray[np.object_], settings: PrintSettings) -> shapely.Geometry:
    """What any layers of object and supports cover, holes filled, with the waves that may stand out.

    Args:
        regions: (R,) Polygons or MultiPolygons, cross-sections.
        settings: wave_depth_max is used.
    """
    whole = shapely.polygons(exterior_rings(regions))
    shapes = shapely.simplify(whole, _SIMPLIFY_MM, preserve_topology=False)
    shapes = np.where(shapely.is_valid(shapes), shapes, whole)
    covered = shapely.MultiPolygon()
    while len(shapes):
        # Most layers lie within some spread over the height, but for slivers; that is told faster than they are united.
        some = np.arange(len(shapes)) % -(-len(shapes) // _SPREAD) == 0
        covered = _filled(shapely.union_all([covered, *shapes[some]]))
        nearly = shapely.buffer(covered, _SLIVER_MM, quad_segs=1)
        shapely.prepare(nearly)
        shapes = shapes[~some]
        shapes = shapes[~shapely.contains_properly(nearly, shapes)]
    # Waves stand out by half their depth.
    margin = settings.wave_depth_max / 2 + _SIMPLIFY_MM + _SLIVER_MM
    return _filled(shapely.buffer(covered, margin, quad_segs=2))


def _filled(shape: shapely.Geometry) -> shapely.Geometry:
    """A shape without its holes."""
    return shapely.union_all(shapely.polygons(exterior_rings(np.array([shape]))))


def ground(shade: shapely.Geometry, regions: NDArray[np.object_], walls: Paths, settings: PrintSettings) -> Ground:
    """Look at the object and its supports from above.

    Args:
        shade: their `shadow`.
        regions: (R,) Polygons or MultiPolygons, the first of which is what of the first layer is not in the walls.
        walls: the waved outlines, of the first layer at least.
        settings: the extrusion widths and the raft are used.
    """
    width = float(line_widths(np.zeros(1, dtype=np.int64), settings)[0])
    strips = shapely.buffer(_closed_lines(walls, np.flatnonzero(walls.layer == 0)), width / 2)
    first = shapely.union_all([*regions[:1], *strips])
    if settings.raft_layers:
        first = raft_area(first, settings)
        shade = shapely.union(shade, first)
    return Ground(shade, first)


def _closed_lines(paths: Paths, chosen: IntArray) -> NDArray[np.object_]:
    points = [paths.points[paths.start[path] : paths.start[path + 1]] for path in chosen]
    ends = [line[: int(closed)] for line, closed in zip(points, paths.closed[chosen], strict=True)]
    return np.array(
        [shapely.linestrings(np.concatenate(pair)) for pair in zip(points, ends, strict=True)], dtype=object
    )


def surrounding_paths(on_bed: Ground, layers: Layers, settings: PrintSettings) -> Paths:
    """Skirt, tower, brim, ooze shield and raft of the whole print.

    Args:
        on_bed: what stands there, on a raft if there is one.
        layers: the stack, with the raft.
        settings: of the print.

    Raises:
        MeshError: the bed has no room for the tower.
        SettingsError: the tower does not fit where the user wants it.
    """
    shield = shield_paths(on_bed.shadow, len(layers), settings)
    inside_shield = shield_area(on_bed.shadow, settings)
    raft = raft_paths(on_bed.first, settings)
    first = on_bed.first
    if settings.ooze_shield:
        inside = shapely.buffer(inside_shield, -settings.extrusion_width)
        first = shapely.union(first, shapely.difference(inside_shield, inside))
    brim = brim_paths(first, settings)
    covered = brim_area(first, settings)
    tower = tower_where_free(shapely.union(inside_shield, covered), layers, settings)
    around = [covered]
    if tower:
        outermost = [*tower_brim(tower, settings), tower[-1]][0]
        around.append(shapely.buffer(shapely.polygons(outermost), settings.first_layer_extrusion_width / 2))
    skirt = skirt_paths(shapely.union_all(around), settings)
    return Paths.joined([skirt, tower_paths(tower, len(layers), settings), brim, shield, raft])


def tower_where_free(obstacles: shapely.Geometry, layers: Layers, settings: PrintSettings) -> list[FloatArray]:
    """The tower's loops where they stand; none without a tower.

    Raises:
        MeshError: the bed has no room for it.
        SettingsError: it does not fit where the user wants it.
    """
    if settings.tower_type == "none" or not len(layers):
        return []
    loops = tower_loops(float(layers.top[-1]), settings)
    outermost = [*tower_brim(loops, settings), loops[-1]][0]
    half_line = max(settings.first_layer_extrusion_width, settings.extrusion_width) / 2
    edge = shapely.buffer(shapely.polygons(outermost), half_line, join_style="mitre")
    x, y, angle = placed(shapely.get_coordinates(edge), obstacles, settings)
    return [turned(loop, angle) + np.array([x, y]) for loop in loops]
