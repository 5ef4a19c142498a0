"""Overhanging walls: lines under which nothing of the layer below reaches.

Few walls of a print overhang, so two coarse tests come first: which faces are flat enough, and which lines pass through
the layers and the grid cells where those lie. Only these lines are tested against the layer below.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np
import shapely
from numpy.typing import NDArray

from ..model import BoolArray, FloatArray, IntArray, Shapes, TriangleMesh
from ..paths import Feature
from ..ragged import ranges, summable
from ..records import dataclass
from ..settings import PrintSettings
from .order import OrderedPaths

Scalar = TypeVar("Scalar", bound=np.generic)

_PIECE = 1.0  # mm; lines are looked at in pieces about so long
_SHORTEST = 1.5  # mm; a strand carries itself over less, and less between two parts over air belongs to them
_CELL = 2.0  # mm
_STRETCH = 2.0  # mm; so much of a line is looked for in the cells at a time


@dataclass(frozen=True)
class Undersides:
    """Where the object's flat undersides are, on a coarse grid that rules out all but a few walls.

    Attributes:
        on: (L,) bool, layers that may hang over the one below somewhere.
        corner: (2,) mm, of the cells.
        cells: (L, X, Y) bool, where that may be, in cells `_CELL` mm wide; the grid is larger than all walls.
    """

    on: BoolArray
    corner: FloatArray
    cells: BoolArray

    def of_layers(self, chosen: IntArray) -> Undersides:
        """Those of some layers only."""
        return Undersides(self.on[chosen], self.corner, self.cells[chosen])

    def near(self, x: FloatArray, y: FloatArray, layer: IntArray) -> BoolArray:
        """(N,) whether places (x, y) on layers lie in a marked cell."""
        _, columns, rows = self.cells.shape
        column = ((x - self.corner[0]) / _CELL).astype(np.intp)
        row = ((y - self.corner[1]) / _CELL).astype(np.intp)
        return np.asarray(self.cells.ravel().take((layer * columns + column) * rows + row, mode="clip"))


@dataclass(frozen=True)
class Below:
    """What carries the walls of a print.

    Attributes:
        hanging: see `undersides`.
        outlines: (L,) cross-section of each layer of the object.
    """

    hanging: Undersides | None
    outlines: Shapes


def undersides(mesh: TriangleMesh, plane: FloatArray, settings: PrintSettings) -> Undersides | None:
    """Find where faces are so flat that an outline may move by more than a line's width from one layer to the next.

    Everywhere else each line of a wall lies at least partly on a line of the layer below.

    Args:
        mesh: as sliced.
        plane: (L,) mm, where the layers are cut.
        settings: `overhang_speed` and `bridge_flow` say whether it matters.

    Returns:
        None where no line can hang over air.
    """
    if not settings.overhang_speed and settings.bridge_flow == 1.0:
        return None
    low, high = _flat_faces(mesh, float(np.diff(plane).max(initial=0.0)), settings.extrusion_width)
    # The first layer above the bottom of each face, and the first above its top.
    first = np.maximum(np.searchsorted(plane, low[2]), 1)
    layers = np.minimum(np.searchsorted(plane, high[2], side="right"), len(plane) - 1) + 1 - first
    if not (layers > 0).any():
        return None
    layers = np.maximum(layers, 0)
    margin = settings.extrusion_width + settings.wave_crest + _STRETCH / 2
    corner = mesh.bounds[0, :2] - margin - _CELL
    begin, end = (((side - corner[:, None]) / _CELL).astype(np.int64) for side in (low[:2] - margin, high[:2] + margin))
    sizes = ((mesh.bounds[1, :2] + margin + _CELL - corner) / _CELL).astype(np.int64) + 1
    on, cells = np.zeros(len(plane), dtype=bool), np.zeros((len(plane), *sizes.tolist()), dtype=bool)
    columns, rows = end - begin + 1
    count = layers * columns * rows
    face = np.repeat(np.arange(len(count)), count)
    number, row = np.divmod(ranges(0, count), rows.take(face))
    number, column = np.divmod(number, columns.take(face))
    layer = number + first.take(face)
    on[layer] = cells[layer, column + begin[0].take(face), row + begin[1].take(face)] = True
    return Undersides(on, corner, cells)


def _flat_faces(mesh: TriangleMesh, rise: float, width: float) -> tuple[FloatArray, FloatArray]:
    """(3, F) mm, least and greatest X, Y, Z of the faces seen from below that move by `width` and more in a `rise`."""
    x, y, z = mesh.area_normals.T
    is_inside_out = (z * mesh.vertices[:, 2].take(mesh.faces[:, 0])).sum() < 0
    flat = (z * rise) ** 2 > width**2 * (x * x + y * y)
    flat &= (z > 0) if is_inside_out else (z < 0)
    corners = mesh.vertices.T.take(mesh.faces[flat].T, axis=1)
    return corners.min(axis=1), corners.max(axis=1)


def with_overhangs(paths: OrderedPaths, below: Below, settings: PrintSettings) -> OrderedPaths:
    """Mark the lines of walls that hang over air; lines are cut where that begins and ends, and get `bridge_flow`.

    Args:
        paths: in printing order.
        below: what carries the walls.
        settings: `raft_layers`, which lie below the object's, `bridge_flow` and `extrusion_width` are used.

    Returns:
        The paths, with `over_air`; that is None where nothing overhangs.
    """
    hanging = below.hanging
    if hanging is None:
        return paths
    layer = paths.layer - settings.raft_layers
    walls = (paths.feature == Feature.OUTER_WALL) | (paths.feature == Feature.INNER_WALL)
    chosen = np.flatnonzero(walls & hanging.on.take(layer, mode="clip"))
    chords = np.diff(paths.start)[chosen] - 1
    lines = _Lines(paths.points, ranges(paths.start[chosen], chords), np.repeat(layer[chosen], chords))
    near = hanging.near(lines.x + lines.step_x / 2, lines.y + lines.step_y / 2, lines.layer)
    long = np.flatnonzero(lines.length > _STRETCH)
    of, _, x, y = lines.selected(long).pieces(_STRETCH)
    near[long[of[hanging.near(x, y, lines.layer[long[of]])]]] = True
    lines = lines.selected(np.flatnonzero(near))
    of, share, x, y = lines.pieces(_PIECE)
    length = (lines.length / np.bincount(of, minlength=len(lines.length))).take(of)
    group = np.cumsum(np.diff(lines.chord, prepend=lines.chord[:1]) != 1).take(of)  # lines that follow each other
    asked = _one_each(length, group)
    reach = settings.extrusion_width / 2 + settings.wave_crest  # crests are not to be slowed
    free = _free(lines, of[asked], np.array([x[asked], y[asked]]), below.outlines, reach)
    if not free.any():
        return paths
    free = _long_parts(np.repeat(free, np.diff(np.append(asked, len(of)))), length, group)
    return _cut(paths, lines.chord[of], share, free, settings.bridge_flow) if free.any() else paths


class _Lines:
    """Some of the straight lines of paths.

    Attributes:
        chord: (C,) the point that each one leaves.
        layer: (C,) of the object.
        x: (C,) mm, where each begins; `y` likewise.
        step_x: (C,) mm, from there to its end; `step_y` likewise.
        length: (C,) mm.
    """

    def __init__(self, points: FloatArray, chord: IntArray, layer: IntArray) -> None:
        self._points, self.chord, self.layer = points, chord, layer
        (self.x, self.y), (to_x, to_y) = points.take(chord, axis=0).T, points.take(chord + 1, axis=0).T
        self.step_x, self.step_y = to_x - self.x, to_y - self.y
        self.length = np.sqrt(self.step_x * self.step_x + self.step_y * self.step_y)

    def selected(self, which: IntArray) -> _Lines:
        """The lines of the given numbers."""
        return _Lines(self._points, self.chord[which], self.layer[which])

    def pieces(self, longest: float) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
        """Cut the lines into pieces of at most `longest` mm.

        Returns:
            (P,) each: the line of a piece, the share of that line before it, x and y of the piece's middle.
        """
        count = np.maximum(np.ceil(self.length / longest), 1).astype(np.int64)
        of = np.repeat(np.arange(len(count)), count)
        number = ranges(0, count)
        pieces = count.take(of)
        middle = (number + 0.5) / pieces
        x, y = self.x.take(of) + middle * self.step_x.take(of), self.y.take(of) + middle * self.step_y.take(of)
        return of, number / pieces, x, y


def _one_each(length: FloatArray, group: IntArray) -> IntArray:
    """Pieces to test: the first of each group (P,), and after it the first in every further `_PIECE` mm."""
    begins = np.ones(len(length), dtype=bool)
    begins[1:] = group[1:] != group[:-1]
    way = np.cumsum(summable(length.copy()))
    way -= np.repeat(way[begins], np.diff(np.flatnonzero(np.append(begins, True))))
    window = (way / _PIECE).astype(np.int64)
    begins[1:] |= window[1:] != window[:-1]
    return np.flatnonzero(begins)


def _free(lines: _Lines, of: IntArray, middle: FloatArray, outlines: Shapes, reach: float) -> BoolArray:
    """(P,) pieces that hang free: `reach` mm to both sides of their middles (2, P), the outline below is not there."""
    free = np.ones(len(of), dtype=bool)
    used = np.bincount(lines.layer - 1) > 0
    layer = (np.cumsum(used) - 1).take(lines.layer - 1)
    below = shapely.force_2d(outlines[: len(used)][used])  # copies: prepared shapes must not be shared between threads
    shapely.prepare(below)
    aside = np.array([-lines.step_y, lines.step_x]) * (reach / np.maximum(lines.length, 1e-9))
    for side in (1.0, -1.0):
        rows = np.flatnonzero(free)
        line = of[rows]
        x, y = middle[:, rows] + side * aside[:, line]
        free[rows] = ~shapely.contains_xy(below[layer[line]], x, y)
    return free


def _long_parts(free: BoolArray, length: FloatArray, group: IntArray) -> BoolArray:
    """(P,) marks of pieces, with short gaps closed and then short stretches dropped."""
    for wanted in (False, True):
        begins = np.ones(len(free), dtype=bool)
        begins[1:] = (free[1:] != free[:-1]) | (group[1:] != group[:-1])
        first = np.flatnonzero(begins)
        short = (np.add.reduceat(length, first) < _SHORTEST) & (free[first] == wanted)
        if not wanted:  # a gap has parts of the same group on both sides
            own = group[first]
            short[1:-1] &= (own[:-2] == own[1:-1]) & (own[1:-1] == own[2:])
            short[[0, -1]] = False
        free = free ^ np.repeat(short, np.diff(np.append(first, len(free))))
    return free


def _cut(paths: OrderedPaths, chord: IntArray, share: FloatArray, free: BoolArray, flow: float) -> OrderedPaths:
    """Put points where marks change within a line, and give marked lines their flow.

    Args:
        paths: in printing order.
        chord: (P,) the point that each piece's line leaves.
        share: (P,) of that line before the piece.
        free: (P,) of the pieces.
        flow: factor on the widths of lines over air.
    """
    at = np.flatnonzero((share > 0) & (free != np.roll(free, 1)))
    marks = np.zeros(len(paths.points), dtype=bool)
    marks[chord[share == 0]] = free[share == 0]
    leaves = chord[at]
    near, far = paths.points[leaves], paths.points[leaves + 1]
    width, marks = _inserted(paths.width, leaves + 1, paths.width[leaves]), _inserted(marks, leaves + 1, free[at])
    if flow != 1.0:
        width[marks] *= flow
    return replace(
        paths,
        points=_inserted(paths.points, leaves + 1, near + share[at, None] * (far - near)),
        width=width,
        start=paths.start + np.searchsorted(leaves, paths.start),
        over_air=marks,
    )


def _inserted(column: NDArray[Scalar], place: IntArray, values: NDArray[Scalar]) -> NDArray[Scalar]:
    """(N + K, …) a column with values (K, …) inserted before rows (K,), which do not decrease.

    Where K is small, copying block by block is five times as fast as `numpy.insert`.
    """
    grown = np.empty((len(column) + len(place), *column.shape[1:]), dtype=column.dtype)
    begin = 0
    for number, end in enumerate([*place.tolist(), len(column)]):
        grown[begin + number : end + number] = column[begin:end]
        begin = end
    grown[place + np.arange(len(place))] = values
    return grown
