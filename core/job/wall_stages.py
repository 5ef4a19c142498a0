"""The first half of the job: from the painted mesh to the waved outer wall of all layers."""

from __future__ import annotations

from collections.abc import Generator
from concurrent.futures import Future
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ..calibration.calibrate import ToneCurve, tone_curve
from ..contours.contours import Contours, contours, reach_of
from ..contours.places import average_along_wall
from ..contours.slant import slant_along
from ..fill.bridges import Bridges
from ..fill.closing import Closing, bridges_in, closing
from ..mesh.triangles import triangulate
from ..model import BoolArray, FloatArray, SurfaceModel, ToneImage, TriangleMesh
from ..pattern.solid_regions import left_to_other_tool, solid_regions, solid_report, with_solid_regions
from ..pattern.strand_edges import widened
from ..pattern.wave import WavedOutlines, modulated, waved
from ..printability.slopes import FaceContrast, face_contrast
from ..progress import Progress
from ..records import dataclass
from ..sampling.optimized import optimized_samples
from ..sampling.paper import paper_samples
from ..sampling.projector import Projector
from ..sampling.quality import SeamErrors, seam_errors
from ..sampling.samples import Samples
from ..sampling.visibility import seam_visibility
from ..settings import PrintSettings
from ..slicing.slices import Slices, slices
from ..texture.charts import uv_charts
from ..texture.island_levels import island_levels
from ..texture.lookup import tone_at
from ..texture.pyramid import TexturePyramids, build_pyramids, sizes_of
from ..toolpaths.overhangs import Undersides, undersides
from .changed_layers import LayerRows
from .repainted import other_layers, repainted_layers
from .stages import Stages

_NO_PICTURE = ToneImage(np.zeros((0, 0), dtype=np.float32), np.zeros((0, 0), dtype=np.float32))


@dataclass(frozen=True)
class WorkBeside:
    """Results that the second thread works out while the stages go on.

    Attributes:
        closing: skins of the fill.
        bridges: among these.
        errors: of the seams.
        paint: on the faces.
        undersides: of the mesh.
    """

    closing: Future[Closing]
    bridges: Future[Bridges]
    errors: Future[SeamErrors]
    paint: Future[FaceContrast]
    undersides: Future[Undersides | None]


@dataclass(frozen=True)
class PaintedWall:
    """The outer wall with the picture on it.

    Attributes:
        mesh: as sliced, on the bed.
        cut: its slices.
        lines: N contour points, a line's width inside the slices.
        samples: of the pattern; none for `offset`.
        visibility: (N,) of seams, None for alike everywhere.
        tone: (N,) that the pattern is asked for, calibrated.
        slant: (N,) degrees of the wall from upright.
        depth: (N,) mm of the waves.
        set_back: (N,) mm of the line.
        outlines: as printed.
        solid: the report's part on solid regions.
        notes: warnings of the calibration.
        beside: what no stage up to here has waited for.
    """

    mesh: TriangleMesh
    cut: Slices
    lines: Contours
    samples: Samples
    visibility: FloatArray | None
    tone: FloatArray
    slant: FloatArray
    depth: FloatArray
    set_back: FloatArray
    outlines: WavedOutlines
    solid: dict[str, Any]
    notes: list[str]
    beside: WorkBeside


def wall_stages(model: SurfaceModel, settings: PrintSettings, stages: Stages) -> Generator[Progress, None, PaintedWall]:
    """Slice, sample, look up the tones and modulate: yields before each stage, returns the wall.

    Raises:
        PrintError: the input cannot be printed.
    """
    run, aside = stages.run, stages.aside
    yield stages.begin(0.0, "mesh")
    mesh = run("mesh", triangulate, _without_pictures(model), settings)
    painting = _pyramids(mesh, model, settings, stages)
    yield stages.begin(0.05, "slicing")
    cut = run("slicing", slices, mesh, settings)
    layers = len(cut.layers)
    closes = aside("closing", closing, cut.polygons, cut.polygon_layer, layers, settings)
    spanned = aside("bridges", bridges_in, closes, cut.polygon_layer, settings)
    yield stages.begin(0.2, "contours")
    lines = run("contours", contours, cut.outlines, cut.loop_polygon, settings, reach_of(settings))
    yield stages.begin(0.3, "sampling")
    projector = run("projector", Projector, lines, settings.projection_threshold)
    early = run("early tone", pattern_tone, lines, painting.result(), settings) if settings.hide_seams else None
    shown = model.textures if mesh.face_visibility_texture is not None else ()
    seen = run("visibility", seam_visibility, lines, cut.layers.plane, mesh, shown, early, settings)
    samples = run("sampling", pattern_samples, projector, settings, seen)
    yield stages.begin(0.4, "texture")
    errors = aside("seam errors", seam_errors, samples, projector)
    paint = aside("slopes", face_contrast, mesh, painting, settings)
    hanging = aside("undersides", undersides, mesh, cut.layers.plane, settings)
    beside = WorkBeside(closes, spanned, errors, paint, hanging)
    yield stages.begin(0.45, "tone")
    rows = LayerRows(lines, cut.polygon_layer)
    tone = _tone(rows, layers, mesh, model, painting, settings, stages) if early is None else early
    del painting  # as large as the moves that are to come
    yield stages.begin(0.5, "modulation")
    slant = run("slant", _slant, lines, mesh, settings.wavelength)
    curve, notes = run("tone curve", tone_curve, tone, settings)
    by_rows = partial(stages.run_rows, rows)
    printed = by_rows("calibration", _printed_tones, (tone,), slant, curve)
    depth, set_back = by_rows("modulation", _depth_and_set_back, (printed,), lines, slant, settings)
    depth, set_back, swapped, solid = _solid_colors(lines, tone, slant, depth, set_back, projector, settings)
    columns = (tone, depth, set_back)
    stages.compare_layers("walls", (lines, samples), columns, partial(other_layers, columns, lines, layers))
    of_wave = (lines, samples, tone, depth, set_back)
    outlines = by_rows("wave", waved, of_wave, settings, swapped)
    return PaintedWall(
        mesh, cut, lines, samples, seen, printed, slant, depth, set_back, outlines, solid, notes, beside,
    )  # fmt: skip


