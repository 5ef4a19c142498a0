"""Shapes to fill, and ways to look at the paths that fill them."""

import numpy as np
import shapely
from dualcolor.core.fill.bridges import bridges
from dualcolor.core.fill.closing import layer_outlines
from dualcolor.core.fill.offsets import simplified
from dualcolor.core.fill.paths import fill_areas, fill_lines, wall_areas
from dualcolor.core.fill.skins import skins
from dualcolor.core.fill.walls import walls_and_fill
from dualcolor.core.model import IntArray, Shapes
from dualcolor.core.paths import Paths
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.planes import line_widths

WIDTH = 0.4


def square(side, x=0.0, y=0.0):
    return shapely.box(x - side / 2, y - side / 2, x + side / 2, y + side / 2)


def covering(sliced):
    """(L,) cross-sections as a print's own are simplified to see what covers what."""
    parts, layer = shapely.get_parts(sliced, return_index=True)
    return layer_outlines(simplified(parts, 0.05), layer, len(sliced))


def annulus(outer, inner, x=0.0, y=0.0):
    return shapely.difference(square(outer, x, y), square(inner, x, y))


def shapes(items):
    column = np.empty(len(items), dtype=object)
    column[:] = items
    return column


def stack(layers, inset=1.0):
    """Sliced layers, and one island a layer, set back as the waved wall would leave it."""
    sliced = shapes(layers)
    return sliced, shapely.buffer(sliced, -inset, join_style="mitre"), np.arange(len(layers))


def blobs(count, seed, span=20.0):
    """Wobbly regions with wobbly holes."""
    random = np.random.default_rng(seed)
    turn = np.linspace(0, 2 * np.pi, 240, endpoint=False)
    waves = np.arange(2, 14)

    def ring(radius):
        wobble = (random.normal(size=(12, 1)) / waves[:, None] * np.cos(waves[:, None] * turn)).sum(axis=0)
        reach = radius * np.maximum(1 + 0.5 * wobble, 0.2)
        return shapely.Polygon(np.stack([reach * np.cos(turn), reach * np.sin(turn)], axis=1))

    made = [shapely.difference(ring(span), shapely.affinity.translate(ring(span / 5), span / 4)) for _ in range(count)]
    return shapes([shapely.buffer(shape, 0) for shape in made])


def table_is_sound(paths):
    counts = np.diff(paths.start)
    assert paths.start[0] == 0 and paths.start[-1] == len(paths.points) == len(paths.width)
    assert (counts >= np.where(paths.closed, 3, 2)).all()
    assert np.isfinite(paths.points).all()
    assert (paths.width >= 0.5 * WIDTH).all() and (paths.width <= 2.0 * WIDTH).all()
    assert len(counts) == len(paths.layer) == len(paths.feature) == len(paths.island) == len(paths.closed)


def lines_of(paths, feature=None, layer=None):
    """The chosen paths as shapely lines, closed ones closed."""
    lines = []
    for k in range(len(paths.layer)):
        if feature in (None, paths.feature[k]) and layer in (None, paths.layer[k]):
            points = paths.points[paths.start[k] : paths.start[k + 1]]
            lines.append(shapely.LineString(np.concatenate([points, points[:1]]) if paths.closed[k] else points))
    return shapes(lines)


def fill_paths(sliced: Shapes, islands: Shapes, island_layer: IntArray, settings: PrintSettings) -> Paths:
    """Walls, skins and sparse fill of the whole print.

    Args:
        sliced: (L,) Polygon or MultiPolygon, the whole cross-section of each layer, maybe empty; mm.
        islands: (I,) Polygon or MultiPolygon, maybe empty: what lies inside the innermost center line of the waved
            wall of each connected region.
        island_layer: (I,) int64 layer of each island.
        settings: walls, skins and fill.

    Returns:
        INNER_WALL loops whose first center line lies a line width inside the island's boundary, and SKIN, BRIDGE
        and INFILL lines. Islands are numbered by their place in `islands`.
    """
    islands = simplified(islands, 0.02)
    _, inside, _ = walls_and_fill(islands, line_widths(island_layer, settings), settings)
    outlines = covering(sliced)
    solid = skins(inside, island_layer, outlines, settings)
    spanned = bridges(inside, solid, outlines, island_layer, settings)
    straight = np.full(len(islands), shapely.MultiLineString(), dtype=object)
    walls = wall_areas(islands, straight, island_layer, settings)
    areas = fill_areas(walls[-1], solid.regions, solid.whole, settings)
    return fill_lines(walls, areas, spanned, island_layer, settings)
