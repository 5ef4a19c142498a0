"""The columns that stand under the overhangs: straight down to the bed or to the object below."""

from __future__ import annotations

import numpy as np
import shapely

from ..fill.offsets import offset, simplified
from ..model import Shapes
from ..slicing.regions import gathered
from .grid_overlay import SIMPLIFY_MM, difference, intersection, nothing
from .overhangs import Contacts

# Gaps and bays narrower than twice this, mm, are filled.
_HALF_GAP_MM = 0.5
_SLIVER_MM2 = 0.05


def columns(needed: Contacts, taken: Shapes) -> Shapes:
    """(L,) areas of support: from each contact straight down, until the object is in the way.

    Columns that meet nothing are handed down untouched from layer to layer.

    Args:
        needed: what the supports carry.
        taken: (L,) where the object leaves no room.
    """
    has_contact = np.flatnonzero(~shapely.is_empty(needed.area))
    # Close to a slope the air above a support takes part of it; a little deeper that part has room.
    above = np.searchsorted(has_contact, np.arange(len(taken))[:, None] + [0, needed.slant + 1])
    contact = needed.area[has_contact]
    parts = nothing(0)
    found: list[Shapes] = []
    for layer in range(len(taken) - 1, -1, -1):
        first, end = above[layer]
        if first < end:
            parts = _with(parts, contact[first:end])
        if len(parts):
            parts = _without(parts, taken[layer])
        found.append(parts)
    found.reverse()
    owner = np.repeat(np.arange(len(found)), [len(parts) for parts in found])
    return gathered(np.concatenate([nothing(0), *found]), owner, len(found))


def _with(parts: Shapes, added: Shapes) -> Shapes:
    """(P,) polygons, those that meet others (A,) united with them, without narrow gaps and bays."""
    near = shapely.dwithin(parts[:, None], added, _HALF_GAP_MM).any(axis=1)
    # What overlaps is one as soon as it is grown.
    whole = shapely.multipolygons(shapely.get_parts(np.append(parts[near], added)))
    smooth = offset(simplified(offset(np.array([whole]), _HALF_GAP_MM), SIMPLIFY_MM), -_HALF_GAP_MM)
    return np.concatenate([parts[~near], _sizeable(smooth)])


def _without(parts: Shapes, taken: shapely.Geometry) -> Shapes:
    """(P,) polygons less what is taken."""
    shapely.prepare(taken)
    meets = shapely.intersects(taken, parts)
    if not meets.any():
        return parts
    left = simplified(difference(parts[meets], taken), SIMPLIFY_MM)
    return np.concatenate([parts[~meets], _sizeable(left)])


def _sizeable(shapes: Shapes) -> Shapes:
    """(P,) polygons that shapes consist of, without slivers."""
    parts = shapely.get_parts(shapes)
    large: Shapes = parts[shapely.area(parts) > _SLIVER_MM2]
    return large


def standing_on_bed(found: Shapes) -> Shapes:
    """(L,) the parts of columns that reach the bed: on each layer what lies above such a part of the layer below."""
    standing = found.copy()
    for layer in range(1, len(standing)):
        parts, below = shapely.get_parts(standing[layer]), standing[layer - 1]
        shapely.prepare(below)
        held = shapely.covers(below, parts)
        if not held.all():
            left = intersection(parts[~held], below)
            standing[layer] = shapely.multipolygons(np.concatenate([parts[held], _sizeable(left)]))
    return standing
