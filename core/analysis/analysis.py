"""The analysis of a model: the job's stages up to the pattern, then seams, tracelines, slopes and orientations."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Any

import numpy as np

from ..contours.contours import Contours
from ..job.stages import Stages
from ..job.wall_stages import wall_stages
from ..mesh.triangles import triangulate
from ..model import BoolArray, FloatArray, SurfaceModel, TriangleMesh
from ..pattern.modulation import layer_is_black, shape, supported
from ..pattern.wave import modulated
from ..printability.slopes import FaceContrast, face_contrast, slope_report, slope_warnings
from ..progress import Progress, drained
from ..records import dataclass
from ..sampling.projector import Projector
from ..sampling.quality import SeamErrors
from ..sampling.samples import Samples
from ..sampling.visibility import at_arcs, visibility_warnings
from ..settings import PrintSettings
from ..slicing.planes import Layers
from ..texture.pyramid import build_pyramids
from .orientation import Orientation, suggested
from .tracelines import Tracelines, tracelines

NO_SEAMS = "the pattern offset has no waves, so there are no seams to show: choose another pattern to see its seams"
_LEAST_SWING_MM = 0.05


@dataclass(frozen=True)
class Analysis:
    """The findings of an analysis.

    Attributes:
        settings: as used.
        mesh: as sliced, on the bed.
        layers: of the print.
        lines: N contour points.
        samples: of the pattern; none for `offset`.
        errors: of the seams, None for `offset`.
        traced: tracelines, None for `offset`.
        faded: (N,) share of wave and set-back that was lost for lack of room.
        too_short: (M,) bool, contours that are too short for the pattern.
        paint: on the faces.
        orientations: the best one first.
        report: JSON-ready.
        warnings: one sentence each.
    """

    settings: PrintSettings
    mesh: TriangleMesh
    layers: Layers
    lines: Contours
    samples: Samples
    errors: SeamErrors | None
    traced: Tracelines | None
    faded: FloatArray
    too_short: BoolArray
    paint: FaceContrast
    orientations: list[Orientation]
    report: dict[str, Any]
    warnings: list[str]


def analyze(
    model: SurfaceModel, settings: PrintSettings, on_progress: Callable[[float, str], None] | None = None
) -> Analysis:
    """Analyze a model; `on_progress` is called with the share done and the name of what comes next.

    Raises:
        PrintError: the input cannot be printed.
    """
    return drained(analysis_steps(model, settings), lambda step: on_progress(*step) if on_progress else None)


def analysis_steps(model: SurfaceModel, settings: PrintSettings) -> Generator[Progress, None, Analysis]:
    """The analysis as a generator: yields (share done, what comes next), returns the findings.

    Raises:
        PrintError: the input cannot be printed.
    """
    with Stages(None) as stages:
        wall = yield from wall_stages(model, settings, stages)
        mesh, lines, samples = wall.mesh, wall.lines, wall.samples
        yield 0.6, "orientations"
        paint = wall.beside.paint.result()
        ranked = suggested(mesh, paint, settings)
    yield 0.8, "seam errors"
    waves = settings.pattern != "offset"
    errors = wall.beside.errors.result() if waves else None
    traced = (
        tracelines(samples, Projector(lines, settings.projection_threshold), settings.wavelength) if waves else None
    )
    too_short = (np.diff(samples.start) == 0) & waves
    yield 0.9, "room"
    faded = faded_share(lines, wall.tone, wall.slant, settings)
    slopes = slope_report(paint)
    report: dict[str, Any] = {
        "name": model.name,
        "layers": len(wall.cut.layers),
        "bounds_mm": mesh.bounds.tolist(),
        "settings": settings.as_dict(),
        "pattern": errors.shares(len(samples.arc), at_arcs(wall.visibility, lines, errors.arc)) if errors else None,
        "tracelines": traced.report() if traced else None,
        "faded": _faded_report(lines, faded),
        "too_short": {"outlines": int(too_short.sum()), "of": len(lines.layer)},
        "slopes": slopes,
        "orientations": [one.as_dict() for one in ranked],
    }
    warnings = [*([] if waves else [NO_SEAMS]), *slope_warnings(slopes), *visibility_warnings(mesh, settings)]
    report["warnings"] = warnings
    return Analysis(
        settings, mesh, wall.cut.layers, lines, samples, errors, traced, faded, too_short, paint, ranked, report,
        warnings,
    )  # fmt: skip


def orientations(model: SurfaceModel, settings: PrintSettings) -> list[Orientation]:
    """Ways to stand a model on the bed, the best one first, without the rest of the analysis.

    Raises:
        PrintError: the input cannot be printed.
    """
    mesh = triangulate(model, settings)
    pyramids = build_pyramids(mesh, model.textures, 2 * settings.layer_height, settings.texture_filter)
    return suggested(mesh, face_contrast(mesh, pyramids, settings), settings)


def faded_share(lines: Contours, tone: FloatArray, slant_deg: FloatArray, settings: PrintSettings) -> FloatArray:
    """(N,) how much of wave and set-back the guard against overlaps takes away, 0 to 1.

    Args:
        lines: N contour points.
        tone: (N,).
        slant_deg: (N,) of the surface.
        settings: those of the pattern are used.
    """
    layer = lines.layer[lines.loop]
    wanted, back = supported(*shape(tone, layer_is_black(layer, settings), settings), slant_deg, settings)
    depth, set_back = modulated(lines, tone, slant_deg, settings)
    swing = np.where(layer < settings.flat_layers, 0.0, wanted) + back
    lost = 1.0 - (depth + set_back) / np.maximum(swing, _LEAST_SWING_MM)
    return np.where(swing > _LEAST_SWING_MM, np.clip(lost, 0.0, 1.0), 0.0)


def _faded_report(lines: Contours, faded: FloatArray) -> dict[str, float]:
    step = lines.step
    total = max(float(step.sum()), 1e-12)
    return {
        "share": float(step[faded > 0.05].sum()) / total,
        "half_lost": float(step[faded > 0.5].sum()) / total,
    }
