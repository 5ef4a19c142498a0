"""How the nozzle gets from one path to the next: pulling back, wiping, lifting, changing the tool, priming."""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, FloatArray, IntArray
from ..paths import Feature
from ..ragged import ranges, summable, sums
from ..records import dataclass
from ..settings import PrintSettings
from ..slicing.planes import Layers
from .moves import Moves
from .order import OrderedPaths
from .travels import Travels

# Paths that meet within this (mm) go on without a travel.
TOUCHING = 1e-3
# On its way out a freshly primed nozzle always wipes this far over the tower's line (mm).
TOWER_WIPE_MM = 2.0
# Moves of a wipe: few enough to last 10 ms each, enough to follow a wave.
_WIPE_MOVES = 4
# A shorter way is no wipe (mm).
_LEAST_WIPE_MM = 0.1


@dataclass(frozen=True)
class Approach:
    """How each path is reached from the one before it.

    Attributes:
        changes: (K,) the tool is changed before it.
        retracts: (K,) a long travel with retraction.
        travels: (K,) any travel; True wherever one of the others is.
        wipe: (K,) mm that the nozzle moves back over the path before while the filament is pulled back.
        via: (K,) how many places it passes on the way.
        places: (V, 2) mm, those places, path by path.
        hops: whether the nozzle is lifted on travels with retraction.
        begins_pulled_back: whether the print begins retracted, so that nothing drips on the long way to the first path.
    """

    changes: BoolArray
    retracts: BoolArray
    travels: BoolArray
    wipe: FloatArray
    via: IntArray
    places: FloatArray
    hops: bool
    begins_pulled_back: bool

    @property
    def pulls(self) -> IntArray:
        """(K,) moves in which the filament is pulled back."""
        wiping = np.where(self.wipe > 0, _WIPE_MOVES, 1)
        return np.where(self.changes | self.retracts, wiping, 0).astype(np.int64)

    @property
    def rows(self) -> IntArray:
        """(K,) moves before the path's first extrusion: pulling back, lift, travel, descent, priming, as they apply."""
        travel = np.where(self.retracts, 4 if self.hops else 2, self.travels.astype(np.int64))
        rows = np.asarray(self.pulls + self.via + np.where(self.changes, 4, travel), dtype=np.int64)
        rows[:1] += self.begins_pulled_back
        return rows


def approaches(
    paths: OrderedPaths, tool: IntArray, length: FloatArray, ways: Travels, settings: PrintSettings
) -> Approach:
    """Decide how each of K paths is reached.

    Args:
        paths: in printing order.
        tool: (K,) that prints each.
        length: (N,) mm from each point to the next of its path.
        ways: from path to path.
        settings: retract_before_travel, wipe and z_hop are used.
    """
    begin, end = paths.ends
    distance = np.full(len(begin), np.inf)
    distance[1:] = np.hypot(*(begin[1:] - end[:-1]).T)
    changes = np.zeros(len(begin), dtype=bool)
    changes[1:] = tool[1:] != tool[:-1]
    rises = np.zeros(len(begin), dtype=bool)
    rises[1:] = paths.layer[1:] != paths.layer[:-1]
    retracts = (distance > settings.retract_before_travel) & ~changes & ~ways.hidden
    retracts[:1] = False
    wipe = np.zeros(len(begin))
    least = np.where(paths.feature[:-1] == Feature.TOWER, TOWER_WIPE_MM, 0.0)
    wipe[1:] = np.minimum(np.maximum(least, settings.wipe), sums(length, paths.start)[:-1])
    wipe[~(changes | retracts) | (wipe < _LEAST_WIPE_MM)] = 0.0
    via = np.where(changes, 0, ways.count)
    places = ways.via[ranges(ways.start[:-1], via)]
    travels = (distance > TOUCHING) | rises
    return Approach(changes, retracts, travels, wipe, via, places, settings.z_hop > 0, settings.retract_length > 0)


@dataclass(frozen=True)
class _Connections:
    """The rows of the table of moves that lead to each of K paths.

    Attributes:
        table: of all moves; written into.
        paths: K, in printing order.
        approach: how each path is reached.
        first: (K,) the first row before each path.
        begin: (K, 3) mm, where each path begins.
        left: (K, 3) mm, where the nozzle is once the filament is pulled back; before that, where the last path ends.
    """

    table: Moves
    paths: OrderedPaths
    approach: Approach
    first: IntArray
    begin: FloatArray
    left: FloatArray


def fill_approaches(
    table: Moves,
    paths: OrderedPaths,
    layers: Layers,
    first: IntArray,
    approach: Approach,
    length: FloatArray,
    settings: PrintSettings,
) -> None:
    """Write the moves before each path, in place.

    Args:
        table: with the tool and layer of the path that follows in these rows.
        paths: K, in printing order.
        layers: the stack.
        first: (K,) row at which each path's approach begins.
        approach: how each path is reached.
        length: (N,) mm from each point to the next of its path.
        settings: lengths and speeds of retraction, lifts.
    """
    top = layers.top[paths.layer]
    left = np.zeros((len(first), 3))
    begin, end = (np.column_stack([tips, top]) for tips in paths.ends)
    left[1:] = end[:-1]
    between = _Connections(table, paths, approach, first, begin, left)
    _pass_by(between, settings)
    _pull_back(between, _arcs(paths, length), settings)
    if approach.begins_pulled_back and len(first):
        _prime(table, first[:1] + 1, between.begin[:1], settings.retract_length, settings)
    _change_tool(between, settings)
    _travel_retracted(between, settings)


