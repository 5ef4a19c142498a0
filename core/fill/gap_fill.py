"""Gap fill: single lines along the middle of places too narrow for another wall, as between two waved walls."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from itertools import pairwise

import numpy as np
import shapely

from ..model import BoolArray, FloatArray, IntArray, Shapes
from ..parallel import begun, even_runs
from ..paths import Feature, Paths, way_ahead
from ..ragged import starts
from ..settings import PrintSettings
from ..slicing.pieces_outside import boundaries, pieces_outside
from ..slicing.regions import gathered
from .chordal_axis import ON_EDGE_MM, SIMPLIFY_MM, middles
from .mitres import Moved
from .offsets import offset, offset_outlines

# Line widths by which a line in a gap reaches into waves beside it, which leave pockets there.
_INTO_WAVES = 0.4
_LEAST = 0.25  # line widths: narrower gaps between straight walls stay, less than half of the narrowest line
_SMALLEST_MM2 = 0.1
_LOST = 0.5  # line widths of length that walls lose for other reasons
_NEAR = 2.0  # line widths: what is left out nearer to the inner line would be a gap too short for a line of its own
_CORNER = 0.1  # line widths: corners of walls are no gaps
_SHORTEST, _LONGEST = 1.0, 5.0  # line widths, of a line in a gap and of its pieces, each with a width of its own
_NARROWEST, _WIDEST = 0.5, 2.0  # line widths
_WIDEST_FILL = 1.05  # line widths, on average: what is wider is filled by lines across
_LEAST_AROUND = 8.0  # line widths around what is filled by one line: smaller places would get none
_MOST_MORE = 1.15  # times what lines hold by their width: the rest is branches that got none


def margins(settings: PrintSettings) -> tuple[float, ...]:
    """How far gaps reach into the walls on both sides, in line widths: one number for each of the arrays of gaps.

    Those are the gaps between each wall and the next one, and those inside the last. Below 0, gaps keep off the walls
    by so much: ones that are too narrow are then not found, and lines in the others are made as much wider again.
    """
    waved = _INTO_WAVES if settings.wave_crest > 0 else -_LEAST / 2
    return tuple(-_LEAST / 2 if number else waved for number in range(settings.perimeters + 1))


def gaps_between(
    walls: list[Shapes], steps: list[Moved], straight: Shapes, width_mm: FloatArray, settings: PrintSettings
) -> list[Shapes]:
    """The gaps between each wall and the next one inside, where that could not follow.

    Args:
        walls: (I,) regions bounded by a wall's center line, from the waved outer wall in.
        steps: how each wall but the first came from the one before.
        straight: (I,) where the outer wall has no wave beside others that do, see `outer_wall.straight_parts`.
        width_mm: (I,) of the lines.
        settings: tell whether the outer wall has waves.

    Returns:
        For each wall but the last, (I,) MultiPolygon, mostly empty; see `margins`.
    """
    found = [
        _gaps(outer, inner, step, width_mm, margin)
        for (outer, inner), step, margin in zip(pairwise(walls), steps, margins(settings)[:-1], strict=True)
    ]
    if found:
        _keep_off(found[0], straight, width_mm)
    return found


def _keep_off(gaps: Shapes, straight: Shapes, width_mm: FloatArray) -> None:
    """Take away, in place, what of gaps beside waves (I,) lies under lines without a wave."""
    rows = np.flatnonzero(~shapely.is_empty(gaps) & ~shapely.is_empty(straight))
    covered = shapely.buffer(shapely.line_merge(straight[rows]), width_mm[rows] / 2, cap_style="flat", quad_segs=2)
    parts, owner = shapely.get_parts(shapely.difference(gaps[rows], covered), return_index=True)
    large = 2 * shapely.area(parts) > _LEAST * width_mm[rows[owner]] * shapely.length(parts)
    large &= (shapely.area(parts) > _SMALLEST_MM2) & (shapely.get_dimensions(parts) == 2)
    gaps[rows] = gathered(parts[large], owner[large], len(rows))


def _gaps(outer: Shapes, inner: Shapes, step: Moved, width_mm: FloatArray, margin: float) -> Shapes:
    """(I,) what lies between the strands of two walls; arguments as of `gaps_between`, `margin` as of `margins`."""
    found = np.full(len(outer), shapely.Polygon(), dtype=object)
    rows = np.flatnonzero(_strays(inner, step, width_mm, _lose_length(outer, inner, width_mm)))
    width = width_mm[rows]
    reach = (0.5 - margin) * width
    # Strands end round, so what a wall takes at a sharp corner is round too.
    walls = shapely.buffer(inner[rows], (1 + _CORNER) * width - reach, quad_segs=2)
    parts, owner = shapely.get_parts(shapely.difference(offset_outlines(outer[rows], -reach), walls), return_index=True)
    large = (shapely.area(parts) > _SMALLEST_MM2) & (shapely.get_dimensions(parts) == 2)
    found[rows] = gathered(parts[large], owner[large], len(rows))
    return found


def narrow_fill(fill: Shapes, straight: Shapes, width_mm: FloatArray, settings: PrintSettings) -> tuple[Shapes, Shapes]:
    """Split off the parts inside the last wall that take one line along their middle; hatching would overfill them.

    Args:
        fill: (I,) regions to fill, which reach into the wall by the overlap.
        straight: (I,) as for `gaps_between`; it matters where that wall is the outer one.
        width_mm: (I,) of the lines.
        settings: tell whether anything is filled, and how far the regions reach.

    Returns:
        (I,) MultiPolygon as of `gaps_between`, mostly empty, and (I,) what is left to be filled by lines side by side.
    """
    found = np.full(len(fill), shapely.Polygon(), dtype=object)
    if settings.is_hollow:
        return found, fill
    overlap = settings.infill_overlap / 100.0
    parts, owner = shapely.get_parts(fill, return_index=True)
    width, around = width_mm[owner], shapely.length(parts)
    narrow = (2 * shapely.area(parts) < (_WIDEST_FILL + 2 * overlap) * width * around) & (
        around > _LEAST_AROUND * width
    )
    tried = np.flatnonzero(narrow)
    widest = (_WIDEST + 2 * overlap) * width[tried]
    narrow[tried] = shapely.is_empty(shapely.buffer(parts[tried], -widest / 2, quad_segs=1))
    rows = np.unique(owner[narrow])
    if not len(rows):
        return found, fill
    left, kept = fill.copy(), ~narrow & np.isin(owner, rows)
    left[rows] = gathered(parts[kept], owner[kept], len(fill))[rows]
    moved_by = (margins(settings)[-1] - overlap) * width[narrow]
    gaps, of = shapely.get_parts(offset(parts[narrow], moved_by), return_index=True)
    some = ~shapely.is_empty(gaps)
    found[rows] = gathered(gaps[some], owner[narrow][of[some]], len(fill))[rows]
    if not settings.perimeters:
        found[rows] = shapely.buffer(found[rows], 0.0)  # parts that were grown may overlap
        _keep_off(found, straight, width_mm)
    return found, left


def _strays(inner: Shapes, step: Moved, width_mm: FloatArray, some: BoolArray) -> BoolArray:
    """(I,) bool, where a place of the outer wall may lie too far from the inner one, among `some` (I,).

    Where every edge of the outline could be moved, only the corners of edges that were dropped need to be looked at.
    Outlines that GEOS had to offset nearly always have such a place.
    """
    asked = (some & step.sound)[step.owner]
    corners, owner = step.left_out[asked], step.owner[asked]
    far = ~shapely.dwithin(shapely.points(corners), inner[owner], _NEAR * width_mm[owner])
    return np.asarray(some & (~step.sound | (np.bincount(owner, far, len(inner)) > 0)))


def _lose_length(outer: Shapes, inner: Shapes, width_mm: FloatArray) -> BoolArray:
    """(I,) bool, where the inner wall is so much shorter than the outer one that there may be a gap.

    A closed line that is offset inwards by a width gets 2π widths shorter; a gap costs twice its own length more.
    Offsets take the most time here, and this test saves half of them. Regions with holes are not tested, as the walls
    around holes get longer.
    """
    lost = shapely.length(outer) - shapely.length(inner) - 2 * np.pi * width_mm
    plain = (shapely.get_type_id(outer) == shapely.GeometryType.POLYGON) & (shapely.get_num_interior_rings(outer) == 0)
    return np.asarray((~plain | (lost > _LOST * width_mm)) & ~shapely.is_empty(outer))


def gap_paths(
    found: Sequence[Shapes], margin: tuple[float, ...], island_layer: IntArray, width_mm: FloatArray
) -> AbstractContextManager[Callable[[], list[Paths]]]:
    """Lines along the middle of gaps, as wide as the gaps are; other threads begin with them, see `parallel.begun`.

    The middle is the chordal axis: it runs from side to side through the Delaunay triangles between points along the
    boundary, through the middles of the sides that cross the gap.

    Args:
        found: arrays (I,) of gaps.
        margin: of each array, line widths, see `margins`.
        island_layer: (I,) layer of each island.
        width_mm: (I,) of the lines that gaps are measured by.

    Returns:
        What gives SKIN polylines.
    """
    parts, owner = shapely.get_parts(np.concatenate(found), return_index=True)
    some = ~shapely.is_empty(parts)
    number, island = np.divmod(owner[some].astype(np.int64), len(island_layer))
    gaps, kept_off = parts[some], 2.0 * np.maximum(-np.array(margin), 0.0)[number]

    def lines_in(own: slice) -> Paths:
        return _lines_in(gaps[own], island[own], kept_off[own], island_layer, width_mm)

    return begun(lines_in, even_runs(shapely.get_num_coordinates(gaps)))


def _lines_in(
    parts: Shapes, island: IntArray, kept_off: FloatArray, island_layer: IntArray, width_mm: FloatArray
) -> Paths:
    """The lines of some gaps: P Polygons, the island of each, and by how many widths it keeps off its walls."""
    merged, edges = middles(parts, width_mm[island])
    lines, part = shapely.get_parts(merged, return_index=True)
    width = width_mm[island[part]]
    long = (shapely.length(lines) >= _SHORTEST * width) & (shapely.get_dimensions(lines) == 1)
    if not long.any():
        return Paths.empty()
    lines, part, width = shapely.segmentize(lines[long], _LONGEST * width[long]), part[long], width[long]
    points, line = shapely.get_coordinates(lines, return_index=True)
    # A width holds for the line that leaves its point: at its middle, as ends are near the gap's own ends.
    after = points.copy()
    going_on = np.flatnonzero(line[1:] == line[:-1])
    after[going_on] = points[going_on + 1]
    half = shapely.distance(shapely.points((points + after) / 2), edges[part[line]])
    points, across, line = _to_the_ends(points, 2 * half, line, parts, part)
    across *= _beside_the_middle(points, across, line, parts, part)[part[line]]
    across += (kept_off[part] * width)[line]
    start, island = starts(np.bincount(line, minlength=len(lines))), island[part]
    across = np.clip(across, _NARROWEST * width[line], _WIDEST * width[line])
    return Paths.alike(
        points, start, island_layer[island], feature=Feature.SKIN, island=island, closed=False, width=across
    )


def _beside_the_middle(
    points: FloatArray, across: FloatArray, line: IntArray, gaps: Shapes, gap: IntArray
) -> FloatArray:
    """(P,) how many times as much as its lines a gap holds: those are simplified, and as wide as the nearer side asks.

    Args:
        points: (N, 2) mm.
        across: (N,) mm, width of the line that leaves each point.
        line: (N,) the line of each point.
        gaps: (P,) Polygon.
        gap: (L,) the gap of each line.
    """
    way = way_ahead(points, np.flatnonzero(line[1:] != line[:-1]))
    laid = np.bincount(gap[line], way * across, len(gaps))
    return np.asarray(np.clip(shapely.area(gaps) / np.maximum(laid, _SMALLEST_MM2), 1.0, _MOST_MORE))


def _to_the_ends(
    points: FloatArray, wide: FloatArray, line: IntArray, gaps: Shapes, gap: IntArray
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Lengthen lines straight on to the ends of their gaps, since the axis only runs where a gap has two sides.

    Args:
        points: (N, 2) mm.
        wide: (N,) mm.
        line: (N,) the line of each point.
        gaps: (P,) Polygon.
        gap: (L,) the gap of each line.
    """
    first = np.flatnonzero(np.diff(line, prepend=-1))
    last = np.append(first[1:], len(line)) - 1
    # Last points come first: where one is put in at the place of the next line's first one, it has to stand before it.
    ends, before = np.concatenate([last, first]), np.concatenate([last - 1, first + 1])
    where = np.concatenate([last + 1, first])
    place = np.column_stack([gap[line[ends]], np.round(points[ends] / ON_EDGE_MM)])
    _, place, count = np.unique(place, axis=0, return_inverse=True, return_counts=True)
    free = count[place.ravel()] == 1  # no fork
    ends, before, where = ends[free], before[free], where[free]
    away = points[ends] - points[before]
    away *= (2 * wide[ends] / np.maximum(np.hypot(*away.T), ON_EDGE_MM))[:, None]
    outside = pieces_outside(points[ends], points[ends] + away, boundaries(gaps), gap[line[ends]])
    share = np.ones(len(ends))
    np.minimum.at(share, outside.line, outside.share[:, 0])
    longer = share * np.hypot(*away.T) > SIMPLIFY_MM
    tips = points[ends] + away * share[:, None]
    ends, where = ends[longer], where[longer]
    return (
        np.insert(points, where, tips[longer], axis=0),
        np.insert(wide, where, wide[ends]),
        np.insert(line, where, line[ends]),
    )
