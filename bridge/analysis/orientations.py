"""Suggested orientations kept with an object, in its own coordinates, and how it is turned by them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Vector

from ...core.analysis.orientation import Orientation, upright
from ..bed import bounds_mm
from ..kept import kept_json
from ..rig import move
from ..units import mm_per_unit

ORIENTATIONS_KEY = "dualcolor_orientations"


def keep_orientations(source: bpy.types.Object, found: Sequence[Orientation]) -> None:
    """Remember orientations, the best first, so that they hold however the object is turned later."""
    # A plane's direction goes the other way through a matrix than a point does.
    matrix = np.array(source.matrix_world)[:3, :3]
    kept = [one.as_dict() | {"own_up": (matrix.T @ one.up).tolist()} for one in found]
    source[ORIENTATIONS_KEY] = json.dumps(kept)


def orientations_of(source: bpy.types.Object) -> list[dict[str, Any]]:
    """The fields of `Orientation` of each; empty before the first suggestion."""
    return kept_json(source.get(ORIENTATIONS_KEY), [])


def turn(source: bpy.types.Object, number: int) -> float:
    """Turn an object into one of its orientations, about its middle; its lowest point stays at its height.

    What shapes it, such as its armature, is turned with it.

    Returns:
        By how many degrees.

    Raises:
        MeshError: what shapes it belongs to another file.
    """
    own_up = np.array(orientations_of(source)[number]["own_up"])
    up = np.linalg.solve(np.array(source.matrix_world)[:3, :3].T, own_up)
    rotation = upright(up / np.linalg.norm(up))
    unit = mm_per_unit(bpy.context.scene)
    before = bounds_mm([source]) / unit
    middle = Matrix.Translation(Vector(before.mean(axis=0)))
    move([source], middle @ Matrix(rotation.tolist()).to_4x4() @ middle.inverted())
    shift = before[0, 2] - bounds_mm([source])[0, 2] / unit
    move([source], Matrix.Translation((0.0, 0.0, shift)))
    return float(np.degrees(np.arccos(np.clip((np.trace(rotation) - 1) / 2, -1.0, 1.0))))
