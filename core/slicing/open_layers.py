"""Layers with outlines that do not close: refused where nothing could be printed, else told in warnings."""

from __future__ import annotations

import numpy as np

from ..errors import MeshError, counted
from ..model import IntArray
from .planes import Layers

_MOST_STRETCHES = 4
_HINT = "fill its holes (in Blender: Prepare > Repair) or raise gap_closing_radius"


def check_open(open_layers: IntArray, polygon_layer: IntArray, stack: Layers) -> None:
    """Refuse a mesh without closed outlines, or without any at the bottom, so that it would begin in the air.

    Args:
        open_layers: (K,) layers with an outline that does not close.
        polygon_layer: (I,) layer of each region that there is to print.
        stack: all layers.

    Raises:
        MeshError: the first layer is missing because its outlines do not close.
    """
    missing = np.setdiff1d(open_layers, polygon_layer)
    if not len(missing) or (missing[0] and len(polygon_layer)):
        return
    raise MeshError(f"the mesh is open: no outline closes {heights(_first_stretch(missing), stack)}", _HINT)


def open_warnings(open_layers: IntArray, polygon_layer: IntArray, stack: Layers) -> list[str]:
    """What is left out of a mesh that is open in places, and where the layers above have nothing to stand on."""
    if not len(open_layers):
        return []
    layers = counted(len(open_layers), "layer")
    warnings = [
        f"outlines that do not close are left out: in {layers} {heights(open_layers, stack)}; "
        "fill the holes of the mesh or raise gap_closing_radius"
    ]
    missing = np.setdiff1d(open_layers, polygon_layer)
    if len(missing):
        above = ", so what lies above begins in the air" if polygon_layer.max() > missing[0] else ""
        warnings.append(f"there is nothing else to print {heights(missing, stack)}{above}")
    return warnings


def heights(layers: IntArray, stack: Layers) -> str:
    """The stretches "from 1.00 to 1.50 and from 2.00 to 2.25 mm" of layers, increasing; of many from first to last."""
    begins = np.flatnonzero(np.diff(layers, prepend=-2) > 1)
    if len(begins) > _MOST_STRETCHES:
        begins = begins[:1]
    ends = np.append(begins[1:], len(layers)) - 1
    low, high = (stack.top - stack.height)[layers[begins]], stack.top[layers[ends]]
    return " and ".join(f"from {a:.2f} to {b:.2f}" for a, b in zip(low, high, strict=True)) + " mm"


def _first_stretch(layers: IntArray) -> IntArray:
    """The layers up to the first gap."""
    return layers[: 1 + int(np.argmax(np.append(np.diff(layers) > 1, True)))]
