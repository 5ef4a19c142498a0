"""Solid colors: painted regions of pure black or white, printed in that filament alone (paper, section 7).

In layers of the other color the outline is either set back farther than for any tone, as far as the strand above can
protrude over it (`set_back`), or printed by the right tool (`tool_change`, see `toolpaths/tool_turns.py`). There are no
waves in the regions, so that their own strands meet in front of the set-back ones, or lie above one another.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..contours.contours import Contours
from ..contours.places import average_along_wall
from ..mesh.components import connected
from ..model import BoolArray, FloatArray, IntArray
from ..parallel import product
from ..ragged import preceding, starts
from ..records import dataclass
from ..sampling.projector import Projector
from ..settings import PrintSettings
from .modulation import faded, layer_is_black, supported

_MIXED, _BLACK, _WHITE = 0, 1, 2
_STEEPEST_DEG = 80.0  # the area of flatter places is counted as if they leaned by this


@dataclass(frozen=True)
class SolidRegions:
    """R regions on N contour points.

    Attributes:
        region: (N,) int64, -1 for points in none.
        is_black: (R,) bool, else white.
        area: (R,) mm² of the surface.
    """

    region: IntArray
    is_black: BoolArray
    area: FloatArray


def solid_regions(
    lines: Contours, tone: FloatArray, slant_deg: FloatArray, projector: Projector, settings: PrintSettings
) -> SolidRegions:
    """Find the connected regions of pure tone that are large enough.

    Points are connected along their contour, and to the point of the next layer onto which they project.

    Args:
        lines: N contour points.
        tone: (N,) asked for, 0 black to 1 white.
        slant_deg: (N,) of the surface.
        projector: made for the same contours.
        settings: solid_region_tolerance, solid_region_area and the layer height are used.
    """
    pure = settings.solid_region_tolerance
    kind = np.where(tone <= pure, _BLACK, np.where(tone >= 1.0 - pure, _WHITE, _MIXED))
    run = runs(kind, lines.start)
    painted = np.flatnonzero(kind != _MIXED)
    label = connected(int(run.max(initial=-1)) + 1, *_links(lines, kind, run, painted, projector))
    step = lines.step
    lean = np.radians(np.minimum(np.abs(slant_deg), _STEEPEST_DEG))
    owner = label[run[painted]]
    patch = step * settings.layer_height / np.cos(lean)
    area = np.asarray(np.bincount(owner, patch[painted], minlength=len(label)), dtype=np.float64)
    large = np.flatnonzero(area >= settings.solid_region_area)
    number = np.full(len(label) + 1, -1, dtype=np.int64)
    number[large] = np.arange(len(large))
    region = np.full(len(kind), -1, dtype=np.int64)
    region[painted] = number[owner]
    is_black = np.zeros(len(large), dtype=bool)
    inside = region >= 0
    is_black[region[inside]] = kind[inside] == _BLACK
    return SolidRegions(region, is_black, area[large])


def with_solid_regions(
    lines: Contours,
    depth: FloatArray,
    set_back: FloatArray,
    slant_deg: FloatArray,
    solid: SolidRegions,
    settings: PrintSettings,
    swapped: BoolArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Wave depth and set-back with no waves inside the regions and the other color's line set back.

    At the border of a region the transition takes half a wavelength, inside the region.

    Args:
        lines: N contour points.
        depth: (N,) mm, peak to peak.
        set_back: (N,) mm.
        slant_deg: (N,) of the surface.
        solid: the regions.
        settings: solid_set_back and the limits of overhangs are used.
        swapped: (N,) bool, points that the other tool prints and that are not set back, or None.
    """
    inside = solid.region >= 0
    share = np.clip(2 * average_along_wall(inside.astype(np.float64), lines, settings.wavelength) - 1, 0.0, 1.0)
    share = np.where(inside, share, 0.0)
    behind = _wrong_color(lines, solid, settings)
    if swapped is not None:
        behind &= ~swapped
    wanted = np.where(behind, settings.solid_set_back, 0.0)
    hidden = supported(depth * (1 - share), set_back + share * (wanted - set_back), slant_deg, settings)
    new_depth, new_set_back = faded(*hidden, lines.room_inside, lines.room_outside)
    return np.where(inside, new_depth, depth), np.where(inside, new_set_back, set_back)


