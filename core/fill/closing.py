"""Skins and bridges, which close the print above and below; they need no tones, so a second thread finds them."""

from __future__ import annotations

import numpy as np
import shapely

from ..model import FloatArray, IntArray, Shapes
from ..records import dataclass
from ..settings import PrintSettings
from ..slicing.planes import line_widths
from ..slicing.regions import gathered
from .bridges import Bridges, bridges
from .offsets import offset_outlines, simplified
from .skins import Skins, skins

_COVER_MM = 0.05  # outlines differ by this from the true ones, to see what covers what


@dataclass(frozen=True)
class Closing:
    """Skins of I islands, found before it is known how much room the outer wall leaves them.

    Attributes:
        inside: (I,) the region to fill, or somewhat more.
        outlines: (L,) cross-section of each layer, simplified as far as is harmless for telling what covers what.
        skins: where fill is to be solid.
    """

    inside: Shapes
    outlines: Shapes
    skins: Skins


def closing(polygons: Shapes, polygon_layer: IntArray, layers: int, settings: PrintSettings) -> Closing:
    """Skins behind an outer wall that no tone sets back.

    That is the most there can be to fill: the wall as it is printed leaves less, apart from slivers at bends and at
    waves that fade.

    Args:
        polygons: (I,) sliced regions.
        polygon_layer: (I,) layer of each, not decreasing.
        layers: L.
        settings: those of walls and fill, and of the waves' depth.
    """
    simple = simplified(polygons, _COVER_MM)
    width = line_widths(polygon_layer, settings)
    walls = (settings.perimeters + 1 - settings.infill_overlap / 100.0) * width
    inside = offset_outlines(simple, -(walls + _least_reach(polygon_layer, settings)))
    outlines = layer_outlines(simple, polygon_layer, layers)
    return Closing(inside, outlines, skins(inside, polygon_layer, outlines, settings))


def bridges_in(found: Closing, island_layer: IntArray, settings: PrintSettings) -> Bridges:
    """Which skins span air."""
    return bridges(found.inside, found.skins, found.outlines, island_layer, settings)


def layer_outlines(shapes: Shapes, layer: IntArray, layers: int) -> Shapes:
    """(L,) one shape for each layer, of the shapes on it, which may overlap since they were simplified."""
    parts, owner = shapely.get_parts(shapes, return_index=True)
    some = ~shapely.is_empty(parts)
    outlines = gathered(parts[some], layer[owner[some]], layers)
    several = np.flatnonzero(np.bincount(layer[owner[some]], minlength=layers) > 1)
    crossing = several[~shapely.is_valid(outlines[several])]
    outlines[crossing] = shapely.buffer(outlines[crossing], 0)
    return outlines


def _least_reach(layer: IntArray, settings: PrintSettings) -> FloatArray:
    """(I,) mm, how far inwards of its middle a fully attenuated wave reaches."""
    if settings.pattern == "offset":
        return np.zeros(len(layer))
    depth = min(settings.wave_depth_min, settings.wave_depth_max)
    return np.where(layer < settings.flat_layers, 0.0, depth / 2)