def _change_tool(between: _Connections, settings: PrintSettings) -> None:
    """Write the moves of tool changes after the filament is pulled back: lift, travel, descent, priming."""
    table, approach = between.table, between.approach
    chosen = np.flatnonzero(approach.changes)
    row = between.first[chosen] + approach.pulls[chosen]
    begin, lift = between.begin[chosen], np.array([0.0, 0.0, settings.z_hop_toolchange])
    table.position[row] = between.left[chosen] + lift
    _belongs_to_the_path_before(between, chosen, row)
    table.position[row + 1] = begin + lift
    table.position[row + 2] = begin
    amount = settings.retract_length_toolchange + settings.retract_restart_extra_toolchange
    _prime(table, row + 3, begin, amount, settings)


def _travel_retracted(between: _Connections, settings: PrintSettings) -> None:
    """Write the moves of travels with retraction after the filament is pulled back: lift, travel, descent, priming."""
    table, approach = between.table, between.approach
    chosen = np.flatnonzero(approach.retracts)
    row = between.first[chosen] + approach.pulls[chosen]
    begin, left = between.begin[chosen], between.left[chosen]
    if approach.hops:
        height = begin[:, 2] + settings.z_hop  # over the higher of the two layers, as a travel may lead up a layer
        table.position[row] = np.column_stack([left[:, :2], height])
        row = row + 1 + approach.via[chosen]
        table.position[row] = np.column_stack([begin[:, :2], height])
        row = row + 1
    else:
        row = row + approach.via[chosen]
    table.position[row] = begin
    _prime(table, row + 1, begin, settings.retract_length + settings.retract_restart_extra, settings)


def _prime(table: Moves, row: IntArray, place: FloatArray, amount_mm: float, settings: PrintSettings) -> None:
    """Write rows that feed what was pulled back, and perhaps a little more, at places (R, 3)."""
    table.position[row] = place
    table.feature[row] = Feature.RETRACT
    table.filament[row] = amount_mm
    table.speed[row] = settings.deretract_speed


def _belongs_to_the_path_before(between: _Connections, chosen: IntArray, row: IntArray) -> None:
    """Give rows (R,), each before one of the chosen paths (R,), the tool and the layer of the path before that."""
    between.table.tool[row] = between.table.tool[np.maximum(between.first[chosen] - 1, 0)]
    between.table.layer[row] = between.paths.layer[chosen - 1]


def _pass_by(between: _Connections, settings: PrintSettings) -> None:
    """Write the places on the way of travels, at the height of the travel."""
    position, approach = between.table.position, between.approach
    lifted = approach.retracts & approach.hops
    row = ranges(between.first + approach.pulls + lifted, approach.via)
    position[row, :2] = approach.places
    position[row, 2] = np.repeat(between.begin[:, 2] + np.where(lifted, settings.z_hop, 0.0), approach.via)


def _pull_back(between: _Connections, arc: FloatArray, settings: PrintSettings) -> None:
    """Write the moves that pull the filament back, and move `between.left` to where the nozzle then is.

    Args:
        between: before each path.
        arc: (N,) mm, see `_arcs`.
        settings: lengths and speeds of retraction.
    """
    table, left, approach = between.table, between.left, between.approach
    amount = np.where(approach.changes, settings.retract_length_toolchange, settings.retract_length)
    pulls = approach.pulls
    for step in range(int(pulls.max(initial=0))):
        chosen = np.flatnonzero(pulls > step)
        row = between.first[chosen] + step
        before = left[chosen].copy()
        wipes = approach.wipe[chosen] > 0
        way = summable(approach.wipe[chosen[wipes]] * ((step + 1) / _WIPE_MOVES))
        left[chosen[wipes], :2] = _along(between.paths, arc, chosen[wipes], way)
        pulled = amount[chosen] / pulls[chosen]
        way = np.hypot(*(left[chosen] - before)[:, :2].T)
        seconds = np.maximum(pulled / settings.retract_speed, way / settings.travel_speed)
        table.position[row] = left[chosen]
        table.feature[row] = np.where(pulled > 0, int(Feature.RETRACT), int(Feature.TRAVEL))
        table.filament[row] = -pulled
        moved = way > 0
        table.speed[row] = np.where(moved, way / np.where(moved, seconds, 1.0), settings.retract_speed)
        _belongs_to_the_path_before(between, chosen, row)


def _along(paths: OrderedPaths, arc: FloatArray, chosen: IntArray, way: FloatArray) -> FloatArray:
    """(C, 2) mm, places at a distance `way` past the end of the paths before the chosen ones.

    Past its end a closed path starts over; an open one is traced backwards.
    """
    begin, end = paths.start[chosen - 1], paths.start[chosen] - 1
    apart = paths.points.take(begin, axis=0) - paths.points.take(end, axis=0)
    closed = (np.abs(apart) < TOUCHING).all(axis=1)
    place = np.where(closed, arc[begin] + way, arc[end] - way)
    after = np.clip(np.searchsorted(arc, place, side="right"), 1, len(arc) - 1)
    near, far = (paths.points.take(place, axis=0) for place in (after - 1, after))
    slope = (far - near) / np.maximum(arc[after] - arc[after - 1], TOUCHING**2)[:, None]
    return np.asarray(near + slope * (place - arc[after - 1])[:, None])


def _arcs(paths: OrderedPaths, length: FloatArray) -> FloatArray:
    """(N,) mm along all paths, one after the other with 1 mm in between."""
    step = length[:-1].copy()
    step[paths.start[1:-1] - 1] = 1.0
    return np.concatenate([[0.0], np.cumsum(step)])
