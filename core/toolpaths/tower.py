"""The cleaning tower that primes a nozzle after each tool change (paper, section 4.2)."""

from __future__ import annotations

import numpy as np
import shapely

from ..model import FloatArray
from ..paths import Feature, Paths
from ..ragged import starts
from ..settings import PrintSettings
from .loops import FirstIsland, exterior_rings, first_layer_loops, loop_points

MOST_LOOPS = 1000
PROPORTION = 1.4  # width of the W over its depth: about equally stiff both ways
LEAST_DEPTH_MM = 8.0
SLENDERNESS = 10.0  # greatest height of the tower over its depth
MITRE_LIMIT = 5.0
_MORE = 1.001  # than the purge volume, whatever is rounded


def tower_loops(height: float, settings: PrintSettings) -> list[FloatArray]:
    """The tower's footprint around the origin: one closed W, or several around each other, the innermost first.

    A bar joins the ends of the W and its middle leans on the bar, so two closed cells stand like a box girder; five
    long strokes with a corner at each end also cost less time than a folded outline. The depth is a tenth of the
    height or more; it grows, and then the number of loops, until a layer holds `purge_volume`.

    Args:
        height: mm, of the print.
        settings: purge_volume, extrusion_width and layer_height are used.

    Returns:
        Counter-clockwise loops (N, 2) in mm.
    """
    width = settings.extrusion_width
    needed = settings.purge_volume / (width * settings.layer_height) * _MORE
    depth = max(LEAST_DEPTH_MM, height / SLENDERNESS)
    most = int(np.clip(needed / _length(_w(depth, width)), 1, MOST_LOOPS))
    loops = _grown(_w(depth, width), width * np.arange(most))
    count = max(1, int(np.searchsorted(np.cumsum([_length(loop) for loop in loops]), needed)))
    for _ in range(3):
        innermost, *others = (_length(loop) for loop in loops[:count])
        # Outer loops are longer by as much whatever the size; all else is nearly proportional to the depth.
        longer = sum(others) - (count - 1) * innermost
        depth *= max(1.0, (needed - longer) / (count * innermost))
        loops = _grown(_w(depth, width), width * np.arange(count))
    return loops


def tower_paths(loops: list[FloatArray], layers: int, settings: PrintSettings) -> Paths:
    """All layers of the tower, each starting at the next corner, and its brim on the first layer.

    Args:
        loops: the footprint where it stands.
        layers: how many layers the print has.
        settings: tower_brim_width and the widths are used.

    Returns:
        Paths of feature `TOWER` in order of printing: brim from the outside in, then the loops from the inside out.
    """
    if not loops or layers <= 0:
        return Paths.empty()
    brim_width = settings.first_layer_extrusion_width
    brim = first_layer_loops(tower_brim(loops, settings), Feature.TOWER, FirstIsland.TOWER_BRIM, brim_width)
    corners = len(loops[0])
    turned = [np.concatenate(_started(loops, corner)) for corner in range(corners)]
    count = np.tile(np.array([len(loop) for loop in loops], dtype=np.int64), layers)
    layer = np.repeat(np.arange(layers, dtype=np.int64), len(loops))
    width = np.where(layer == 0, _first_width(loops, settings), settings.extrusion_width)
    tower = Paths.alike(
        np.concatenate([turned[layer % corners] for layer in range(layers)]),
        starts(count),
        layer,
        feature=Feature.TOWER,
        island=FirstIsland.TOWER + np.tile(np.arange(len(loops)), layers),
        closed=True,
        width=np.repeat(width, count),
    )
    return Paths.joined([brim, tower])


def tower_brim(loops: list[FloatArray], settings: PrintSettings) -> list[FloatArray]:
    """Loops around the tower that hold it on the bed, the outermost first."""
    width = settings.first_layer_extrusion_width
    count = int(np.ceil(settings.tower_brim_width / width - 1e-9))
    narrower = (width - _first_width(loops, settings)) / 2  # than the brim's lines, the outermost loop to each side
    around = shapely.buffer(shapely.polygons(loops[-1]), width * np.arange(count, 0, -1) - narrower, quad_segs=4)
    return [loop_points(ring) for ring in exterior_rings(np.asarray(around))]


def _first_width(loops: list[FloatArray], settings: PrintSettings) -> float:
    """Mm, how wide the loops are on the bed; several side by side have no room for wider lines than above."""
    first = settings.first_layer_extrusion_width
    return first if len(loops) == 1 else min(first, settings.extrusion_width)


def _w(depth: float, line_width: float) -> FloatArray:
    """(5, 2) mm, counter-clockwise: a W whose ends are joined by a bar, its middle a line's width off the bar."""
    half = PROPORTION * depth / 2
    x = half * np.array([-1.0, -0.5, 0.0, 0.5, 1.0])
    y = np.array([depth / 2, -depth / 2, depth / 2 - line_width, -depth / 2, depth / 2])
    return np.column_stack([x, y])


def _length(loop: FloatArray) -> float:
    return float(np.hypot(*(np.roll(loop, -1, axis=0) - loop).T).sum())


def _grown(loop: FloatArray, distances: FloatArray) -> list[FloatArray]:
    """The loop moved outwards by each distance."""
    shape = shapely.polygons(loop)
    grown = shapely.buffer(shape, distances, join_style="mitre", mitre_limit=MITRE_LIMIT)
    rings = exterior_rings(np.asarray(grown))
    # A buffer starts its rings anywhere: none of the innermost loop keeps the corners in their order.
    return [loop if distance == 0 else loop_points(ring) for ring, distance in zip(rings, distances, strict=True)]


def _started(loops: list[FloatArray], corner: int) -> list[FloatArray]:
    """The loops of one layer: the innermost starts at one of its corners, the others beside it."""
    begin = loops[0][corner]
    nearest = [int(np.argmin(np.hypot(*(loop - begin).T))) for loop in loops]
    return [np.roll(loop, -first, axis=0) for loop, first in zip(loops, nearest, strict=True)]
