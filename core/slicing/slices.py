"""The slicing stage: mesh → clean outlines and regions of every layer."""

from __future__ import annotations

import numpy as np
import shapely

from ..errors import MeshError
from ..mesh.size import size_hint
from ..model import BoolArray, IntArray, Shapes, TriangleMesh
from ..parallel import in_chunks, in_threads
from ..ragged import sums
from ..records import dataclass
from ..settings import PrintSettings
from .bands import linked_outlines
from .open_layers import check_open
from .outlines import Outlines
from .overlaps import overlaps
from .planes import Layers, layer_stack
from .regions import Regions, gathered, regions_of
from .uncross import uncrossed
from .union import united

# Loops smaller than this (mm²) come from vertices that touch a plane.
SMALLEST_AREA = 1e-3
# Points nearer to each other than this (mm) are one.
SHORTEST_SEGMENT = 1e-7
# Regions may differ from their outlines by this much, mm: far less than anything that is filled.
REGION_TOLERANCE = 0.01
_LAYERS_AT_ONCE = 32


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
    polygons: Shapes
    polygon_layer: IntArray
    loop_polygon: IntArray
    regions: Shapes
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
    whole, specks = cleaned(raw, shortest, in_place=True)
    del raw
    solid = regions_of(whole, REGION_TOLERANCE)
    regions = gathered(solid.polygons, solid.polygon_layer, len(stack))
    crossing = _crossing(regions)
    if crossing.any():
        # Nesting says nothing about loops that cross: go back to the loops as they were cut.
        mended, regions[crossing] = _mended(whole, crossing, shortest)
        solid = solid.with_layers_from(mended, crossing)
    if len(solid.polygons) == 0 and len(open_layers) == 0:
        raise _nothing(mesh, specks, shortest, settings)
    check_open(open_layers, solid.polygon_layer, stack)
    shared, united_layers = overlaps(whole, mesh, len(stack)), int(crossing.sum())
    return Slices(
        stack, solid.outlines, solid.polygons, solid.polygon_layer, solid.loop_polygon, regions, united_layers, specks,
        shared, open_layers,
    )  # fmt: skip


def _crossing(regions: Shapes) -> BoolArray:
    """(L,) which layers have loops that cross each other or themselves: their regions (L,) are not valid."""
    (valid,) = in_chunks(lambda some: (shapely.is_valid(some),), regions, rows=_LAYERS_AT_ONCE)
    return ~valid


def _nothing(mesh: TriangleMesh, specks: Outlines, shortest: float, settings: PrintSettings) -> MeshError:
    """Why there is not a single outline."""
    hint = size_hint(mesh, settings)
    if len(specks.layer):
        text = f"no outline of the mesh is {shortest:.2f} mm long, the perimeter of a strand"
        return MeshError(text, hint or "scale it up")
    volume = "give it a volume, for example with a Solidify modifier"
    return MeshError("the mesh has no inside to print", hint or volume)


def _mended(outlines: Outlines, crossing: BoolArray, shortest: float) -> tuple[Regions, Shapes]:
    """The regions of the layers that `crossing` (L,) marks, once their loops are united, and a multipolygon of each."""
    loops = outlines.selected(crossing[outlines.layer])
    apart, touching = uncrossed(loops)
    solid = regions_of(cleaned(apart, shortest)[0])
    regions = gathered(solid.polygons, solid.polygon_layer, len(crossing))
    still = _crossing(regions)
    still[touching] = True  # loops are nested by one point of each, which may be one where they touch
    if still.any():
        whole = regions_of(_united_where(loops, still, shortest))
        solid = solid.with_layers_from(whole, still)
        regions[still] = gathered(whole.polygons, whole.polygon_layer, len(crossing))[still]
    return solid, regions[crossing]


def _united_where(outlines: Outlines, crossing: BoolArray, shortest: float) -> Outlines:
    """The loops of the layers that `crossing` (L,) marks, united."""
    bounds = np.searchsorted(outlines.layer, np.flatnonzero(crossing)[:, None] + [0, 1]).tolist()
    return Outlines.joined(in_threads(lambda loops: cleaned(united(outlines.between(*loops)), shortest)[0], bounds))


def cleaned(outlines: Outlines, shortest: float, in_place: bool = False) -> tuple[Outlines, Outlines]:
    """Leave out segments without length, loops without area and loops shorter than `shortest` mm.

    With `in_place`, the arrays of the outlines are overwritten.

    Returns:
        The outlines, and the loops with an area that were too short.
    """
    along = outlines.ends
    along -= outlines.points
    along *= along
    length = np.add(along[:, 0], along[:, 1])
    del along
    np.sqrt(length, out=length)
    point = length > SHORTEST_SEGMENT
    loop = np.searchsorted(outlines.start, np.flatnonzero(~point), side="right") - 1
    count = outlines.count - np.bincount(loop, minlength=len(outlines.layer))
    short = sums(length, outlines.start) < shortest
    specks = outlines.reduced((count >= 3) & short, point, count)
    whole = outlines.reduced((count >= 3) & ~short, point, count, in_place)
    # Areas are asked for again where loops are nested, of those that are left.
    whole, specks = (part.selected(np.abs(part.signed_area) > SMALLEST_AREA) for part in (whole, specks))
    return whole, specks