def left_to_other_tool(lines: Contours, solid: SolidRegions, settings: PrintSettings) -> BoolArray:
    """(N,) bool, stretches of outline of the wrong color in the regions, none of them shorter than a wavelength.

    Shorter stretches, and shorter gaps between stretches, take the state of their longer neighbors.

    Args:
        lines: N contour points.
        solid: the regions.
        settings: the wavelength is used.
    """
    swapped = _wrong_color(lines, solid, settings)
    for kind in (False, True):
        run = runs(swapped.astype(np.int64), lines.start)
        length = np.bincount(run, lines.step)
        # A whole contour has no neighbors.
        whole = length[run] > 0.999 * lines.length[lines.loop]
        short = (swapped == kind) & (length[run] < settings.wavelength) & ~whole
        swapped ^= short
    return swapped


def _wrong_color(lines: Contours, solid: SolidRegions, settings: PrintSettings) -> BoolArray:
    """(N,) points in a region on layers of the other color."""
    inside = solid.region >= 0
    black_here = np.zeros(len(inside), dtype=bool)
    black_here[inside] = solid.is_black[solid.region[inside]]
    return np.asarray(inside & (layer_is_black(lines.layer[lines.loop], settings) != black_here))


def solid_report(
    lines: Contours,
    solid: SolidRegions,
    before: FloatArray,
    after: FloatArray,
    settings: PrintSettings,
    swapped: BoolArray | None = None,
) -> dict[str, Any]:
    """Number, area and cost of the regions, JSON-ready.

    The cost of tool changes within layers is known only with all moves: see `breakdown.swap_cost`.

    Args:
        lines: N contour points.
        solid: the regions.
        before: (N,) mm, depth of the waves without the regions.
        after: (N,) mm, with them.
        settings: as used.
        swapped: (N,) bool, points that the other tool prints, or None.
    """
    step = lines.step
    longer = product(step, _stretch(after, settings) - _stretch(before, settings))
    return {
        "regions": len(solid.area),
        "black_mm2": float(solid.area[solid.is_black].sum()),
        "white_mm2": float(solid.area[~solid.is_black].sum()),
        "outline_share": float(step[solid.region >= 0].sum() / max(step.sum(), 1e-12)),
        "outline_time_s": longer / settings.wave_speed,
        "other_tool_mm": 0.0 if swapped is None else float(step[swapped].sum()),
        "tool_changes": 0,
        "tool_changes_in_layers": 0,
        "tool_change_time_s": 0.0,
    }


def runs(kind: IntArray, start: IntArray) -> IntArray:
    """(N,) number of the run of equal kinds along its contour that each point belongs to, mixed runs included."""
    begins = kind != kind[preceding(start)]
    loop = np.repeat(np.arange(len(start) - 1), np.diff(start))
    even = np.bincount(loop, begins, minlength=len(start) - 1) == 0
    begins[start[:-1][even]] = True
    run = np.cumsum(begins) - 1
    # Points before the first beginning on a contour continue the run at its end.
    total = starts(begins)
    wrapped = run < total[start[:-1]][loop]
    return np.where(wrapped, run[start[1:] - 1][loop], run)


def _links(
    lines: Contours, kind: IntArray, run: IntArray, pure: IntArray, projector: Projector
) -> tuple[IntArray, IntArray]:
    """Pairs of runs of one color that lie above one another."""
    layer = lines.layer[lines.loop]
    pure = pure[layer[pure] < layer.max(initial=0)]
    place, gap = projector.project(lines.points[pure], layer[pure] + 1)
    found = np.isfinite(gap)
    low, high = pure[found], np.searchsorted(lines.arc, place[found], side="right") - 1
    alike = kind[low] == kind[high]
    pairs = np.unique(np.stack([run[low[alike]], run[high[alike]]]), axis=1)
    return pairs[0], pairs[1]


def _stretch(depth: FloatArray, settings: PrintSettings) -> FloatArray:
    """(N,) ratio of the path of a wave of mean length and that depth to the outline."""
    if settings.pattern == "offset":
        return np.ones_like(depth)
    depths = np.linspace(0.0, 3.0, 61)
    steepness = np.pi * depths / (settings.wavelength * np.sqrt(2))
    along = np.sin(np.linspace(0.0, 2 * np.pi, 64, endpoint=False))
    return np.interp(depth, depths, np.sqrt(1 + (steepness[:, None] * along) ** 2).mean(axis=1))
