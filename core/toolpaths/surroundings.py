"""Everything printed around and below the object: skirt, tower, brim, ooze shield and raft, clear of each other."""

from __future__ import annotations

import numpy as np
import shapely

from ..contours.contours import POINTS_PER_WAVELENGTH
from ..model import FloatArray, IntArray, Shapes, bounds
from ..paths import Paths
from ..records import dataclass
from ..settings import PrintSettings
from ..slicing.planes import Layers, first_line_width
from .brim import brim_area, brim_paths
from .loops import exterior_rings
from .placement import placed, turned
from .raft import raft_area, raft_paths
from .shield import shield_paths, shield_walls
from .skirt import skirt_paths
from .tower import tower_brim, tower_loops, tower_paths

# The shadow is made of squares; at most this many across, even if the print is far larger than any bed.
_SQUARE_MM, _MOST_SQUARES = 0.3, 1000
_NARROW_MM = 8.0  # Bays in which neither tower nor shield finds room may be covered.


@dataclass(frozen=True)
class Ground:
    """What the object and its supports cover, seen from above, in mm.

    Attributes:
        shadow: all layers together, holes filled, waves included.
        first: the first layer, as wide as its lines; the raft where there is one.
    """

    shadow: shapely.Geometry
    first: shapely.Geometry


def shadow(lines: FloatArray, columns: Shapes, settings: PrintSettings) -> shapely.Geometry:
    """The outline of all layers seen from above, holes filled, waves included, about half a millimeter larger.

    Args:
        lines: (N, 2) mm, points of the contours.
        columns: (S,) Polygons or MultiPolygons, areas of supports.
        settings: the wave's length and depth and the extrusion width are used.
    """
    step = max(_SQUARE_MM, settings.wavelength / POINTS_PER_WAVELENGTH)
    points = lines
    if len(columns):
        points = np.concatenate([lines, shapely.get_coordinates(shapely.segmentize(columns, step))])
    if not len(points):
        return shapely.MultiPolygon()
    low, high = bounds(points)
    square = max(step, float((high - low).max()) / _MOST_SQUARES)
    # A line lies half its width inside, leaves the squares by half of one between two points, and is simplified.
    margin = (settings.extrusion_width + 2 * settings.wave_crest + 3 * square) / 2
    grown = shapely.buffer(_squares(points, low, square), margin, quad_segs=2)
    return shapely.union_all(shapely.polygons(exterior_rings(np.array([grown]))))


def _squares(points: FloatArray, low: FloatArray, side: float) -> shapely.Geometry:
    """The squares of a grid that hold points, and those of narrow bays between, as one simplified shape.

    Args:
        points: (N, 2) mm.
        low: (2,) mm, the grid's first corner.
        side: mm, of the squares.
    """
    across, up = (((axis - least) / side).astype(np.int32) for axis, least in zip(points.T, low, strict=True))
    covered = np.zeros((up.max() + 1, across.max() + 1), dtype=bool)
    covered.ravel()[up * covered.shape[1] + across] = True
    change = np.diff(covered.astype(np.int8), axis=1, prepend=0, append=0)
    (row, begin), (_, end) = np.nonzero(change > 0), np.nonzero(change < 0)
    apart = (row[1:] > row[:-1]) | ((begin[1:] - end[:-1]) * side > _NARROW_MM)
    row, begin, end = row[np.append(True, apart)], begin[np.append(True, apart)], end[np.append(apart, True)]
    strips = shapely.multipolygons(shapely.box(begin, row, end, row + 1))
    return shapely.transform(shapely.simplify(shapely.buffer(strips, 0), 1), lambda places: low + side * places)


def ground(shade: shapely.Geometry, region: shapely.Geometry, walls: Paths, settings: PrintSettings) -> Ground:
    """The object and its supports seen from above.

    Args:
        shade: their `shadow`.
        region: Polygon or MultiPolygon, the first layer behind its outer walls, and supports; its walls are added.
        walls: the waved outlines, of the first layer at least.
        settings: the extrusion widths and the raft are used.
    """
    strips = shapely.buffer(_closed_lines(walls, np.flatnonzero(walls.layer == 0)), first_line_width(settings) / 2)
    first = shapely.union_all([region, *strips])
    if settings.raft_layers:
        first = raft_area(first, settings)
        shade = shapely.union(shade, first)
    return Ground(shade, first)


def _closed_lines(paths: Paths, chosen: IntArray) -> Shapes:
    """(C,) LineStrings along chosen paths (C,), back to the first point of closed ones."""
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
    first_width = settings.first_layer_extrusion_width
    walls, inside_shield = shield_walls(on_bed.shadow, settings), on_bed.shadow
    if settings.ooze_shield:
        inside_shield = shapely.buffer(walls, max(first_width, settings.extrusion_width) / 2)
    shield = shield_paths(walls, len(layers), settings)
    raft = raft_paths(on_bed.first, settings)
    # What stands within a hole, as in letters, gets no brim that would fill the hole.
    first = shapely.union_all(shapely.polygons(exterior_rings(np.array([on_bed.first]))))
    if settings.ooze_shield:
        outer = shapely.buffer(walls, first_width / 2)
        first = shapely.union(first, shapely.difference(outer, shapely.buffer(outer, -first_width)))
    brim = brim_paths(first, settings)
    covered = brim_area(first, settings)
    tower = tower_where_free(shapely.union(inside_shield, covered), layers, settings)
    around = [covered]
    if tower:
        outermost = [*tower_brim(tower, settings), tower[-1]][0]
        around.append(shapely.buffer(shapely.polygons(outermost), first_width / 2))
    skirt = skirt_paths(shapely.union_all(around), settings)
    return Paths.joined([skirt, tower_paths(tower, len(layers), settings), brim, shield, raft])


def tower_where_free(obstacles: shapely.Geometry, layers: Layers, settings: PrintSettings) -> list[FloatArray]:
    """The tower's loops where they stand; none without a tower, or where the tools never change.

    Raises:
        MeshError: the bed has no room for it.
        SettingsError: it does not fit where the user wants it.
    """
    changes = len(layers) - settings.raft_layers > 1 or settings.solid_regions == "tool_change"
    if settings.tower_type == "none" or not len(layers) or not changes:
        return []
    loops = tower_loops(float(layers.top[-1]), settings)
    outermost = [*tower_brim(loops, settings), loops[-1]][0]
    half_line = max(settings.first_layer_extrusion_width, settings.extrusion_width) / 2
    edge = shapely.buffer(shapely.polygons(outermost), half_line, join_style="mitre")
    x, y, angle = placed(shapely.get_coordinates(edge), obstacles, settings)
    return [turned(loop, angle) + np.array([x, y]) for loop in loops]
