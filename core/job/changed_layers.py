"""Stages run again on the layers that have changed; all other layers keep their former results.

A stroke of the brush changes a few layers. Most stages make every contour or every island by itself, so they are run on
the rows of those layers alone, and what they give is put between the kept rows of their former result.
`StageCache.run_layers` does so with what `LayerRows.only` makes of a stage. Stages that look from layer to layer have
such a function of their own, named after them with `_anew`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from ..contours.contours import Contours
from ..model import BoolArray, IntArray
from ..pattern.wave import WavedOutlines
from ..ragged import runs
from ..records import dataclass
from ..sampling.samples import Samples
from .layers import between, joined, spliced

Result = TypeVar("Result")

_TABLES: tuple[type[Any], ...] = (Contours, WavedOutlines)


@dataclass(frozen=True)
class LayerRows:
    """Which rows of a print's columns belong to which layer.

    Attributes:
        lines: M contours with N points.
        island_layer: (I,) layer of each island, not decreasing.
    """

    lines: Contours
    island_layer: IntArray

    def only(self, stage: Callable[..., Result]) -> Callable[..., Result]:
        """A function that makes some layers anew of what the stage makes of all.

        Args:
            stage: gives waved outlines, a column (N,) of the contour points or (I,) of the islands, or a tuple of
                such columns. Of such columns among its arguments, and of contours, waved outlines and samples, it is
                handed the rows of the layers in question; all else as it is.

        Returns:
            From the former result, the (L,) layers that have changed and the stage's arguments to the new result.
        """

        def anew(former: Result, changed: BoolArray, *arguments: Any) -> Result:
            here = [self._of_layers(first, end) for first, end in runs(changed)]
            parts = [stage(*map(rows.of, arguments)) for rows in here]
            result: Result = _put(former, here, parts, changed)
            return result

        return anew

    def _of_layers(self, first: int, end: int) -> _Rows:
        loops = slice(*np.searchsorted(self.lines.layer, (first, end)).tolist())
        points = slice(*self.lines.start[[loops.start, loops.stop]].tolist())
        islands = slice(*np.searchsorted(self.island_layer, (first, end)).tolist())
        # There are always more points than islands.
        return _Rows(first, end, loops, {len(self.island_layer): islands, len(self.lines.points): points})


@dataclass(frozen=True)
class _Rows:
    """The rows of some layers that follow each other.

    Attributes:
        first: of the layers.
        end: the layer after the last one.
        loops: rows of the contours.
        of_length: rows of a column, by its length for all layers.
    """

    first: int
    end: int
    loops: slice
    of_length: dict[int, slice]

    def of(self, given: Any) -> Any:
        """What of a stage's argument belongs to the layers."""
        if isinstance(given, _TABLES):
            return between(given, self.first, self.end)
        if isinstance(given, Samples):
            return given.of_loops(self.loops)
        if isinstance(given, np.ndarray) and len(given) in self.of_length:
            return given[self.of_length[len(given)]]
        return given


def _put(former: Any, here: list[_Rows], parts: list[Any], changed: BoolArray) -> Any:
    """What a stage has given last, with what it gives for each run of changed layers put in its place."""
    if isinstance(former, tuple):
        columns = zip(former, zip(*parts, strict=True), strict=True)
        return tuple(_put(column, here, list(own), changed) for column, own in columns)
    if not isinstance(former, np.ndarray):
        return spliced(former, joined(parts), changed)
    column = former.copy()
    for rows, part in zip(here, parts, strict=True):
        own = rows.of_length[len(column)]
        # A stage that counts islands from the bed gives all of them, those of other layers empty.
        column[own] = part[own] if len(part) == len(column) else part
    return column
