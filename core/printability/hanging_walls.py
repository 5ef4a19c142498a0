"""Walls far over air with no support below: how long they are, in which layers, and where the longest piece is."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import counted
from ..model import BoolArray, FloatArray, IntArray
from ..paths import Feature
from ..ragged import runs
from ..settings import PrintSettings
from ..slicing.planes import Layers
from ..toolpaths.order import OrderedPaths

_SHORTEST_MM = 5.0  # strands carry themselves over less
_LEANING = 3  # layers in which outer walls hang upon outer walls that hang
_DROP_MM = 0.5  # above the bed or the raft, which catches what hangs lower
_WORTH_TELLING_MM = 30.0  # of all together


def hanging_report(paths: OrderedPaths, layers: Layers, settings: PrintSettings) -> dict[str, Any]:
    """JSON-ready: the pieces of walls that hang over air for 5 mm or more with nothing that holds them.

    An outer wall alone is held by the wall beside it; where that hangs too, two lines beyond what carries, nothing
    holds them. So inner walls are looked at, and outer ones in a print without any; and in three layers or more one
    upon the other, since each then leans on one that has sunk already.

    Args:
        paths: in printing order, with the marks of what hangs.
        layers: the stack that they are printed in, raft included.
        settings: `raft_layers` and `perimeters` are read.

    Returns:
        `length_mm` of all pieces and the number of `layers` that have some; where there are any, also `z_from` and
        `z_to`, mm, the lowest and the highest underside of them, and `longest`: where it begins,
        `x`, `y` and `z`, and `length_mm`.
    """
    underside = layers.top - layers.height
    high = underside > underside[settings.raft_layers] + _DROP_MM
    chord, layer, length = _hanging(paths, Feature.OUTER_WALL, high)
    if settings.perimeters:
        leaning = _in_long_runs(np.bincount(layer, minlength=len(high)) > 0)
        held = leaning[layer]
        inner_chord, inner_layer, inner_length = _hanging(paths, Feature.INNER_WALL, high & ~leaning)
        chord = np.concatenate([chord[held], inner_chord])
        layer = np.concatenate([layer[held], inner_layer])
        length = np.concatenate([length[held], inner_length])
    if not len(length):
        return {"length_mm": 0.0, "layers": 0}
    z, longest = underside[layer], int(np.argmax(length))
    begin = paths.points[chord[longest]].round(2).tolist()
    where = dict(zip("xyz", [*begin, round(float(z[longest]), 3)], strict=True))
    return {
        "length_mm": round(float(length.sum()), 1),
        "layers": len(np.unique(layer)),
        "z_from": round(float(z.min()), 3),
        "z_to": round(float(z.max()), 3),
        "longest": where | {"length_mm": round(float(length[longest]), 1)},
    }


def _hanging(paths: OrderedPaths, feature: Feature, layers: BoolArray) -> tuple[IntArray, IntArray, FloatArray]:
    """Of each long piece of such walls that hangs in layers marked (L,): first line, layer, and mm, its length."""
    if paths.over_air is None:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros(0)
    asked = (paths.feature == feature) & layers[paths.layer]
    chord = np.flatnonzero(paths.over_air & np.repeat(asked, np.diff(paths.start)))
    path = np.searchsorted(paths.start, chord, side="right") - 1
    going_on = chord + 1 < paths.start[path + 1]  # no line leaves the last point of a path
    chord, path = chord[going_on], path[going_on]
    first, length = _pieces(paths, chord, path)
    long = np.flatnonzero(length >= _SHORTEST_MM)
    return chord[first[long]], paths.layer[path[first[long]]], length[long]


def _in_long_runs(layers: BoolArray) -> BoolArray:
    """(L,) the layers marked that have marked ones above or below them, `_LEANING` or more in all."""
    found = np.zeros_like(layers)
    for begin, end in runs(layers):
        found[begin:end] = end - begin >= _LEANING
    return found


def _pieces(paths: OrderedPaths, chord: IntArray, path: IntArray) -> tuple[IntArray, FloatArray]:
    """The first of the lines (C,) of each piece, and mm, its length; a piece across a loop's seam is one."""
    first = np.flatnonzero((np.diff(chord, prepend=-2) != 1) | (np.diff(path, prepend=-1) != 0))
    last, of = np.append(first[1:], len(chord)) - 1, path[first]
    length = np.add.reduceat(np.hypot(*(paths.points[chord + 1] - paths.points[chord]).T), first)
    begin, end = paths.start[of], paths.start[of + 1] - 1
    at_seam = np.flatnonzero((chord[first] == begin) & (paths.points[begin] == paths.points[end]).all(axis=1))
    before = np.searchsorted(of, of[at_seam], side="right") - 1  # the last piece of the same loop
    one = (chord[last[before]] + 1 == end[before]) & (before != at_seam)
    length[before[one]] += length[at_seam[one]]
    length[at_seam[one]] = 0.0
    return first, length


def hanging_warnings(report: dict[str, Any], settings: PrintSettings) -> list[str]:
    """One sentence about walls over air that nothing supports, or none."""
    if settings.support_enable or report["length_mm"] < _WORTH_TELLING_MM:
        return []
    longest = report["longest"]
    return [
        f"{report['length_mm']:.0f} mm of walls hang in the air in {counted(report['layers'], 'layer')}, the longest "
        f"piece of {longest['length_mm']:.0f} mm from x {longest['x']:.1f}, y {longest['y']:.1f}, "
        f"z {longest['z']:.2f} mm: set support_enable, or turn the object"
    ]
