"""The printing order of the paths of each layer, and the direction in which each is printed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..model import BoolArray, FloatArray, IntArray
from ..paths import Feature, Paths
from ..ragged import ranges, starts
from ..records import dataclass
from ..settings import PrintSettings
from .seams import has_seam, seam_offsets
from .tool_turns import tool_turns

# Up to this many paths are compared one by one, more of them as arrays.
_MANY = 64


@dataclass(frozen=True)
class OrderedPaths:
    """All paths in printing order, each point in the order of printing; closed ones repeat their first point.

    Attributes:
        points: (N, 2) mm.
        width: (N,) mm, of the line that leaves each point.
        start: (K + 1,) int64.
        layer: (K,) int64, not decreasing.
        feature: (K,) int64.
        island: (K,) int64, see `Paths`.
        swapped: (K,) bool, see `Paths`; here for the tower too.
        over_air: (N,) bool, whether the line that leaves each point is a wall over air; None where none is.
    """

    points: FloatArray
    width: FloatArray
    start: IntArray
    layer: IntArray
    feature: IntArray
    island: IntArray
    swapped: BoolArray | None = None
    over_air: BoolArray | None = None

    @property
    def ends(self) -> tuple[FloatArray, FloatArray]:
        """(K, 2) mm each, where the paths begin and where they end."""
        return self.points.take(self.start[:-1], axis=0), self.points.take(self.start[1:] - 1, axis=0)


def ordered(paths: Paths, settings: PrintSettings) -> OrderedPaths:
    """Order all layers: skirt, tower and supports, then region by region, always the nearest next; walls before fill.

    Paths of a layer's second tool come after all those of its first one.

    Args:
        paths: of all features and layers.
        settings: seam_position and outer_wall_first are used.
    """
    offset = seam_offsets(paths, settings)
    first = paths.start[:-1] + offset
    last = np.where(paths.closed, first, paths.start[1:] - 1)
    walk = _Walk(_complex(paths.points.take(first, axis=0)), _complex(paths.points.take(last, axis=0)))
    if settings.seam_position == "nearest":
        walk.choose_seams(paths)
    rank = _ranks(settings)[paths.feature]
    swapped, turn = tool_turns(paths, settings)
    turn += 2 * paths.layer
    order = np.lexsort((rank, paths.island, turn))
    key = np.stack([turn, paths.island, rank])[:, order]
    cuts = np.flatnonzero((np.diff(key, axis=1) != 0).any(axis=0)) + 1
    begin = np.concatenate([[0], cuts]).astype(np.int64)[: len(order)]
    members = order.tolist()
    turns: dict[int, dict[int, list[list[int]]]] = {}
    ends = [*begin[1:].tolist(), len(members)]
    for number, island, low, high in zip(
        key[0, begin].tolist(), key[1, begin].tolist(), begin.tolist(), ends, strict=True
    ):
        turns.setdefault(number, {}).setdefault(island, []).append(members[low:high])
    for islands in turns.values():
        walk.print_turn(islands)
    flipped = np.zeros(len(order), dtype=bool)
    flipped[walk.flipped] = True
    for path, seam in walk.seams.items():
        offset[path] = seam
    return _laid_out(replace(paths, swapped=swapped), np.array(walk.sequence, dtype=np.int64), offset, flipped)


class _Walk:
    """The way of the nozzle from path to path.

    Attributes:
        sequence: the paths printed so far.
        flipped: those of them that were printed from their end to their beginning.
        seams: for closed paths that start nearest to the nozzle, the point where they start.
    """

    def __init__(self, begin: NDArray[np.complex128], end: NDArray[np.complex128]) -> None:
        """(K,) places where the paths begin and end, x + iy in mm; the same for closed ones."""
        self._begin, self._end = begin, end
        # Most choices are between a handful of paths, which plain numbers make faster than arrays.
        self._begins: list[complex] = begin.tolist()
        self._ends: list[complex] = end.tolist()
        self._place = 0j
        self.sequence: list[int] = []
        self.flipped: list[int] = []
        self.seams: dict[int, int] = {}
        self._loops: Paths | None = None
        self._seamed: BoolArray = np.zeros(0, dtype=bool)

    def choose_seams(self, paths: Paths) -> None:
        """Start closed paths at the point nearest to the nozzle from now on."""
        self._loops, self._seamed = paths, has_seam(paths)

    def print_turn(self, islands: dict[int, list[list[int]]]) -> None:
        """Visit islands of a layer: those around the part in the order of their numbers, then the nearest next.

        Args:
            islands: by number, in ascending order, the runs of paths that are printed one after the other.
        """
        # Islands around the part have negative numbers: a nozzle is primed before it meets the part.
        waiting = []
        for island, runs in islands.items():
            if island < 0:
                self._print_island(runs)
            else:
                waiting.append(runs)
        entries = [self._begins[runs[0][0]] for runs in waiting]
        while waiting:
            away = [abs(entry - self._place) for entry in entries]
            nearest = away.index(min(away))
            del entries[nearest]
            self._print_island(waiting.pop(nearest))

    def _print_island(self, runs: list[list[int]]) -> None:
        """Print runs of paths one after the other, each run nearest first."""
        for run in runs:
            if len(run) == 1:
                path = run[0]
                self._print(path, abs(self._ends[path] - self._place) < abs(self._begins[path] - self._place))
            elif len(run) > _MANY:
                self._print_many(np.array(run))
            else:
                self._print_few(run)

    def _print_few(self, waiting: list[int]) -> None:
        """Visit paths nearest first; open ones may be printed from either end."""
        tips = [self._begins[path] for path in waiting] + [self._ends[path] for path in waiting]
        while waiting:
            place = self._place
            away = [abs(tip - place) for tip in tips]
            nearest = away.index(min(away))
            backwards = nearest >= len(waiting)
            chosen = nearest - len(waiting) if backwards else nearest
            del tips[chosen + len(waiting)], tips[chosen]
            self._print(waiting.pop(chosen), backwards)

    def _print_many(self, waiting: IntArray) -> None:
        """As `_print_few`."""
        begin, end = self._begin[waiting], self._end[waiting]
        for _ in range(len(waiting)):
            to_begin, to_end = np.abs(begin - self._place), np.abs(end - self._place)
            a, b = int(to_begin.argmin()), int(to_end.argmin())
            backwards = bool(to_end[b] < to_begin[a])
            chosen = b if backwards else a
            self._print(int(waiting[chosen]), backwards)
            begin[chosen] = end[chosen] = np.inf

    def _print(self, path: int, backwards: bool) -> None:
        """Go on over a path, or back from its end to its beginning."""
        self.sequence.append(path)
        if self._loops is not None and self._seamed[path]:
            loop = _complex(self._loops.points[self._loops.start[path] : self._loops.start[path + 1]])
            seam = int(np.abs(loop - self._place).argmin())
            self.seams[path] = seam
            self._place = complex(loop[seam])
            return
        if backwards:
            self.flipped.append(path)
        self._place = (self._begins if backwards else self._ends)[path]


def _ranks(settings: PrintSettings) -> IntArray:
    """By `Feature`, the place in the printing order of an island; 0 for all that has an island of its own."""
    rank = np.zeros(len(Feature), dtype=np.int64)
    walls = [Feature.OUTER_WALL, Feature.INNER_WALL]
    walls = walls if settings.outer_wall_first else walls[::-1]
    inside = [*walls, Feature.BRIDGE, Feature.SKIN, Feature.INFILL]
    for place, feature in enumerate([*inside, Feature.SUPPORT, Feature.SUPPORT_INTERFACE]):
        rank[feature] = place
    return rank


def _complex(points: FloatArray) -> NDArray[np.complex128]:
    """(N,) x + iy of points (N, 2)."""
    return np.asarray(points[:, 0] + 1j * points[:, 1])


def _laid_out(paths: Paths, sequence: IntArray, offset: IntArray, flipped: BoolArray) -> OrderedPaths:
    """Paths in a sequence (K,): closed ones from the point `offset` (K,) on, those `flipped` (K,) from their end."""
    first, count, offset = paths.start[sequence], np.diff(paths.start)[sequence], offset[sequence]
    printed = count + paths.closed[sequence]
    start = starts(printed)
    point = np.arange(start[-1]) + np.repeat(first + offset - start[:-1], printed)
    # A closed path goes on with its first point and ends where it began.
    over = np.where(paths.closed[sequence], offset + 1, 0)
    point[ranges(start[1:] - over, over)] -= np.repeat(count, over)
    turned = flipped[sequence]
    row = ranges(start[:-1][turned], count[turned])
    backwards = np.repeat((first + count - 1 + start[:-1])[turned], count[turned]) - row
    point[row] = backwards
    width = paths.width.take(point)
    # A line printed backwards leaves its points by the segment that used to arrive there.
    width[row] = paths.width[np.maximum(backwards - 1, np.repeat(first[turned], count[turned]))]
    return OrderedPaths(
        points=paths.points.take(point, axis=0),
        width=width,
        start=start,
        layer=paths.layer[sequence],
        feature=paths.feature[sequence],
        island=paths.island[sequence],
        swapped=None if paths.swapped is None else paths.swapped[sequence],
    )
