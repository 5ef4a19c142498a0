"""The slicing stage: mesh → clean outlines and regions of every layer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import MeshError
from ..mesh import size_hint
from ..model import IntArray, TriangleMesh
from ..pattern.chunks import in_threads
from ..settings import PrintSettings
from .bands import linked_outlines
from .open_layers import check_open
from .outlines import Outlines, sums
from .overlaps import overlaps
from .planes import Layers, layer_stack
from .regions import boundary_loops, crossing_layers, layer_regions, region_polygons
from .union import united

# Loops smaller than this (mm²) come from vertices that touch a plane.
SMALLEST_AREA = 1e-3
# Points nearer to each other than this (mm) are one.
SHORTEST_SEGMENT = 1e-7


@dataclass(frozen=True)
class Slices:
    """All layers of the object.

    Attributes:
        layers: the stack of L layers.
        outlines: M loops, counter-clockwise around material, clockwise around holes.
        polygons: (I,) connected regions as shapely polygons.
        polygon_layer: (I,) layer of each.
        loop_polygon: (M,) the region that each loop bounds.
        regions: (L,) all of a layer's regions as one multipolygon.
        united_layers: how many layers had loops that cross and were united.
        specks: loops that were left out because a strand does not fit into them.
        overlaps: (K, 3) pairs of objects of the plate that have room in common, and in how many layers.
        open_layers: (K,) layers with an outline that does not close and was left out.
    """

    layers: Layers
    outlines: Outlines
    polygons: NDArray[np.object_]
    polygon_layer: IntArray
    loop_polygon: IntArray
    regions: NDArray[np.object_]
    united_layers: int
    specks: Outlines
    overlaps: IntArray
    open_layers: IntArray


def slices(mesh: TriangleMesh, settings: PrintSettings) -> Slices:
    """Slice the mesh at the middle of every layer.

    Raises:
        MeshError: the mesh is open at the bottom or everywhere, too low, or has no inside.
    """
    stack = layer_stack(float(mesh.vertices[:, 2].max()), settings)
    raw, open_layers = linked_outlines(mesh, stack.plane, settings.gap_closing_radius)
    # A strand as round as it gets is as long around as its width says.
    shortest = np.pi * settings.extrusion_width
    whole, specks = cleaned(raw, shortest)
    outlines, parent = _nested(whole)
    polygons, polygon_layer, loop_polygon = region_polygons(outlines, parent)
    crossing = crossing_layers(polygons, polygon_layer, len(stack))
    if crossing.any():
        # Nesting says nothing about loops that cross: go back to the loops as they were cut.
        outlines, parent = _nested(_united_where(whole, crossing, shortest))
        polygons, polygon_layer, loop_polygon = region_polygons(outlines, parent)
    if len(polygons) == 0 and len(open_layers) == 0:
        raise _nothing(mesh, specks, shortest, settings)
    check_open(open_layers, polygon_layer, stack)
    regions = layer_regions(polygons, polygon_layer, len(stack))
    shared, united_layers = overlaps(whole, mesh, len(stack)), int(crossing.sum())
    return Slices(
        stack, outlines, polygons, polygon_layer, loop_polygon, regions, united_layers, specks, shared, open_layers
    )


def _nothing(mesh: TriangleMesh, specks: Outlines, shortest: float, settings: PrintSettings) -> MeshError:
    """Why there is not a single outline."""
    hint = size_hint(mesh, settings)
    if len(specks.layer):
        text = f"no outline of the mesh is {shortest:.2f} mm long, as long as a strand is around"
        return MeshError(text, hint or "scale it up")
    volume = "give it a volume, for example with a Solidify modifier"
    return MeshError("the mesh has no inside to print", hint or volume)


def _nested(outlines: Outlines) -> tuple[Outlines, IntArray]:
    kept, _, parent = boundary_loops(outlines)
    return kept, parent


def _united_where(outlines: Outlines, crossing: NDArray[np.bool_], shortest: float) -> Outlines:
    bounds = np.searchsorted(outlines.layer, np.flatnonzero(crossing)[:, None] + [0, 1]).tolist()
    parts = in_threads(lambda loops: cleaned(united(outlines.between(*loops)), shortest)[0], bounds)
    return Outlines.joined([outlines.selected(~crossing[outlines.layer]), *parts])


def cleaned(outlines: Outlines, shortest: float) -> tuple[Outlines, Outlines]:
    """Without segments of no length, loops of no area and loops that are less than `shortest` mm long.

    Returns:
        The outlines, and the loops with an area that were too short.
    """
    along = outlines.ends - outlines.points
    shorter = outlines.without_points(np.hypot(along[:, 0], along[:, 1]) <= SHORTEST_SEGMENT)
    shorter = shorter.selected(shorter.count >= 3)
    shorter = shorter.selected(np.abs(shorter.signed_area) > SMALLEST_AREA)
    around = shorter.ends - shorter.points
    long_enough = sums(np.hypot(around[:, 0], around[:, 1]), shorter.start) >= shortest
    return shorter.selected(long_enough), shorter.selected(~long_enough)
