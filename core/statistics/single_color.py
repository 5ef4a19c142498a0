"""How long the same object would take in a single color, from toolpaths of some of its layers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely

from ..model import BoolArray, FloatArray, IntArray
from ..paths import Feature, Paths
from ..pattern.wave import WavedOutlines
from ..ragged import following, ranges, starts, sums
from ..records import dataclass
from ..settings import PrintSettings
from ..slicing.planes import Layers
from ..toolpaths.assemble import assemble
from ..toolpaths.move_times import move_seconds
from ..toolpaths.moves import Moves
from ..toolpaths.order import ordered
from ..toolpaths.overhangs import Below, with_overhangs
from ..toolpaths.travels import Rooms
from .breakdown import tool_change_rows

# Features that a print in one color does not need.
ONLY_DUAL = (Feature.TOWER, Feature.OOZE_SHIELD)
# Features around the object or under it; the comparison leaves them out.
_AROUND = (Feature.SKIRT, Feature.BRIM, Feature.RAFT)
# Of a tall print, the time of about this many layers is computed.
_KNOWN_LAYERS = 20
_LEAST_MM2 = 1e-9
_SLOWED = 0.98  # of the least time of a layer; those that take less have the least speed


@dataclass(frozen=True)
class SingleColor:
    """What was computed of the print in one color: S of the L layers as a whole, of the others only the outer wall.

    Attributes:
        printed: (P,) int64, ascending, the layers on which anything is printed.
        layer: (S,) int64, ascending, some of them with the first one.
        seconds: (S,) s that each of these takes.
        wall: (L,) s that the outer wall takes at its speed, without starts, stops and corners.
    """

    printed: IntArray
    layer: IntArray
    seconds: FloatArray
    wall: FloatArray


def single_color(
    outlines: WavedOutlines,
    paths: Paths,
    layers: Layers,
    settings: PrintSettings,
    within: Rooms | None = None,
    below: Below | None = None,
) -> SingleColor:
    """The time of every layer, or of the first and some evenly spaced layers of a tall print.

    Args:
        outlines: the waved outer wall.
        paths: of the dual-color print, see `single_color_moves`.
        layers: the stack.
        settings: of the print.
        within: where travels stay unseen, if that is known.
        below: what carries the walls, if that is known.
    """
    printed = np.unique(np.concatenate([outlines.layer, paths.layer]))
    # An odd step, as the fill turns from layer to layer.
    step = len(printed) // _KNOWN_LAYERS // 2 * 2 + 1
    chosen = printed[np.unique(np.append(0, np.arange(step // 2, len(printed), step)))]
    stacked = chosen if step > 1 else np.arange(len(layers))
    moves = single_color_moves(outlines, paths, layers, settings, within, stacked, below)
    passed = np.bincount(moves.layer, move_seconds(moves, settings.printer_profile), len(stacked))
    seconds = passed[np.searchsorted(stacked, chosen)].astype(np.float64)
    x, y = (outlines.base.take(following(outlines.start), axis=0) - outlines.base).T
    way = sums(np.sqrt(x * x + y * y), outlines.start)
    wall = np.bincount(outlines.layer, way, minlength=len(layers)) / settings.outline_speed
    return SingleColor(printed, chosen, seconds, wall)


def single_color_seconds(single: SingleColor, moves: Moves, seconds: FloatArray, settings: PrintSettings) -> float:
    """Seconds that `single_color_moves` take, to within 1 %.

    For a layer that was not computed it is the dual-color print's time without waved wall, tower and tool changes, plus
    the time of the plain wall, plus the mean of what the computed layers take beyond that. Short layers are slowed down
    as far as `slowdown_below_layer_time` and `min_print_speed` ask for.

    Args:
        single: see `single_color`.
        moves: the dual-color print.
        seconds: (M,) `move_seconds` of the moves.
        settings: of the print.
    """
    if len(single.layer) == len(single.printed):
        return float(single.seconds.sum())
    counts = np.ones(len(Feature))
    counts[[Feature.OUTER_WALL, *ONLY_DUAL, *_AROUND]] = 0.0
    weight = counts.take(moves.feature)
    weight[tool_change_rows(moves)] = 0.0
    # The first layer is printed slowly: no example for others. Nor are short layers, which take what they are given.
    first, known, others = single.seconds[0], single.seconds[1:], single.printed[1:]
    least = settings.slowdown_below_layer_time
    guess = _by_layer(moves, weight * seconds, single.wall, settings)
    taken = _as_known(guess, known > least, single)[others]
    if (known <= least).any():
        way = np.where(moves.extrudes, _strand_lengths(moves, settings), 0.0)
        wall = single.wall * settings.outline_speed
        slowest = _by_layer(moves, weight * way, wall, settings) / settings.min_print_speed
        slowed = _as_known(slowest, known < _SLOWED * least, single)[others]
        taken = np.maximum(taken, np.minimum(slowed, least))
    return float(first + taken.sum())


def _strand_lengths(moves: Moves, settings: PrintSettings) -> FloatArray:
    """(M,) mm of strand that the filament of each row gives, by the width and height in its last line."""
    per_mm = np.array(settings.filament_sections) / settings.extrusion_multipliers
    return np.asarray(moves.filament * per_mm[moves.tool] / np.maximum(moves.width * moves.height, _LEAST_MM2))


def _by_layer(moves: Moves, weight: FloatArray, wall: FloatArray, settings: PrintSettings) -> FloatArray:
    """(L,) sums of `weight` over the moves of each layer of the object, plus `wall` (L,)."""
    alike = np.bincount(moves.layer, weight)[settings.raft_layers :]
    amount = wall.copy()
    amount[: len(alike)] += alike
    return amount


def _as_known(guess: FloatArray, examples: BoolArray, single: SingleColor) -> FloatArray:
    """(L,) s guessed, corrected by the mean error of the guesses for the layers `examples` (S - 1,)."""
    more = (single.seconds[1:] - guess[single.layer[1:]])[examples]
    return guess + (more.mean() if len(more) else 0.0)


def single_color_moves(
    outlines: WavedOutlines,
    paths: Paths,
    layers: Layers,
    settings: PrintSettings,
    within: Rooms | None = None,
    chosen: IntArray | None = None,
    below: Below | None = None,
) -> Moves:
    """The same object by one tool: the outlines without their wave at the speed of walls, no tower, all else as it is.

    The walls and the fill behind the outline stay where the wave lets them be, half a wave's depth farther inside than
    a single color asks for, which makes them a little shorter: the comparison errs to our disadvantage.

    Args:
        outlines: the waved outer wall.
        paths: of the dual-color print: fill, inner walls, supports; outer walls and towers are passed over.
        layers: the stack.
        settings: of the print.
        within: where travels stay unseen, if that is known.
        chosen: layers, ascending, that are printed one upon the other without those between them; None for all.
        below: what carries the walls, if that is known; where nothing does, they are as slow as those of two colors.
    """
    chosen = np.arange(len(layers)) if chosen is None else chosen
    number = np.full(len(layers), -1)
    number[chosen] = np.arange(len(chosen))
    wall = _unwaved(outlines, number, settings.chord_tolerance)
    dropped = [int(feature) for feature in (Feature.OUTER_WALL, *ONLY_DUAL)]
    rest = paths.selected(~np.isin(paths.feature, dropped) & (number[paths.layer] >= 0))
    rest = replace(rest, layer=number[rest.layer])
    plain = replace(settings, wave_speed=settings.outline_speed)
    stack = Layers(layers.plane[chosen], layers.top[: len(chosen)], layers.height[chosen])
    printed = ordered(Paths.joined([wall, rest]), plain)
    if below and below.hanging:
        under = below.outlines[np.maximum(chosen - 1, 0)]  # none of the first layer's walls hangs
        shifted = np.append(under[1:], under[:1])  # the layer below is looked for one before
        stacked = Below(below.hanging.of_layers(chosen), shifted)
        printed = with_overhangs(printed, stacked, replace(plain, raft_layers=0))
    return assemble(printed, stack, plain, within, single_color=True)


def _unwaved(outlines: WavedOutlines, number: IntArray, tolerance: float) -> Paths:
    """The outer wall without its wave, on those layers whose new `number` (L,) is not negative."""
    chosen = np.flatnonzero(number[outlines.layer] >= 0)
    count: IntArray = np.diff(outlines.start)[chosen]
    begin = starts(count + 1)[:-1]
    point = ranges(outlines.start[chosen], count + 1)
    point[begin + count] = outlines.start[chosen]  # the loop is closed
    loop = np.repeat(np.arange(len(chosen)), count + 1)
    closing = shapely.linestrings(outlines.base.take(point, axis=0), indices=loop)
    points, row = shapely.get_coordinates(
        shapely.simplify(closing, tolerance, preserve_topology=False), return_index=True
    )
    last = np.append(row[1:] != row[:-1], True)[: len(row)]  # the point that closes the loop
    points, row = points[~last], row[~last]
    return Paths.alike(
        points,
        starts(np.bincount(row, minlength=len(chosen))),
        number[outlines.layer[chosen]],
        feature=Feature.OUTER_WALL,
        island=outlines.polygon[chosen],
        closed=True,
        width=float(np.median(outlines.width)) if len(outlines.width) else 0.0,
    )