def pattern_samples(projector: Projector, settings: PrintSettings, visibility: FloatArray | None = None) -> Samples:
    """The samples at which the waves sit, by the scheme that `sampling` sets; none for `offset`.

    Args:
        projector: made for the contours, N points.
        settings: those of the pattern are used.
        visibility: (N,) 0 to 1, how much a seam is seen there; None is alike everywhere.
    """
    if settings.pattern == "offset":
        return Samples.on(projector.lines, np.zeros(0))
    if settings.sampling == "paper":
        return paper_samples(projector, settings)
    return optimized_samples(projector, settings, visibility)


def painted_tone(pyramids: TexturePyramids, lines: Contours, settings: PrintSettings) -> FloatArray:
    """(N,) tone of the pictures at every contour point."""
    vertex_tone = lines.carried[:, 2] if lines.carried.shape[1] > 2 else None
    return tone_at(pyramids, lines.face, lines.carried[:, :2], vertex_tone, settings.background_tone)


def pattern_tone(lines: Contours, pyramids: TexturePyramids, settings: PrintSettings) -> FloatArray:
    """(N,) tone at every contour point, no finer than the pattern can show."""
    return _averaged(painted_tone(pyramids, lines, settings), lines, settings)


def _pyramids(
    mesh: TriangleMesh, model: SurfaceModel, settings: PrintSettings, stages: Stages
) -> Future[TexturePyramids]:
    """Those of the pictures, built beside the stages."""
    charts = stages.aside("charts", uv_charts, mesh, sizes_of(model.textures))
    islands = stages.aside("islands", island_levels, charts, settings.texture_filter)
    known = settings.texture_filter, charts, islands
    return stages.aside("texture", build_pyramids, mesh, model.textures, 2 * settings.layer_height, *known)


def _tone(
    rows: LayerRows,
    layers: int,
    mesh: TriangleMesh,
    model: SurfaceModel,
    painting: Future[TexturePyramids],
    settings: PrintSettings,
    stages: Stages,
) -> FloatArray:
    """As `pattern_tone`, run again only on layers where the pictures have changed."""
    same = mesh, rows.lines, settings.layer_height, settings.texture_filter
    repainted = partial(repainted_layers, model.textures, painting, rows.lines, layers)
    stages.compare_layers("pictures", same, model.textures, repainted)
    painted = stages.run_rows(rows, "tone", painted_tone, (painting.result(),), rows.lines, settings)
    return stages.run("average", _averaged, painted, rows.lines, settings)


def _averaged(tone: FloatArray, lines: Contours, settings: PrintSettings) -> FloatArray:
    """(N,) tones averaged along the wall, as far as the pattern cannot show more."""
    if settings.pattern == "offset" or settings.texture_filter == "lanczos":
        return tone
    # The look-up has averaged over a layer pair in all directions; a wave cannot show more than one tone along it, but
    # where it fades as the line is set back, the line can.
    share = 1.0 if settings.pattern == "wave" else 0.5
    return average_along_wall(tone, lines, settings.wavelength * share)


def _printed_tones(tone: FloatArray, slant_deg: FloatArray, curve: ToneCurve | None) -> FloatArray:
    """(N,) tones to print for those asked for (N,)."""
    return tone if curve is None else curve.printed(tone, slant_deg)


def _depth_and_set_back(
    printed: FloatArray, lines: Contours, slant_deg: FloatArray, settings: PrintSettings
) -> tuple[FloatArray, FloatArray]:
    """(N,) depth of the waves and (N,) set-back, mm, by the tones to print (N,)."""
    depth, set_back = modulated(lines, printed, slant_deg, settings)
    return depth, widened(lines, printed, set_back, settings)


def _solid_colors(
    lines: Contours,
    tone: FloatArray,
    slant_deg: FloatArray,
    depth: FloatArray,
    set_back: FloatArray,
    projector: Projector,
    settings: PrintSettings,
) -> tuple[FloatArray, FloatArray, BoolArray | None, dict[str, Any]]:
    """Depth and set-back with regions of pure black and white as it is set, what the other tool prints, the report."""
    if settings.solid_regions == "none":
        return depth, set_back, None, {}
    solid = solid_regions(lines, tone, slant_deg, projector, settings)
    swapped = left_to_other_tool(lines, solid, settings) if settings.solid_regions == "tool_change" else None
    without = depth
    depth, set_back = with_solid_regions(lines, depth, set_back, slant_deg, solid, settings, swapped)
    report = solid_report(lines, solid, without, depth, settings, swapped)
    return depth, set_back, swapped, {"solid_regions": report}


def _slant(lines: Contours, mesh: TriangleMesh, wavelength: float) -> FloatArray:
    return average_along_wall(slant_along(lines, mesh), lines, wavelength)


def _without_pictures(model: SurfaceModel) -> SurfaceModel:
    """The model with empty pictures, so that stages that do not read them are kept when they change."""
    return replace(model, textures=(_NO_PICTURE,) * len(model.textures), notes=())
