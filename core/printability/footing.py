"""Whether the print stands firmly and sticks: slim objects on a small foot, and lines narrower than high."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from ..model import TriangleMesh
from ..settings import PrintSettings

_SLIM = 12.0  # times as high as the foot is wide
_BRIM = "set brim_width to 5 mm or raft_layers to 2"


def footing_warnings(
    mesh: TriangleMesh, names: Sequence[str], foot: shapely.Geometry, settings: PrintSettings
) -> list[str]:
    """Says which objects may fall over.

    Args:
        mesh: on the bed.
        names: of its objects.
        foot: (Multi)Polygon, the first layer's cross-section.
        settings: brim_width, raft_layers and support_enable are used.
    """
    if settings.brim_width > 0 or settings.raft_layers or settings.support_enable:
        return []
    found = []
    for number, name in enumerate(names):
        low, high = mesh.bounds_of(number)
        own = foot if len(names) == 1 else shapely.clip_by_rect(foot, *low[:2], *high[:2])
        width, height = _narrow_side(own), float(high[2] - low[2])
        if 0 < width < height / _SLIM:
            found.append(f"{name} is {height:.0f} mm high on a foot of {width:.1f} mm and may fall over: {_BRIM}")
    return found


def line_warnings(settings: PrintSettings) -> list[str]:
    """Says which lines are too narrow for their height."""
    lines = (
        ("extrusion_width", settings.extrusion_width, "layer_height", settings.layer_height),
        ("first_layer_extrusion_width", settings.first_layer_extrusion_width, "first_layer_height",
         settings.first_layer_height),
    )  # fmt: skip
    return [
        f"lines of {width:g} mm are narrower than high ({height:g} mm) and hardly stick: raise {wide} or lower {high}"
        for wide, width, high, height in lines
        if width < height
    ]


def _narrow_side(foot: shapely.Geometry) -> float:
    """Mm, the narrow side of the narrowest rectangle around a foot; 0 where nothing stands on the bed."""
    around = shapely.oriented_envelope(foot)
    if around.is_empty or shapely.get_dimensions(around) < 2:
        return 0.0
    sides = np.diff(shapely.get_coordinates(around)[:3], axis=0)
    return float(np.hypot(*sides.T).min())
