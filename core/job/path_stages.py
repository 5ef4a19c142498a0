"""The second half of the job: from the waved outer wall to the moves of the whole print in order."""

from __future__ import annotations

from collections.abc import Generator
from concurrent.futures import Future
from dataclasses import replace

from shapely import Geometry, get_parts

from ..contours.contours import Contours
from ..fill.paths import fill_areas, fill_lines, wall_areas
from ..paths import Paths
from ..printability.slopes import slope_report
from ..printability.thin_features import ThinFeatures, thin_features
from ..progress import Progress
from ..records import dataclass
from ..settings import PrintSettings
from ..slicing.slices import Slices
from ..statistics.single_color import SingleColor, single_color
from ..supports.grid_overlay import distinct
from ..supports.supports import Supports, on_bed, supports
from ..toolpaths.moves import Moves
from ..toolpaths.order import OrderedPaths
from ..toolpaths.outer_wall import outer_wall_paths, straight_parts
from ..toolpaths.overhangs import Below
from ..toolpaths.raft import raised
from ..toolpaths.surroundings import ground, shadow, surrounding_paths
from ..toolpaths.travels import Rooms, rooms
from .anew import by_islands, filled_anew, inside_lines
from .stages import Stages
from .toolpaths import Surrounded, in_order, in_order_anew, moves_along, moves_along_anew
from .wall_stages import PaintedWall

# Outlines behind the wave may differ from the true ones by this much, mm.
FILL_TOLERANCE = 0.03


@dataclass(frozen=True)
class PrintedPaths:
    """All that is extruded, and the moves between.

    Attributes:
        fill: behind the outer wall.
        within: where travels may go.
        beside: what no tone changes.
        moves: the print in order.
        ordered: its paths.
        single_color: what is known of the same object in one color, worked out beside the stages.
        thin: features too thin for a wall, worked out beside the stages.
        slopes: the report's part on them, worked out beside the stages.
    """

    fill: Paths
    within: Rooms
    beside: Surrounded
    moves: Moves
    ordered: OrderedPaths
    single_color: Future[SingleColor]
    thin: Future[ThinFeatures]
    slopes: Future[dict[str, float]]


def path_stages(wall: PaintedWall, settings: PrintSettings, stages: Stages) -> Generator[Progress, None, PrintedPaths]:
    """Supports, fill, surroundings and order: yields before each stage, returns the paths.

    Raises:
        PrintError: the print does not fit the printer.
    """
    run, layered, along, aside = stages.run, stages.run_layers, stages.run_along_lines, stages.aside
    cut, lines = wall.cut, wall.lines
    yield stages.begin(0.6, "supports")
    spanned = wall.beside.bridges.result() if settings.support_enable and settings.dont_support_bridges else None
    holding = run("supports", supports, wall.mesh, cut, lines, wall.depth, settings, spanned)
    outer = outer_wall_paths(wall.outlines)
    shade = aside("shadow", _shadow, lines, holding, settings)
    last = int(max(paths.layer.max(initial=0) for paths in (outer, holding.paths)))
    around = aside("surroundings", _surroundings, shade, cut, holding, outer.first_layer, last, settings)
    yield stages.begin(0.65, "fill")
    island_layer = cut.polygon_layer
    of_wall = (wall.outlines, lines, wall.depth, wall.set_back)
    waves, count = bool(wall.depth.any()), len(island_layer)
    inside = along("inside", inside_lines, of_wall, waves, count, FILL_TOLERANCE)
    straight = along("straight parts", straight_parts, of_wall[1:], count, settings)
    walls = layered(
        "inner walls", wall_areas, by_islands(wall_areas, island_layer), (inside, straight, island_layer), settings
    )
    known = wall.beside.closing.result()
    skins = known.skins.regions, known.skins.whole
    areas = layered("areas", fill_areas, by_islands(fill_areas, island_layer), (walls[-1],), *skins, settings)
    fill = layered(
        "fill", fill_lines, filled_anew, (walls, areas), wall.beside.bridges.result(), island_layer, settings
    )
    within = rooms(inside, island_layer, known.outlines)
    yield stages.begin(0.75, "toolpaths")
    below = Below(wall.beside.undersides.result(), known.outlines)
    beside = Surrounded(holding.paths, around.result(), below)
    paths = layered("order", in_order, in_order_anew, (outer, fill), beside, settings)
    # Not before: two threads of many short numpy calls take longer together than one after the other.
    slopes = aside("slope report", slope_report, wall.beside.paint)
    thin = aside("thin features", thin_features, cut, lines, settings)
    inner = Paths.joined([fill, holding.paths])
    alone = aside("single color", single_color, wall.outlines, inner, cut.layers, settings, within, below)
    moves = layered("toolpaths", moves_along, moves_along_anew, (paths, within), cut.layers, settings)
    return PrintedPaths(fill, within, beside, moves, paths, alone, thin, slopes)


def moves_without_swaps(wall: PaintedWall, paths: PrintedPaths, settings: PrintSettings) -> Moves:
    """The print without tool changes within layers, every wall in its layer's color, to tell what they cost."""
    outer = outer_wall_paths(replace(wall.outlines, swapped=None))
    return moves_along(in_order(outer, paths.fill, paths.beside, settings), paths.within, wall.cut.layers, settings)


def _shadow(lines: Contours, holding: Supports, settings: PrintSettings) -> Geometry:
    # Columns hardly change from layer to layer.
    return shadow(lines.points, distinct(get_parts(holding.areas)), settings)


def _surroundings(
    shade: Geometry, cut: Slices, holding: Supports, wall: Paths, last: int, settings: PrintSettings
) -> Paths:
    first = on_bed(cut.regions[0], holding.areas[0], settings)
    # A tip may end below the top of the mesh, where it is thinner than a strand; so does what stands beside it.
    layers = raised(cut.layers.up_to(last), settings)
    return surrounding_paths(ground(shade, first, wall, settings), layers, settings)
