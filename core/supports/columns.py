"""The columns that stand under the overhangs: straight down to the bed or to the object below."""

from __future__ import annotations

import numpy as np
import shapely

from ..fill.parallel import Shapes
from ..fill.walls import simplified
from .overlay import GRID_MM, SIMPLIFY_MM, areas, difference, gathered, intersection, nothing

_SLIVER_MM2 = 0.05


def columns(contact: Shapes, taken: Shapes) -> Shapes:
    """(L,) areas of support: under each contact straight down until the object is in the way.

    Columns that meet nothing are handed down untouched from layer to layer.

    Args:
        contact: (L,) what supports that end on each layer carry.
        taken: (L,) where the object leaves no room.
    """
    has_contact = ~shapely.is_empty(contact)
    parts = nothing(0)
    found: list[Shapes] = []
    for layer in range(len(contact) - 1, -1, -1):
        if has_contact[layer]:
            parts = _with(parts, contact[layer])
        if len(parts):
            parts = _without(parts, taken[layer])
        found.append(parts)
    found.reverse()
    owner = np.repeat(np.arange(len(found)), [len(parts) for parts in found])
    return gathered(np.concatenate([nothing(0), *found]), owner, len(found))


def _with(parts: Shapes, more: shapely.Geometry) -> Shapes:
    """(P,) polygons, those that meet another shape united with it."""
    meets = shapely.intersects(parts, more)
    whole = shapely.union_all(np.append(parts[meets], more), grid_size=GRID_MM)
    return np.concatenate([parts[~meets], shapely.get_parts(areas(whole))])


def _without(parts: Shapes, taken: shapely.Geometry) -> Shapes:
    """(P,) polygons less what is taken, without slivers."""
    shapely.prepare(taken)
    meets = shapely.intersects(taken, parts)
    if not meets.any():
        return parts
    left = shapely.get_parts(simplified(difference(parts[meets], taken), SIMPLIFY_MM))
    return np.concatenate([parts[~meets], left[shapely.area(left) > _SLIVER_MM2]])


def standing_on_bed(found: Shapes) -> Shapes:
    """(L,) only what reaches the bed: the part of each layer above the part below that does."""
    standing = found.copy()
    for layer in range(1, len(standing)):
        if standing[layer].is_empty:
            continue
        if standing[layer - 1].is_empty:
            standing[layer] = shapely.Polygon()
        else:
            standing[layer : layer + 1] = intersection(standing[layer : layer + 1], standing[layer - 1 : layer])
    return standing
