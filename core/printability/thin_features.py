"""Features too thin for a wall, which the print loses or makes too thick: where they are, how long and how large."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from ..contours.contours import LEAST_WIDTH, Contours
from ..errors import counted
from ..fill.offsets import offset, simplified
from ..mesh.components import connected
from ..model import FloatArray, IntArray
from ..records import dataclass
from ..settings import PrintSettings
from ..slicing.planes import line_widths
from ..slicing.slices import Slices

_SIMPLIFY_MM = 0.02
_SMALLEST = 0.5  # area in squares of the line width: the tips of sharp corners are no features
_CELL_MM = 4.0  # pieces nearer than this belong to one feature
_MOST_PLACES = 10
_NEIGHBORS = np.array([[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)])


@dataclass(frozen=True)
class ThinFeatures:
    """Pieces of layers too thin for a wall, K of them.

    Attributes:
        layer: (K,) int64.
        place: (K, 2) mm, the middle of each.
        area: (K,) mm².
        length: (K,) mm, half of the perimeter, which is about how long a thin piece is.
        feature: (K,) int64, which connected feature a piece belongs to.
    """

    layer: IntArray
    place: FloatArray
    area: FloatArray
    length: FloatArray
    feature: IntArray


def thin_features(cut: Slices, lines: Contours, settings: PrintSettings) -> ThinFeatures:
    """Find features thinner than two of the thinnest lines, and outlines that were left out for being too small.

    Args:
        cut: the slices.
        lines: contours of its outlines.
        settings: the extrusion widths are used.
    """
    widths = line_widths(lines.layer, settings)
    weak = lines.width <= LEAST_WIDTH * widths[lines.loop] * (1 + 1e-9)
    region = np.unique(lines.polygon[lines.loop[weak]])
    whole = simplified(cut.polygons[region], _SIMPLIFY_MM)
    reach = LEAST_WIDTH * line_widths(cut.polygon_layer[region], settings)
    holding = offset(offset(whole, -reach), reach * 1.05)
    parts, owner = shapely.get_parts(shapely.difference(whole, holding), return_index=True)
    large = shapely.area(parts) >= _SMALLEST * (2 * reach[owner]) ** 2
    parts, layer = parts[large], cut.polygon_layer[region][owner[large]]
    left_out = cut.specks.selected(cut.specks.signed_area > 0)
    if len(left_out.layer):
        specks = shapely.polygons(shapely.linearrings(left_out.points, indices=left_out.loop))
        parts, layer = np.concatenate([parts, specks]), np.concatenate([layer, left_out.layer])
    place = shapely.get_coordinates(shapely.centroid(parts))
    plane = cut.layers.plane[layer]
    return ThinFeatures(
        layer.astype(np.int64),
        place,
        shapely.area(parts),
        shapely.length(parts) / 2,
        _connected(np.column_stack([place, plane])),
    )


def thin_report(found: ThinFeatures, cut: Slices) -> dict[str, Any]:
    """JSON-ready: in how many layers, between which heights, how long, how large, and the largest of them one by one.

    Returns:
        Of all: `count` of features, `layers`, `z_from`, `z_to` above the object's bottom, `length_mm` summed over the
        layers, `area_mm2` likewise, and `places`, the same with `x` and `y` of the largest features.
    """
    top = cut.layers.top[found.layer]
    bottom = top - cut.layers.height[found.layer]

    def row(chosen: Any) -> dict[str, Any]:
        return {
            "layers": len(np.unique(found.layer[chosen])),
            "z_from": round(float(bottom[chosen].min()), 3),
            "z_to": round(float(top[chosen].max()), 3),
            "length_mm": round(float(found.length[chosen].sum()), 2),
            "area_mm2": round(float(found.area[chosen].sum()), 2),
        }

    if not len(found.layer):
        return {"count": 0, "layers": 0, "length_mm": 0.0, "area_mm2": 0.0, "places": []}
    size = np.bincount(found.feature, found.area)
    places = []
    for feature in np.argsort(-size, kind="stable")[:_MOST_PLACES]:
        chosen = found.feature == feature
        x, y = found.place[chosen].mean(axis=0).round(2).tolist()
        places.append({"x": x, "y": y, **row(chosen)})
    return {"count": len(size), **row(slice(None)), "places": places}


def thin_warnings(report: dict[str, Any], settings: PrintSettings) -> list[str]:
    """One sentence about features too thin for a wall, or none."""
    if not report["count"]:
        return []
    largest = report["places"][0]
    verb = "is" if report["count"] == 1 else "are"
    layers = counted(report["layers"], "layer")
    least = 2 * LEAST_WIDTH * settings.extrusion_width
    return [
        f"{counted(report['count'], 'feature')} {verb} thinner than {least:.2f} mm, too thin for a wall: "
        f"{report['length_mm']:.0f} mm in {layers} from {report['z_from']:.2f} to {report['z_to']:.2f} mm, the largest "
        f"at x {largest['x']:.1f}, y {largest['y']:.1f}, z {largest['z_from']:.2f} to {largest['z_to']:.2f} mm; "
        "thicken them, scale the object up or lower extrusion_width"
    ]


def _connected(points: FloatArray) -> IntArray:
    """(K,) number of the feature of each of (K, 3) points: those in the same cell or in touching ones are one."""
    if not len(points):
        return np.zeros(0, dtype=np.int64)
    cells, cell = np.unique(np.floor(points / _CELL_MM).astype(np.int64), axis=0, return_inverse=True)
    cells -= cells.min(axis=0) - 1
    size = cells.max(axis=0) + 2
    key = np.ravel_multi_index(cells.T, size)  # ascending, as `cells` is sorted
    beside = np.ravel_multi_index((cells[:, None] + _NEIGHBORS).reshape(-1, 3).T, size).reshape(len(cells), -1)
    at = np.minimum(np.searchsorted(key, beside), len(key) - 1)
    one, side = np.nonzero(key[at] == beside)
    return connected(len(cells), one, at[one, side])[cell]
