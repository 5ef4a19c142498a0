"""Tables ordered by layer: parts of them, and layers of one table put in the place of another's."""

from __future__ import annotations

from dataclasses import fields
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np

from ..contours.contours import Contours
from ..model import BoolArray
from ..pattern.wave import WavedOutlines
from ..ragged import runs, starts
from ..toolpaths.moves import Moves
from ..toolpaths.order import OrderedPaths

_SHORT_GAP, _MOST_RUNS = 4, 8
_OFFSETS = ("start", "arc_start")

Table = TypeVar("Table", Contours, WavedOutlines, OrderedPaths, Moves)


def widened(layers: BoolArray, by: int) -> BoolArray:
    """(L,) the layers marked, and `by` more below and above each."""
    wide = layers.copy()
    for step in range(1, by + 1):
        wide[step:] |= layers[:-step]
        wide[:-step] |= layers[step:]
    return wide


def without_gaps(layers: BoolArray) -> BoolArray:
    """(L,) the layers marked, with short gaps between runs filled, or all gaps where there are many runs."""
    found, filled = runs(layers), layers.copy()
    for (_, last), (first, _) in pairwise(found):
        filled[last:first] |= first - last <= _SHORT_GAP or len(found) > _MOST_RUNS
    return filled


def between(table: Table, first: int, last: int) -> Table:
    """The layers from `first` to the one before `last`, as views.

    Args:
        table: its `layer` (K,) does not decrease; columns have a row for each of these, or, where there is a `start`,
            for each of their points.
        first: layer.
        last: layer.
    """
    low, high = np.searchsorted(table.layer, (first, last)).tolist()
    start = getattr(table, "start", None)
    points = slice(low, high) if start is None else slice(int(start[low]), int(start[high]))

    def rows(name: str, column: Any) -> Any:
        if column is None or name in _OFFSETS:
            return column if column is None else column[low : high + 1]
        return column[low:high] if len(column) == len(table.layer) else column[points]

    columns = {column.name: rows(column.name, getattr(table, column.name)) for column in fields(table)}
    if start is not None:
        columns["start"] = columns["start"] - points.start
    return type(table)(**columns)


def joined(parts: list[Table]) -> Table:
    """Several tables one after the other."""
    if len(parts) == 1:
        return parts[0]
    columns: dict[str, Any] = {}
    for name in (column.name for column in fields(parts[0])):
        values = [getattr(part, name) for part in parts]
        if name == "start":
            columns[name] = starts(np.concatenate([np.diff(start) for start in values]))
        else:
            columns[name] = None if values[0] is None else np.concatenate(values)
    return type(parts[0])(**columns)


def some(table: Table, layers: BoolArray) -> Table:
    """The layers marked (L,), at least one."""
    return joined([between(table, first, last) for first, last in runs(layers)])


def spliced(former: Table, anew: Table, layers: BoolArray) -> Table:
    """The layers marked (L,) of the new table, the others of the former one."""
    edges = [0, *(np.flatnonzero(layers[1:] != layers[:-1]) + 1).tolist(), len(layers)]
    return joined([between(anew if layers[first] else former, first, last) for first, last in pairwise(edges)])
