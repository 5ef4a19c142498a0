"""Metaballs: several objects whose names differ by a number only have one surface together."""

from __future__ import annotations

import bpy


def metaball_of(obj: bpy.types.Object, scene: bpy.types.Scene) -> bpy.types.Object:
    """The object that has the surface of a metaball: that with the lowest number in its name; any other object itself.

    A name without a number counts as number 0, as in Blender's `BKE_mball_basis_find`.
    """
    if obj.type != "META":
        return obj
    stem = _split(obj.name)[0]
    family = [each for each in scene.objects if each.type == "META" and _split(each.name)[0] == stem]
    return min(family, key=lambda each: _split(each.name)[1], default=obj)


def _split(name: str) -> tuple[str, int]:
    stem, _, number = name.rpartition(".")
    return (stem, int(number)) if stem and number.isdecimal() else (name, 0)
