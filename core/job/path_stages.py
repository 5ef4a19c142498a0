"""The second half of the job: from the waved outer wall to the moves of the whole print in order."""

from __future__ import annotations

from collections.abc import Generator
from concurrent.futures import Future
from dataclasses import replace
from functools import partial

import numpy as np
from shapely import Geometry, Polygon, get_parts

from ..contours.contours import Contours
from ..fill.bridges import Bridges
from ..fill.paths import fill_areas, fill_lines, wall_areas
from ..model import BoolArray, IntArray, Shapes
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
from ..toolpaths.outer_wall import inside_of_wall, outer_wall_paths, straight_parts
from ..toolpaths.overhangs import Below
from ..toolpaths.raft import raised
from ..toolpaths.surroundings import ground, shadow, surrounding_paths
from ..toolpaths.travels import Rooms, rooms
from .changed_layers import LayerRows
from .move_stages import ToneFree, in_order, in_order_anew, moves_along, moves_along_anew
from .stages import Stages
from .wall_stages import PaintedWall


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
    beside: ToneFree
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
    run_layers, aside = stages.run_layers, stages.aside
    cut, lines = wall.cut, wall.lines
    yield stages.begin(0.6, "supports")
    spanned = wall.beside.bridges.result() if settings.support_enable and settings.dont_support_bridges else None
    support = stages.run("supports", supports, wall.mesh, cut, lines, wall.depth, settings, spanned)
    outer = outer_wall_paths(wall.outlines)
    shade = aside("shadow", _shadow, lines, support, settings)
    last = int(max(paths.layer.max(initial=0) for paths in (outer, support.paths)))
    around = aside("surroundings", _surroundings, shade, cut, support, outer.first_layer, last, settings)
    yield stages.begin(0.65, "fill")
    island_layer = cut.polygon_layer
    by_rows, count = partial(stages.run_rows, LayerRows(lines, island_layer)), len(island_layer)
    of_wall = (wall.outlines, lines, wall.depth, wall.set_back)
    inside = by_rows("inside", inside_of_wall, of_wall, count, settings)
    straight = by_rows("straight parts", straight_parts, of_wall[1:], count, settings)
    walls = by_rows("inner walls", wall_areas, (inside, straight, island_layer), settings)
    known = wall.beside.closing.result()
    areas = by_rows("areas", fill_areas, (walls[-1],), known.skins.regions, known.skins.whole, settings)
    over_air = wall.beside.bridges.result()
    fill = run_layers("fill", fill_lines, _fill_lines_anew, (walls, areas), over_air, island_layer, settings)
    within = rooms(inside, island_layer, known.outlines)
    yield stages.begin(0.75, "toolpaths")
    below = Below(wall.beside.undersides.result(), known.outlines)
    beside = ToneFree(support.paths, around.result(), below)
    paths = run_layers("order", in_order, in_order_anew, (outer, fill), beside, settings)
    # Not before: two threads of many short numpy calls take longer together than one after the other.
    slopes = aside("slope report", slope_report, wall.beside.paint)
    thin = aside("thin features", thin_features, cut, lines, settings)
    inner = Paths.joined([fill, support.paths])
    alone = aside("single color", single_color, wall.outlines, inner, cut.layers, settings, within, below)
    moves = run_layers("toolpaths", moves_along, moves_along_anew, (paths, within), cut.layers, settings)
    return PrintedPaths(fill, within, beside, moves, paths, alone, thin, slopes)


def moves_without_swaps(wall: PaintedWall, paths: PrintedPaths, settings: PrintSettings) -> Moves:
    """The print without tool changes within layers, every wall in its layer's color, to tell what they cost."""
    outer = outer_wall_paths(replace(wall.outlines, swapped=None))
    return moves_along(in_order(outer, paths.fill, paths.beside, settings), paths.within, wall.cut.layers, settings)


def _fill_lines_anew(
    former: Paths,
    changed: BoolArray,
    walls: tuple[Shapes, ...],
    fill: tuple[Shapes, Shapes],
    over_air: Bridges,
    island_layer: IntArray,
    settings: PrintSettings,
) -> Paths:
    """As `fill_lines`; see `changed_layers.py`. Islands keep their numbers, so those of other layers are left empty."""
    own = changed[island_layer]
    walls = tuple(np.where(own, column, Polygon()) for column in walls)
    solid, sparse = (np.where(own, column, Polygon()) for column in fill)
    lines = fill_lines(walls, (solid, sparse), over_air.selected(own[over_air.island]), island_layer, settings)
    return Paths.joined([former.selected(~changed[former.layer]), lines])


def _shadow(lines: Contours, support: Supports, settings: PrintSettings) -> Geometry:
    # Columns hardly change from layer to layer.
    return shadow(lines.points, distinct(get_parts(support.areas)), settings)


def _surroundings(
    shade: Geometry, cut: Slices, support: Supports, wall: Paths, last: int, settings: PrintSettings
) -> Paths:
    first = on_bed(cut.regions[0], support.areas[0], settings)
    # A tip may end below the top of the mesh, where it is thinner than a strand; so does what stands beside it.
    layers = raised(cut.layers.up_to(last), settings)
    return surrounding_paths(ground(shade, first, wall, settings), layers, settings)
