"""The last stages of the job: all paths in order, the moves that print them, and what these add up to.

Of each stage there is one for the whole print and one for the layers that have changed (`…_anew`, see
`changed_layers.py`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..model import BoolArray, FloatArray
from ..paths import Paths
from ..ragged import runs
from ..records import dataclass
from ..settings import PrintSettings
from ..slicing.planes import Layers
from ..statistics.breakdown import stretches
from ..toolpaths.assemble import assemble
from ..toolpaths.move_times import move_seconds
from ..toolpaths.moves import Moves
from ..toolpaths.order import OrderedPaths, ordered
from ..toolpaths.overhangs import Below, with_overhangs
from ..toolpaths.raft import lifted, raised
from ..toolpaths.travels import Rooms
from .checks import check
from .layers import joined, some, spliced, widened

_LOCAL_SEAMS = ("rear", "nearest")  # those that ask for no seam of the layer below


@dataclass(frozen=True)
class ToneFree:
    """Inputs of the toolpaths that do not depend on any tone.

    Attributes:
        supports: of the object.
        around: skirt or brim, tower, shield and raft.
        below: what carries the walls.
    """

    supports: Paths
    around: Paths
    below: Below


def in_order(wall: Paths, fill: Paths, beside: ToneFree, settings: PrintSettings) -> OrderedPaths:
    """All paths as they are printed, with marks of overhangs.

    Args:
        wall: the outer wall.
        fill: all behind it.
        beside: all else.
        settings: of the print.
    """
    paths = Paths.joined([*(lifted(part, settings) for part in (wall, fill, beside.supports)), beside.around])
    return with_overhangs(ordered(paths, settings), beside.below, settings)


def in_order_anew(
    former: OrderedPaths, changed: BoolArray, wall: Paths, fill: Paths, beside: ToneFree, settings: PrintSettings
) -> OrderedPaths | None:
    """As `in_order`; see `changed_layers.py`."""
    if wall.swapped is not None or settings.seam_position not in _LOCAL_SEAMS or not _apart(former):
        return None
    on_raft = _with_raft(changed, settings)
    own = [paths.selected(changed[paths.layer]) for paths in (wall, fill, beside.supports)]
    around = beside.around.selected(on_raft[beside.around.layer])
    kept, part = _marked(former, in_order(own[0], own[1], replace(beside, supports=own[2], around=around), settings))
    return spliced(kept, part, on_raft)


def moves_along(paths: OrderedPaths, within: Rooms, layers: Layers, settings: PrintSettings) -> Moves:
    """The moves that print the paths.

    Args:
        paths: in printing order.
        within: where travels may go.
        layers: the object's stack.
        settings: of the print.

    Raises:
        PrintError: the print does not fit the printer.
    """
    moves = assemble(paths, raised(layers, settings), settings, within)
    check(moves, settings)
    return moves


def moves_along_anew(
    former: Moves, changed: BoolArray, paths: OrderedPaths, within: Rooms, layers: Layers, settings: PrintSettings
) -> Moves:
    """As `moves_along`; see `changed_layers.py`."""
    # A layer's last moves lead to the next one, so that two more are needed to know those of one more. These are all
    # that its speeds depend on (`layer_time.py`).
    on_raft = _with_raft(changed, settings)
    near = widened(on_raft, 1)
    made = assemble(some(paths, widened(on_raft, 2)), raised(layers, settings), settings, within)
    check(some(made, near), settings)
    return spliced(former, made, near)


def _with_raft(layers: BoolArray, settings: PrintSettings) -> BoolArray:
    """Marks of the object's layers, and of those of the raft below, which no tone changes."""
    return np.append(np.zeros(settings.raft_layers, dtype=bool), layers)


def _apart(paths: OrderedPaths) -> bool:
    """Whether each layer begins with a loop of the tower or the like, so that its order depends on no other layer."""
    layers = np.arange(paths.layer.max(initial=-1) + 1)
    first = np.searchsorted(paths.layer, layers)
    if not len(layers) or (paths.layer[first] != layers).any():
        return False
    begin, end = paths.points[paths.start[first]], paths.points[paths.start[first + 1] - 1]
    then = np.minimum(first + 1, len(paths.layer) - 1)
    alone = (paths.island[then] != paths.island[first]) | (paths.layer[then] != paths.layer[first]) | (then == first)
    return bool(((paths.island[first] < 0) & alone & (begin == end).all(axis=1)).all())


def _marked(*tables: OrderedPaths) -> list[OrderedPaths]:
    """The same tables; if one of them has marks of overhangs, all have."""
    if all(table.over_air is None for table in tables):
        return list(tables)
    marks = (np.zeros(len(table.points), dtype=bool) if table.over_air is None else table.over_air for table in tables)
    return [replace(table, over_air=own) for table, own in zip(tables, marks, strict=True)]


def summary(moves: Moves, settings: PrintSettings) -> tuple[Moves, FloatArray]:
    """The `stretches` of the moves, and the seconds that they take."""
    return stretches(moves, move_seconds(moves, settings.printer_profile))


def summary_anew(
    former: tuple[Moves, FloatArray], changed: BoolArray, moves: Moves, settings: PrintSettings
) -> tuple[Moves, FloatArray] | None:
    """As `summary`; see `changed_layers.py`."""
    near = widened(_with_raft(changed, settings), 1)
    bounds = np.searchsorted(moves.layer, np.array(runs(near)))
    inside = bounds[(bounds > 0) & (bounds < len(moves.layer))]
    if (moves.tool[inside] == moves.tool[inside - 1]).any():  # the printer does not stand still there
        return None
    kept = np.flatnonzero(~near[former[0].layer])
    parts = [(former[0].rows(kept), former[1][kept])]
    for begin, end in bounds.tolist():
        first = max(begin - 1, 0)  # from where the first way leads
        part = moves.rows(slice(first, end))
        seconds = move_seconds(part, settings.printer_profile)[begin - first :]
        parts.append(stretches(part.rows(slice(begin - first, None)), seconds))
    tables, taken = zip(*parts, strict=True)
    table = joined(list(tables))
    order = np.argsort(table.layer, kind="stable")
    return table.rows(order), np.concatenate(taken)[order]
