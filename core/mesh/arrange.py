"""Objects side by side on the bed: close together, clear of each other, inside the reach of both nozzles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from ..errors import MeshError
from ..model import FloatArray, Shapes
from ..settings import PrintSettings

_GRID_MM = 2.0  # step of the places that are tried
_CHUNK = 500  # places tested at once
_LEAST_MARGIN_MM = 0.1  # around each object


def arranged(points: Sequence[FloatArray], names: Sequence[str], settings: PrintSettings) -> FloatArray:
    """(O, 3) mm by which to move each object so that all stand on the bed, close together, clear of each other.

    The largest object comes first, and each other one takes the free place nearest to it. If that leaves one without
    room, all are put in rows.

    Args:
        points: (V, 3) mm of each object.
        names: of the objects, for messages.
        settings: `arrange_distance` and the widths of brim, raft and shield are used.

    Raises:
        MeshError: the bed has no room for all.
    """
    hulls = [shapely.convex_hull(shapely.multipoints(each[:, :2])) for each in points]
    covered = shapely.buffer(hulls, _around(settings))
    printer = settings.printer_profile
    size = np.subtract(printer.reach_max, printer.reach_min)[:2]
    x, y = (np.arange(-side, side + _GRID_MM / 2, _GRID_MM) for side in size)
    places = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    around = places[np.argsort(np.hypot(*(places / size).T).round(9), kind="stable")]
    in_rows = places[np.lexsort(places.T)]
    found, left_out = _packed(covered, around, size, settings.arrange_distance)
    if left_out is not None:
        found, left_out = _packed(covered, in_rows, size, settings.arrange_distance)
    if left_out is not None:
        raise MeshError(
            f"the bed has no room for {names[left_out]} beside the other objects",
            "print fewer objects at once, make them smaller or lower arrange_distance",
        )
    lowest = np.array([each[:, 2].min() for each in points])
    return np.column_stack([found, -lowest])


def _packed(covered: Shapes, places: FloatArray, size: FloatArray, distance: float) -> tuple[FloatArray, int | None]:
    """(O, 2) mm by which to move each outline; and the first one that has no room, None if all have.

    Args:
        covered: (O,) convex outlines, the largest of which is put first.
        places: (Q, 2) mm, for the middles, the best one first.
        size: (2,) mm that all together may take.
        distance: mm between two of them.
    """
    bounds = shapely.bounds(covered)
    middle, half = (bounds[:, 2:] + bounds[:, :2]) / 2, (bounds[:, 2:] - bounds[:, :2]) / 2
    moved = np.zeros((len(covered), 2))
    taken: list[shapely.Geometry] = []
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for number in np.argsort(-shapely.area(covered), kind="stable").tolist():
        spread = np.maximum(high, places + half[number]) - np.minimum(low, places - half[number])
        fitting = places[(spread <= size).all(axis=1)]
        outline = shapely.get_coordinates(covered[number]) - middle[number]
        free = _first_free(outline, fitting, shapely.union_all(taken), distance)
        if free is None:
            return moved, number
        moved[number] = free - middle[number]
        taken.append(shapely.polygons(outline + free))
        low, high = np.minimum(low, free - half[number]), np.maximum(high, free + half[number])
    return moved - (low + high) / 2, None


def _first_free(
    outline: FloatArray, places: FloatArray, obstacles: shapely.Geometry, distance: float
) -> FloatArray | None:
    """The first of the places (Q, 2) where the outline (H, 2) keeps its distance; None if there is none."""
    shapely.prepare(obstacles)
    for chunk in np.array_split(places, range(_CHUNK, len(places), _CHUNK)):
        free = ~shapely.dwithin(obstacles, shapely.polygons(chunk[:, None] + outline), distance)
        if free.any():
            place: FloatArray = chunk[np.argmax(free)]
            return place
    return None


def _around(settings: PrintSettings) -> float:
    """Width around each object, mm: the crests of its waves, a margin, and the widest of brim, raft and shield."""
    shield = settings.ooze_shield_distance + settings.extrusion_width if settings.ooze_shield else 0.0
    raft = settings.raft_margin if settings.raft_layers else 0.0
    return settings.wave_crest + _LEAST_MARGIN_MM + max(settings.brim_width, raft, shield)
