"""Moving an object together with what shapes its mesh from outside: its armature, lattice, hooks, cutters.

Cutters that are printed themselves too: a peg still fits the hole that it has cut, and the object looks as before.
"""

from __future__ import annotations

from collections.abc import Sequence

import bpy
from mathutils import Matrix

from ..core.errors import MeshError
from .node_inputs import input_objects

_ONLOOKERS = ("CAMERA", "LIGHT")
_SHEAR = 1e-4
"""Of single precision is what differs by less."""


def movers(*objects: bpy.types.Object) -> list[bpy.types.Object]:
    """What is to be moved so that some objects move as they look; only these if no modifier names another.

    A posed mesh that is scaled or turned without its armature is bent in other places. Children of others in the list
    are left out: they come along.
    """
    found = {obj.name: obj for obj in objects}
    for modifier in (modifier for obj in objects for modifier in obj.modifiers):
        named = [getattr(modifier, name) for name in _object_properties(modifier)]
        if modifier.type == "NODES":  # which may also name a camera, or objects of other files as mere shapes
            named += [other for other in input_objects(modifier) if other.is_editable and other.type not in _ONLOOKERS]
        found |= {other.name: other for other in named if other}
    return [each for each in found.values() if not any(above in found.values() for above in _parents(each))]


def move(objects: Sequence[bpy.types.Object], transform: Matrix) -> None:
    """Apply a transform of the world to objects and to what shapes them.

    Raises:
        MeshError: one of them belongs to another file; nothing has been moved.
    """
    moved = movers(*objects)
    for each in moved:
        if not each.is_editable:
            raise MeshError(f"{each.name} belongs to another file", "make it local first (Object > Relations)")
    for each in moved:
        _place(each, transform @ each.matrix_world)
    bpy.context.view_layer.update()


def _place(obj: bpy.types.Object, matrix: Matrix) -> None:
    """Give an object a matrix in the world.

    Below an unevenly scaled parent that may be a sheared one, which location, rotation and scale cannot say: then the
    parent's inverse, any matrix, takes up the change.
    """
    within = obj.matrix_world @ obj.matrix_basis.inverted_safe()  # of the parent, its inverse included
    basis = within.inverted_safe() @ matrix
    unsheared = Matrix.LocRotScale(*basis.decompose())
    off = max(abs(value) for row in basis - unsheared for value in row)
    if obj.parent and off > _SHEAR * max(abs(value) for row in basis for value in row):
        change = matrix @ obj.matrix_world.inverted_safe()
        obj.matrix_parent_inverse = obj.matrix_parent_inverse @ within.inverted_safe() @ change @ within
    else:
        obj.matrix_world = matrix


def _object_properties(modifier: bpy.types.Modifier) -> list[str]:
    declared = modifier.bl_rna.properties
    return [each.identifier for each in declared if each.type == "POINTER" and each.fixed_type.identifier == "Object"]


def _parents(obj: bpy.types.Object) -> list[bpy.types.Object]:
    above = []
    while obj := obj.parent:
        above.append(obj)
    return above
