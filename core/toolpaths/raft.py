"""The raft: a grid and dense layers below the object that hold it on the bed and are torn off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely

from ..fill.paths import Hatching, hatch_paths
from ..model import FloatArray, IntArray
from ..paths import Feature, Paths
from ..settings import PrintSettings
from ..slicing.planes import Layers
from .loops import FirstIsland

_BASE_SPACING = 2.0  # of the lowest layer, in line widths: it gives way when it is torn off the bed
_SMOOTH_MM = 2.0


def raised(layers: Layers, settings: PrintSettings) -> Layers:
    """The stack with the raft below it: the object's layers keep their heights and come `raft_layers` later.

    The planes at which the object was cut are NaN on layers of the raft.
    """
    count = settings.raft_layers
    if not count:
        return layers
    height = np.full(count, settings.layer_height)
    height[0] = settings.first_layer_height
    top = np.cumsum(height)
    return Layers(
        np.concatenate([np.full(count, np.nan), layers.plane]),
        np.concatenate([top, layers.top + top[-1] + settings.raft_gap]),
        np.concatenate([height, layers.height]),
    )


def strand_heights(layer: IntArray, feature: IntArray, layers: Layers, settings: PrintSettings) -> FloatArray:
    """(K,) mm, how high the lines of paths are: as high as their layer, and as the air on the raft where they close it.

    The object is to come off the raft; tower and ooze shield stand on the bed and would break where there is air.

    Args:
        layer: (K,) of each path.
        feature: (K,) of each.
        layers: the stack, with the raft.
        settings: raft_layers and raft_gap are used.
    """
    height = layers.height[layer]
    if settings.raft_layers:
        stands = np.isin(feature, (Feature.TOWER, Feature.OOZE_SHIELD)) & (layer == settings.raft_layers)
        height = height + np.where(stands, settings.raft_gap, 0.0)
    return np.asarray(height)


def lifted(paths: Paths, settings: PrintSettings) -> Paths:
    """Paths of the object on the layers that they have above a raft."""
    return replace(paths, layer=paths.layer + settings.raft_layers) if settings.raft_layers else paths


def raft_area(first_layer: shapely.Geometry, settings: PrintSettings) -> shapely.Geometry:
    """The area of a raft below `first_layer`, in mm; gaps hardly wider than the margin are closed."""
    grown = shapely.buffer(first_layer, settings.raft_margin + _SMOOTH_MM)
    return shapely.buffer(grown, -_SMOOTH_MM)


def raft_paths(area: shapely.Geometry, settings: PrintSettings) -> Paths:
    """All layers of the raft: wide lines apart on the bed, on them lines side by side, each across those below.

    Args:
        area: that the raft covers, in mm.
        settings: raft_layers and the widths are used.

    Returns:
        Paths of feature `RAFT` on the layers below the object.
    """
    count = settings.raft_layers
    if not count or area.is_empty:
        return Paths.empty()
    layer = np.arange(count, dtype=np.int64)
    parts = []
    for chosen, width, spacing, feature in (
        (layer[:1], settings.first_layer_extrusion_width, _BASE_SPACING, Feature.INFILL),
        (layer[1:], settings.extrusion_width, 1.0, Feature.SKIN),
    ):
        hatching = Hatching(
            regions=np.full(len(chosen), shapely.buffer(area, -width / 2), dtype=object),
            island=np.arange(len(chosen), dtype=np.int64),
            feature=np.full(len(chosen), int(feature), dtype=np.int64),
            angle_deg=np.where(chosen % 2 == 0, 0.0, 90.0),
            spacing_mm=np.full(len(chosen), spacing * width),
            width_mm=np.full(len(chosen), width),
        )
        if len(chosen):
            parts.append(hatch_paths(hatching, chosen))
    lines = Paths.joined(parts)
    number = len(lines.layer)
    return replace(
        lines,
        feature=np.full(number, int(Feature.RAFT), dtype=np.int64),
        island=np.full(number, int(FirstIsland.RAFT), dtype=np.int64),
    )
