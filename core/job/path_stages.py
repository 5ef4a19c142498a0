"""The second half of the job: from the waved outer wall to the moves of the whole print in order."""

from __future__ import annotations

from collections.abc import Generator
from concurrent.futures import Future
from dataclasses import replace

from shapely import Geometry, get_parts

from ..fill.paths import fill_areas, fill_lines
from ..model import Shapes
from ..paths import Paths
from ..pattern.contours import Contours
from ..printability.thin_features import ThinFeatures, thin_features
from ..progress import Progress
from ..records import dataclass
from ..settings import PrintSettings
from ..slicing.planes import Layers
from ..slicing.slices import Slices
from ..statistics.single_color import SingleColor, single_color
from ..supports.grid_overlay import distinct
from ..supports.paths import Supports, on_bed, supports
from ..toolpaths.assemble import assemble
from ..toolpaths.moves import Moves
from ..toolpaths.order import ordered
from ..toolpaths.outer_wall import inside_of_wall, outer_wall_paths
from ..toolpaths.overhangs import Undersides, undersides, with_overhangs
from ..toolpaths.raft import lifted, raised
from ..toolpaths.surroundings import ground, shadow, surrounding_paths
from ..toolpaths.travels import Rooms, rooms
from .checks import check
from .stages import Stages
from .wall_stages import PaintedWall

# Outlines behind the wave may differ from the true ones by this much, mm.
FILL_TOLERANCE = 0.02


@dataclass(frozen=True)
class PrintedPaths:
    """All that is extruded, and the moves between.

    Attributes:
        inner: fill and supports.
        around: skirt or brim, tower, shield and raft.
        within: where travels may go.
        hanging: where walls may hang over air.
        moves: the print in order.
        thin: features too thin for a wall, worked out beside the stages.
        single_color: what is known of the same object in one colour, worked out beside the stages.
    """

    inner: Paths
    around: Paths
    within: Rooms
    hanging: Undersides | None
    moves: Moves
    thin: Future[ThinFeatures]
    single_color: Future[SingleColor]


def path_stages(wall: PaintedWall, settings: PrintSettings, stages: Stages) -> Generator[Progress, None, PrintedPaths]:
    """Hold, fill, surround and order: yields before each stage, returns the paths.

    Raises:
        PrintError: the print does not fit the printer.
    """
    run, aside, cut, lines = stages.run, stages.aside, wall.cut, wall.lines
    yield stages.begin(0.6, "supports")
    holding = run("supports", supports, wall.mesh, cut, lines, wall.depth, settings)
    outer = outer_wall_paths(wall.outlines)
    shade = aside("shadow", _shadow, lines, holding, settings)
    around = aside("surroundings", _surroundings, shade, cut, holding, outer.first_layer, settings)
    hanging = aside("undersides", undersides, wall.mesh, cut.layers.plane, settings)
    thin = aside("thin features", thin_features, cut, lines, settings)
    yield stages.begin(0.65, "fill")
    of_wall = (wall.outlines, lines, wall.depth, wall.set_back)
    inside = run("inside", inside_of_wall, *of_wall, len(cut.polygons), FILL_TOLERANCE)
    known = wall.closing.result()
    islands = (inside, cut.polygon_layer, known.skins.regions, known.skins.whole)
    areas = stages.run_rows("areas", fill_areas, islands, settings)
    fill = run("fill", fill_lines, areas, known.bridges, cut.polygon_layer, settings)
    inner = run("inner", _joined, fill, holding.paths)
    within = run("rooms", rooms, inside, cut.polygon_layer, known.outlines)
    yield stages.begin(0.75, "toolpaths")
    alone = aside("single color", single_color, wall.outlines, inner, cut.layers, settings, within)
    below = (hanging.result(), known.outlines)
    moves = run("toolpaths", _moves, outer, inner, around.result(), cut.layers, within, *below, settings)
    return PrintedPaths(inner, around.result(), within, hanging.result(), moves, thin, alone)


def moves_without_swaps(wall: PaintedWall, paths: PrintedPaths, settings: PrintSettings) -> Moves:
    """The print with each layer's whole wall in the layer's own colour, to tell what the tool changes cost."""
    outer = outer_wall_paths(replace(wall.outlines, swapped=None))
    below = (paths.hanging, wall.closing.result().outlines)
    return _moves(outer, paths.inner, paths.around, wall.cut.layers, paths.within, *below, settings)


def _joined(fill: Paths, holding: Paths) -> Paths:
    return Paths.joined([fill, holding])


def _shadow(lines: Contours, holding: Supports, settings: PrintSettings) -> Geometry:
    # Columns hardly change from layer to layer.
    return shadow(lines.points, distinct(get_parts(holding.areas)), settings)


def _surroundings(shade: Geometry, cut: Slices, holding: Supports, wall: Paths, settings: PrintSettings) -> Paths:
    first = on_bed(cut.regions[0], holding.areas[0], settings)
    return surrounding_paths(ground(shade, first, wall, settings), raised(cut.layers, settings), settings)


def _moves(
    wall: Paths,
    inner: Paths,
    around: Paths,
    layers: Layers,
    within: Rooms,
    hanging: Undersides | None,
    outlines: Shapes,
    settings: PrintSettings,
) -> Moves:
    paths = ordered(Paths.joined([lifted(wall, settings), lifted(inner, settings), around]), settings)
    paths = with_overhangs(paths, hanging, outlines, settings)
    moves = assemble(paths, raised(layers, settings), settings, within)
    check(moves, settings)
    return moves
