"""The nearest place on the contours of a layer: the projection that carries samples upwards (paper, section 3.2)."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..contours.contours import Contours
from ..contours.grid import PointGrid, nearest
from ..contours.places import on_loop
from ..model import FloatArray, IntArray
from ..parallel import in_chunks
from ..ragged import ahead, preceding, ranges

ComplexArray = NDArray[np.complex128]

# A nearest place is looked for by going along the contour: how often, and by how many segments at most.
WALKS, FARTHEST = 2, 4.0
# Where the way to the nearest place is longer than this, mm, the contour is not taken for straight.
FAR = 0.05
# One in this many points of the contours is among those in which the search for an image begins.
SPARSE = 6


def as_complex(points: FloatArray) -> ComplexArray:
    """Points (N, 2) as complex numbers (N,)."""
    if points.flags.c_contiguous:
        return points.view(np.complex128)[:, 0]
    number = np.empty(len(points), dtype=np.complex128)
    number.real, number.imag = points.T
    return number


def squared(number: ComplexArray) -> FloatArray:
    """Squared magnitudes."""
    return np.asarray(number.real**2 + number.imag**2)


def dot(one: ComplexArray, other: ComplexArray) -> FloatArray:
    """Scalar products of vectors in the plane."""
    return np.asarray(one.real * other.real + one.imag * other.imag)


class Projector:
    """Finds nearest places on the contours of a layer within a threshold; its tables are made when first needed."""

    def __init__(self, lines: Contours, threshold: float) -> None:
        """Search on all layers of `lines`; `threshold` in mm."""
        self.lines = lines
        self.threshold = threshold

    @cached_property
    def loop(self) -> IntArray:
        """(N,) the contour of each point."""
        return self.lines.loop

    @cached_property
    def grid(self) -> PointGrid:
        """The points of the contours."""
        return self._grid(np.arange(len(self.loop)), 1, 2)

    @cached_property
    def sparse(self) -> PointGrid:
        """One in `SPARSE` of them."""
        many = -(-np.diff(self.lines.start) // SPARSE)
        first = np.repeat(self.lines.start[:-1], many)
        return self._grid(first + SPARSE * ranges(0, many), SPARSE, 1)

    def _grid(self, point: IntArray, every: int, rings: int) -> PointGrid:
        """Some of the points, one in `every`, in cells of which at most `rings` rings have to be looked through."""
        step = self.lines.length / np.maximum(np.diff(self.lines.start), 1)
        # A place lies at most half a step from a point, so that the search has to go that much farther.
        reach = self.threshold + float(step.max(initial=0.0)) * every / 2
        layer = self.lines.layer[self.loop[point]]
        return PointGrid(self.lines.points[point], layer, reach / rings, table=False, name=point)

    @cached_property
    def spot(self) -> ComplexArray:
        """(N,) the points as complex numbers, in which numpy is quicker than in rows of two."""
        return as_complex(self.lines.points)

    @cached_property
    def along(self) -> ComplexArray:
        """(N,) mm from each point to the next, as complex numbers."""
        along = ahead(self.spot, self.lines.start)
        along -= self.spot
        return along

    @cached_property
    def behind(self) -> IntArray:
        """(N,) the point before each one."""
        return preceding(self.lines.start)

    def at(self, arc: FloatArray) -> FloatArray:
        """(Q, 2) mm, the points at places (Q,) on the contours."""
        before = np.searchsorted(self.lines.arc, arc, side="right") - 1
        along = self.along.take(before)
        length = np.maximum(np.sqrt(squared(along)), 1e-9)
        along *= np.minimum((arc - self.lines.arc.take(before)) / length, 1.0)
        return (self.spot.take(before) + along).view(np.float64).reshape(-1, 2)

    def project(self, query: FloatArray, layer: IntArray) -> tuple[FloatArray, FloatArray]:
        """Nearest place on the contours of `layer` (Q,) for each query point (Q, 2).

        Returns:
            (Q,) arc and (Q,) distance in mm, infinite where nothing lies within the threshold.
        """
        arc, distance = in_chunks(self._project, query, layer)
        return arc, distance

    def above(self, query: FloatArray, layer: IntArray) -> FloatArray:
        """(Q,) arcs of the images of points (Q, 2) of layers (Q,) on the next ones; NaN where none is near enough.

        They are looked for along the contour from the nearest of every few points: where two walls are about equally
        near it may be either.
        """
        (image,) = in_chunks(self._above, query, layer, threads=False)
        return image

    def _above(self, query: FloatArray, layer: IntArray) -> tuple[FloatArray]:
        image = np.full(len(query), np.nan)
        point, asked = self._nearest_points(query, layer + 1, self.sparse, 1)
        arc, distance = self._walked(as_complex(query)[asked], point)
        image[asked] = np.where(distance <= self.threshold, arc, np.nan)
        return (image,)

    def _project(self, query: FloatArray, layer: IntArray) -> tuple[FloatArray, FloatArray]:
        point, asked = self._nearest_points(query, layer, self.grid, 2)
        arc, distance = np.zeros(len(query)), np.full(len(query), np.inf)
        if len(asked):
            # The nearest place is on one of the two segments that meet in the nearest point.
            spot, before = as_complex(query).take(asked), self.behind.take(point)
            place, square = self._on_segments(spot, point)
            other, other_square = self._on_segments(spot, before)
            arc[asked] = np.where(other_square < square, other, place)
            distance[asked] = np.sqrt(np.minimum(other_square, square))
        distance[distance > self.threshold] = np.inf
        return arc, distance

    def nearby(self, query: ComplexArray, guess: FloatArray, loop: IntArray) -> tuple[FloatArray, FloatArray]:
        """The nearest place to each query point (Q,), found by going along contours (Q,) from a guessed one (Q,).

        Returns:
            (Q,) arc and (Q,) distance in mm.
        """
        arc, distance = in_chunks(self._nearby, query, guess, loop, threads=False)
        return arc, distance

    def _nearby(self, query: ComplexArray, guess: FloatArray, loop: IntArray) -> tuple[FloatArray, FloatArray]:
        lines = self.lines
        first, end = lines.start.take(loop), lines.start.take(loop + 1)
        # Points lie about evenly along a contour, and more so along a part of it.
        density, point = (end - first) / lines.length.take(loop), first
        for _ in range(2):
            onward = np.floor((guess - lines.arc.take(point)) * density).astype(np.int64)
            point = np.minimum(np.maximum(point + onward, first), end - 1)
        return self._walked(query, point)

    def beside(self, query: ComplexArray, place: FloatArray, point: IntArray) -> tuple[FloatArray, FloatArray]:
        """How far the nearest place to each query point (Q,) lies beyond one near it, mm, and how far away it is.

        Args:
            query: (Q,) points.
            place: (Q,) arcs of places near them.
            point: (Q,) contour points near these. The contour is taken for straight there unless the way is long.

        Returns:
            (Q,) mm along the contour and (Q,) mm to the query point.
        """
        along, away = self.along.take(point, mode="clip"), query - self.spot.take(point, mode="clip")
        square = np.maximum(squared(along), 1e-18)
        way = dot(away, along)
        distance = np.sqrt(np.maximum(squared(away) - way * way / square, 0.0))
        way /= np.sqrt(square)
        way -= place
        way += self.lines.arc.take(point, mode="clip")
        far = np.flatnonzero(np.abs(way) > FAR)
        exact, distance[far] = self._walked(query[far], point[far])
        exact -= place[far]
        length = self.lines.length[self.loop[point[far]]]
        way[far] = exact - length * np.rint(exact / length)
        return way, distance

    def _walked(self, spot: ComplexArray, point: IntArray) -> tuple[FloatArray, FloatArray]:
        """As `nearby`, from contour points (Q,) on."""
        on, asked = np.arange(len(point)), spot
        for _ in range(WALKS):
            here = point.take(on)
            along = self.along.take(here)
            way = dot(asked - self.spot.take(here), along) / np.maximum(squared(along), 1e-18)
            np.minimum(np.maximum(way, -FARTHEST, out=way), FARTHEST, out=way)
            step = np.floor(way, out=way).astype(np.int64)
            moved = np.flatnonzero(step)
            if not len(moved):
                break
            on = on.take(moved)
            here, asked = here.take(moved), asked.take(moved)
            loop = self.loop.take(here)
            first, many = self.lines.start.take(loop), np.diff(self.lines.start).take(loop)
            here += step.take(moved)
            here -= first
            here %= many
            here += first
            point[on] = here
        arc, square = self._on_segments(spot, point)
        return arc, np.sqrt(square)

    def _nearest_points(
        self, query: FloatArray, layer: IntArray, grid: PointGrid, rings: int
    ) -> tuple[IntArray, IntArray]:
        """The nearest contour point of queries that have any within reach, and which queries these are."""
        point, square = self._least(query, layer, grid, 1)
        # What is nearer than a cell is certain; the others have to look one cell farther.
        again = np.flatnonzero(square > grid.cell**2)
        if len(again) and rings > 1:
            point[again], square[again] = self._least(query[again], layer[again], grid, 2)
        asked = np.flatnonzero(np.isfinite(square))
        return point[asked], asked

    def _least(self, query: FloatArray, layer: IntArray, grid: PointGrid, rings: int) -> tuple[IntArray, FloatArray]:
        """Nearest of the candidates and its squared distance; infinite where there is none."""
        found, group = grid.candidates(query, layer, rings)
        least = np.full(len(query), np.inf)
        if len(found) == 0:
            return np.zeros(len(query), dtype=np.int64), least
        distance = squared(self.spot.take(found) - np.repeat(as_complex(query), np.diff(group)))
        where, filled = nearest(distance, group)
        least[filled] = distance[where[filled]]
        return found[where], least

    def _on_segments(self, query: ComplexArray, first: IntArray) -> tuple[FloatArray, FloatArray]:
        """Arcs of the nearest places on the segments that begin at points (Q,), and their squared distances."""
        away, along = query - self.spot.take(first), self.along.take(first)
        square = np.maximum(squared(along), 1e-18)
        share = np.clip(dot(away, along) / square, 0.0, 1.0)
        arc = on_loop(self.lines.arc.take(first) + share * np.sqrt(square), self.loop.take(first), self.lines.arc_start)
        along *= share
        away -= along
        return arc, squared(away)
