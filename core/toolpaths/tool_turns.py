"""Which tool prints each path, and in which order the tools take their turns within a layer.

Layers alternate between the colors, so a layer's tool is known by its number. Where parts of the outer wall are left
to the other tool (`solid_regions = tool_change`), a layer is printed by both: first by the tool that ended the layer
below, then, after the only tool change, by the other one. So the change from layer to layer moves into the layer, and a
print has as many changes as before, or one more. What primes a nozzle, the tower, goes to the tool that a layer ends
with.
"""

from __future__ import annotations

import numpy as np

from ..model import BoolArray, IntArray
from ..paths import Feature, Paths
from ..pattern.modulation import layer_is_black
from ..settings import PrintSettings


def tool_of_layer(layer: IntArray, settings: PrintSettings) -> IntArray:
    """Tool of each layer: that of the object's layer, and of its first one on the raft, which needs no tool change."""
    own = np.maximum(layer - settings.raft_layers, 0)
    is_black = layer_is_black(own, settings)
    return np.where(is_black, settings.black_tool, 1 - settings.black_tool).astype(np.int64)


def tool_of_paths(layer: IntArray, swapped: BoolArray | None, settings: PrintSettings) -> IntArray:
    """(K,) tool of each path.

    Args:
        layer: (K,) of each.
        swapped: (K,) bool, see `Paths`.
        settings: of the print.
    """
    own = tool_of_layer(layer, settings)
    return own if swapped is None else np.where(swapped, 1 - own, own)


def tool_turns(paths: Paths, settings: PrintSettings) -> tuple[BoolArray | None, IntArray]:
    """Assign the tower to a tool, and each path to before or after the tool change of its layer.

    Args:
        paths: K, of all layers, in no order.
        settings: of the print.

    Returns:
        (K,) bool, what the other tool than its layer's prints, with the tower; None where no path is. And (K,) 0 for
        the first tool of a layer, 1 for the second.
    """
    if paths.swapped is None:
        return None, np.zeros(len(paths.layer), dtype=np.int64)
    is_tower = paths.feature == Feature.TOWER
    tool = tool_of_paths(paths.layer, paths.swapped, settings)
    layers = np.arange(paths.layer.max(initial=-1) + 1)
    used = np.zeros((len(layers), 2), dtype=bool)
    used[paths.layer[~is_tower], tool[~is_tower]] = True
    first, last = _ends(used, tool_of_layer(layers, settings))
    tool = np.where(is_tower, last[paths.layer], tool)
    swapped = tool != tool_of_layer(paths.layer, settings)
    return swapped, (tool != first[paths.layer]).astype(np.int64)


def _ends(used: BoolArray, own: IntArray) -> tuple[IntArray, IntArray]:
    """(L,) the tools that each layer begins and ends with.

    Args:
        used: (L, 2) bool, tools that a layer needs.
        own: (L,) tool of a layer that needs none, and with which a print begins that needs both everywhere.
    """
    first, last = own.copy(), own.copy()
    single = np.flatnonzero(used[:, 0] != used[:, 1])
    # A print that begins with layers of both tools begins so that they lead up to the first layer of one.
    before = int(used[single[0], 1] + single[0]) % 2 if len(single) else int(own[0])
    for layer, (zero, one) in enumerate(used.tolist()):
        if zero and one:
            first[layer], last[layer] = before, 1 - before
        elif zero or one:
            first[layer] = last[layer] = int(one)
        before = int(last[layer])
    return first, last
