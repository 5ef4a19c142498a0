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
        wipe: (K,) mm that the nozzle goes over the path before while the filament is pulled back.
        via: (K,) places that it passes on the way.
        hops: whether the nozzle is lifted on travels with retraction.
        begins_pulled_back: whether the print begins retracted, so that nothing drips on the long way to the first path.
    """

    changes: BoolArray
    retracts: BoolArray
    travels: BoolArray
    wipe: FloatArray
    via: IntArray
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
    begin, end = paths.points[paths.start[:-1]], paths.points[paths.start[1:] - 1]
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
    begins_pulled_back = settings.retract_length > 0
    return Approach(changes, retracts, (distance > TOUCHING) | rises, wipe, via, settings.z_hop > 0, begins_pulled_back)


def fill_approaches(
    table: Moves,
    paths: OrderedPaths,
    layers: Layers,
    first: IntArray,
    approach: Approach,
    length: FloatArray,
    ways: Travels,
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
        ways: from path to path.
        settings: lengths and speeds of retraction, lifts.
    """
    first_point = np.column_stack([paths.points[paths.start[:-1]], layers.top[paths.layer]])
    _pass_by(table, first_point, first, approach, ways, settings)
    left = _pull_back(table, paths, layers, first, approach, length, settings)

    if approach.begins_pulled_back and len(first):
        _prime(table, first[:1] + 1, first_point[:1], settings.retract_length, settings)
    _change_tool(table, paths, first_point, left, first, approach, settings)
    _travel_retracted(table, first_point, left, first, approach, settings)


def _change_tool(
    table: Moves,
    paths: OrderedPaths,
    first_point: FloatArray,
    left: FloatArray,
    first: IntArray,
    approach: Approach,
    settings: PrintSettings,
) -> None:
    """Write the moves of tool changes once the filament is pulled back: lift, way of the new tool, descent, priming."""
    chosen = np.flatnonzero(approach.changes)
    row = first[chosen] + approach.pulls[chosen]
    lift = np.array([0.0, 0.0, settings.z_hop_toolchange])
    table.position[row] = left[chosen] + lift
    table.tool[row] = table.tool[np.maximum(first[chosen] - 1, 0)]
    table.layer[row] = paths.layer[chosen - 1]
    table.position[row + 1] = first_point[chosen] + lift
    table.position[row + 2] = first_point[chosen]
    amount = settings.retract_length_toolchange + settings.retract_restart_extra_toolchange
    _prime(table, row + 3, first_point[chosen], amount, settings)


def _travel_retracted(
    table: Moves,
    first_point: FloatArray,
    left: FloatArray,
    first: IntArray,
    approach: Approach,
    settings: PrintSettings,
) -> None:
    """Write the moves of travels with retraction once the filament is pulled back: lift, travel, descent, priming."""
    chosen = np.flatnonzero(approach.retracts)
    row = first[chosen] + approach.pulls[chosen]
    if approach.hops:
        # Over the higher of the two layers, as a travel may lead up a layer.
        height = np.maximum(left[chosen, 2], first_point[chosen, 2]) + settings.z_hop
        table.position[row] = np.column_stack([left[chosen, :2], height])
        row = row + 1 + approach.via[chosen]
        table.position[row] = np.column_stack([first_point[chosen, :2], height])
        row = row + 1
    else:
        row = row + approach.via[chosen]
    table.position[row] = first_point[chosen]
    _prime(table, row + 1, first_point[chosen], settings.retract_length + settings.retract_restart_extra, settings)


def _prime(table: Moves, row: IntArray, place: FloatArray, amount_mm: float, settings: PrintSettings) -> None:
    """Write rows that feed what was pulled back, and perhaps a little more, at places (R, 3)."""
    table.position[row] = place
    table.feature[row] = Feature.RETRACT
    table.filament[row] = amount_mm
    table.speed[row] = settings.deretract_speed


def _pass_by(
    table: Moves, first_point: FloatArray, first: IntArray, approach: Approach, ways: Travels, settings: PrintSettings
) -> None:
    """Write the travels by way of other places; those have the height of the travel, which stays on its layer."""
    path = np.repeat(np.arange(len(first)), approach.via)
    lifted = approach.retracts & approach.hops
    row = ranges(first + approach.pulls + lifted, approach.via)
    table.position[row, :2] = ways.via[ranges(ways.start[:-1], approach.via)]
    table.position[row, 2] = first_point[path, 2] + np.where(lifted[path], settings.z_hop, 0.0)


def _pull_back(
    table: Moves,
    paths: OrderedPaths,
    layers: Layers,
    first: IntArray,
    approach: Approach,
    length: FloatArray,
    settings: PrintSettings,
) -> FloatArray:
    """Write the moves that pull the filament back; returns (K, 3) mm, where the nozzle then is."""
    left = np.zeros((len(first), 3))
    left[1:] = np.column_stack([paths.points[paths.start[1:] - 1], layers.top[paths.layer]])[:-1]
    amount = np.where(approach.changes, settings.retract_length_toolchange, settings.retract_length)
    pulls = approach.pulls
    arc = _arcs(paths, length)
    for step in range(int(pulls.max(initial=0))):
        chosen = np.flatnonzero(pulls > step)
        row = first[chosen] + step
        before = left[chosen].copy()
        wipes = approach.wipe[chosen] > 0
        way = summable(approach.wipe[chosen[wipes]] * ((step + 1) / _WIPE_MOVES))
        left[chosen[wipes], :2] = _along(paths, arc, chosen[wipes], way)
        pulled = amount[chosen] / pulls[chosen]
        way = np.hypot(*(left[chosen] - before)[:, :2].T)
        seconds = np.maximum(pulled / settings.retract_speed, way / settings.travel_speed)
        table.position[row] = left[chosen]
        table.feature[row] = np.where(pulled > 0, int(Feature.RETRACT), int(Feature.TRAVEL))
        table.filament[row] = -pulled
        moved = way > 0
        table.speed[row] = np.where(moved, way / np.where(moved, seconds, 1.0), settings.retract_speed)
        table.tool[row] = table.tool[np.maximum(first[chosen] - 1, 0)]
        table.layer[row] = paths.layer[chosen - 1]
    return left


def _along(paths: OrderedPaths, arc: FloatArray, chosen: IntArray, way: FloatArray) -> FloatArray:
    """(C, 2) mm, places at a distance `way` past the end of the paths before the chosen ones.

    Past its end a closed path starts over; an open one is traced backwards.
    """
    begin, end = paths.start[chosen - 1], paths.start[chosen] - 1
    closed = (np.abs(paths.points[begin] - paths.points[end]) < TOUCHING).all(axis=1)
    place = np.where(closed, arc[begin] + way, arc[end] - way)
    after = np.clip(np.searchsorted(arc, place, side="right"), 1, len(arc) - 1)
    near, far = paths.points[after - 1], paths.points[after]
    slope = (far - near) / np.maximum(arc[after] - arc[after - 1], TOUCHING**2)[:, None]
    return np.asarray(near + slope * (place - arc[after - 1])[:, None])


def _arcs(paths: OrderedPaths, length: FloatArray) -> FloatArray:
    """(N,) mm along all paths one after the other, 1 mm between each and the next."""
    step = length[:-1].copy()
    step[paths.start[1:-1] - 1] = 1.0
    return np.concatenate([[0.0], np.cumsum(step)])
