"""Where the cleaning tower stands: near the object, clear of everything, inside the reach of both nozzles."""

from __future__ import annotations

import numpy as np
import shapely

from ..errors import MeshError, SettingsError
from ..model import BoolArray, FloatArray
from ..settings import PrintSettings
from ..settings.printer import PrinterProfile

_COARSE_MM = 2.0
_FINE_MM = 0.25
_AT_ONCE = 25  # places that are tested at once, the best first
_SURE = 0.95  # share of a buffer's width that its polygonal arcs certainly cover
_ROUGH_MM = 0.5  # accuracy of the obstacles for ruling out places inside them
_TO_THE_REAR = 0.75  # share of the object's depth; more of it takes longer ways to many objects
_TOUCHING_MM = 0.5  # least distance of a tower that the user places


def placed(footprint: FloatArray, obstacles: shapely.Geometry, settings: PrintSettings) -> FloatArray:
    """Where to move the tower, and how far to turn it.

    Args:
        footprint: (N, 2) mm, points of the tower and its brim around the origin; their hull is kept free.
        obstacles: all that is printed elsewhere, seen from above, in mm.
        settings: the tower's placement.

    Returns:
        (3,) X and Y of its middle in mm, and the angle in degrees.

    Raises:
        MeshError: the bed has no room for it.
        SettingsError: it does not fit where the user wants it.
    """
    if settings.tower_placement == "manual":
        return _manual(footprint, obstacles, settings)
    angles = [settings.tower_rotation, settings.tower_rotation + 90.0]
    hulls = [_hull(turned(footprint, angle)) for angle in angles]
    shapely.prepare(obstacles)
    target = _target(obstacles)
    printer = settings.printer_profile
    low, high = _reach(printer)
    grid = [np.arange(low[axis], high[axis] + _COARSE_MM, _COARSE_MM) for axis in (0, 1)]
    places = np.stack(np.meshgrid(*grid, indexing="ij"), axis=-1).reshape(-1, 2)
    found = [_nearest_free(hull, places, target, obstacles, settings.tower_distance, printer) for hull in hulls]
    costs = [np.inf if place is None else _cost(place[None], target)[0] for place in found]
    best = int(np.argmin(costs))
    rough = found[best]
    if rough is None:
        raise MeshError(
            "the bed has no room for the cleaning tower beside the object",
            "make the object smaller, lower tower_distance or tower_brim_width, or set tower_type to none",
        )
    step = np.arange(-_COARSE_MM, _COARSE_MM + _FINE_MM / 2, _FINE_MM)
    around = rough + np.stack(np.meshgrid(step, step, indexing="ij"), axis=-1).reshape(-1, 2)
    fine = _nearest_free(hulls[best], around, target, obstacles, settings.tower_distance, printer)
    return np.array([*(rough if fine is None else fine), angles[best]])


def turned(points: FloatArray, angle_deg: float) -> FloatArray:
    """(N, 2) points turned counter-clockwise around the origin."""
    cosine, sine = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    return np.asarray(points @ np.array([[cosine, sine], [-sine, cosine]]))


def _manual(footprint: FloatArray, obstacles: shapely.Geometry, settings: PrintSettings) -> FloatArray:
    where = f"the cleaning tower at X {settings.tower_x:g}, Y {settings.tower_y:g}"
    hint = "change tower_x, tower_y or tower_rotation, or set tower_placement to auto"
    place = np.array([[settings.tower_x, settings.tower_y]])
    hull = _hull(turned(footprint, settings.tower_rotation))
    if not _inside(hull, place, settings.printer_profile)[0]:
        raise SettingsError(f"{where} leaves the reach of both nozzles", hint)
    if not _free(hull, place, obstacles, _TOUCHING_MM)[0]:
        raise SettingsError(f"{where} meets the object or what is printed around it", hint)
    return np.array([settings.tower_x, settings.tower_y, settings.tower_rotation])


def _hull(points: FloatArray) -> FloatArray:
    """(H, 2) corners of the convex hull of points (N, 2)."""
    return np.asarray(shapely.get_coordinates(shapely.convex_hull(shapely.multipoints(points)))[:-1])


def _target(obstacles: shapely.Geometry) -> FloatArray:
    """A place to the rear of the object's middle: seams are there, and the tower does not stand before the picture."""
    if obstacles.is_empty:
        return np.zeros(2)
    left, front, right, back = shapely.bounds(obstacles)
    return np.array([(left + right) / 2, front + _TO_THE_REAR * (back - front)])


def _reach(printer: PrinterProfile) -> tuple[FloatArray, FloatArray]:
    """(2,) mm each, the least and the greatest X and Y that both nozzles reach."""
    return np.array(printer.reach_min[:2]), np.array(printer.reach_max[:2])


def _cost(places: FloatArray, target: FloatArray) -> FloatArray:
    """Distance from the target, rounded so that all machines choose alike; of equal places the rightmost is best."""
    return np.asarray(np.round(np.hypot(*(places - target).T), 6) - 1e-9 * places[:, 0])


def _nearest_free(
    hull: FloatArray,
    places: FloatArray,
    target: FloatArray,
    obstacles: shapely.Geometry,
    distance: float,
    printer: PrinterProfile,
) -> FloatArray | None:
    """The place (2,) of places (P, 2) with the least `_cost` where the hull (H, 2) has room; None if there is none."""
    places = places[_inside(hull, places, printer)]
    # Where the middle stands so near that no turn would help, the hull need not be looked at.
    rough = shapely.simplify(obstacles, _ROUGH_MM)
    overlaps = shapely.buffer(rough, _SURE * (distance + _half_width(hull)) - _ROUGH_MM)
    shapely.prepare(overlaps)
    places = places[~shapely.contains_xy(overlaps, places)]
    places = places[np.argsort(_cost(places, target), kind="stable")]
    for first in range(0, len(places), _AT_ONCE):
        some = places[first : first + _AT_ONCE]
        free = _free(hull, some, obstacles, distance)
        if free.any():
            return np.asarray(some[np.argmax(free)])
    return None


def _half_width(hull: FloatArray) -> float:
    """Least distance of the hull's edge from the origin within it."""
    return float(shapely.distance(shapely.linearrings(hull), shapely.Point(0, 0)))


def _inside(hull: FloatArray, places: FloatArray, printer: PrinterProfile) -> BoolArray:
    """(P,) bool, places where the hull lies within the reach of both nozzles."""
    low, high = _reach(printer)
    inside = (places + hull.min(axis=0) >= low) & (places + hull.max(axis=0) <= high)
    return np.asarray(inside[:, 0] & inside[:, 1])


def _free(hull: FloatArray, places: FloatArray, obstacles: shapely.Geometry, distance: float) -> BoolArray:
    """(P,) bool, places where the hull keeps its distance from the obstacles."""
    if not len(places):
        return np.zeros(0, dtype=bool)
    return ~np.asarray(shapely.dwithin(obstacles, shapely.polygons(places[:, None] + hull), distance))
