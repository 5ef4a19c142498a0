"""The report of a job, and its warnings, which say what to do."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..contours.contours import Contours
from ..gcode.standby import standby_warnings
from ..mesh.plate import object_rows, plate_warnings
from ..mesh.size import size_warnings
from ..model import FloatArray, SurfaceModel, TriangleMesh
from ..paths import Feature
from ..printability.footing import footing_warnings, line_warnings
from ..printability.hanging_walls import hanging_report, hanging_warnings
from ..printability.slopes import slope_warnings
from ..printability.thin_features import thin_report, thin_warnings
from ..sampling.samples import Samples
from ..sampling.visibility import at_arcs, visibility_warnings
from ..settings import PrintSettings
from ..slicing.open_layers import open_warnings
from ..slicing.planes import line_widths
from ..slicing.slices import Slices
from ..statistics.breakdown import filament_report, swap_cost, time_report
from ..statistics.single_color import single_color_seconds
from ..toolpaths.layer_time import layer_time_warnings
from ..toolpaths.moves import Moves
from ..toolpaths.raft import raised
from ..toolpaths.skirt import skirt_warnings
from .path_stages import PrintedPaths, moves_without_swaps
from .wall_stages import PaintedWall


def findings(
    model: SurfaceModel,
    wall: PaintedWall,
    paths: PrintedPaths,
    moves: Moves,
    seconds: FloatArray,
    settings: PrintSettings,
) -> dict[str, Any]:
    """The report, JSON-ready, with the findings that did not stop the job under `warnings`, one sentence each.

    Args:
        model: as given.
        wall: of the first half of the job.
        paths: of the second one.
        moves: the `stretches` of its moves.
        seconds: (S,) s that these take.
        settings: as used.
    """
    cut = wall.cut
    errors, slopes = wall.beside.errors.result(), paths.slopes.result()
    thin = thin_report(paths.thin.result(), cut)
    hanging = hanging_report(paths.ordered, raised(cut.layers, settings), settings)
    plain = single_color_seconds(paths.single_color.result(), moves, seconds, settings)
    report = _overview(model, wall.mesh, cut, moves, settings) | {
        "gcode": {"bytes": 0, "moves": len(paths.moves.tool)},
        "time_s": time_report(moves, settings, plain, seconds),
        "filament": filament_report(moves, settings),
        **_solid(wall, paths, moves, seconds, settings),
        "pattern": errors.shares(len(wall.samples.arc), at_arcs(wall.visibility, wall.lines, errors.arc)),
        "slopes": slopes,
        "thin_features": thin,
        "hanging_walls": hanging,
    }
    report["warnings"] = [
        *model.notes,
        *_model_warnings(model, wall, settings),
        *line_warnings(settings),
        *thin_warnings(thin, settings),
        *hanging_warnings(hanging, settings),
        *layer_time_warnings(moves, seconds, settings),
        *skirt_warnings(paths.beside.around, settings),
        *slope_warnings(slopes),
        *standby_warnings(moves, seconds, settings),
        *visibility_warnings(wall.mesh, settings),
        *wall.notes,
    ]
    return report


def _solid(
    wall: PaintedWall, paths: PrintedPaths, moves: Moves, seconds: FloatArray, settings: PrintSettings
) -> dict[str, Any]:
    """The report's part on solid regions, with what tool changes within layers cost."""
    if wall.outlines.swapped is None:
        return wall.solid
    alike = moves_without_swaps(wall, paths, settings)
    return {"solid_regions": wall.solid["solid_regions"] | swap_cost(moves, seconds, alike, settings)}


def _model_warnings(model: SurfaceModel, wall: PaintedWall, settings: PrintSettings) -> list[str]:
    """Where objects lie, how large they are, how they stand, and what became of their outlines."""
    mesh, cut = wall.mesh, wall.cut
    return [
        *plate_warnings(model, mesh, cut.overlaps, settings),
        *_outline_warnings(cut, wall.lines, wall.samples, settings),
        *size_warnings(mesh, model.name, settings),
        *footing_warnings(mesh, model.names, cut.regions[0], settings),
    ]


def _outline_warnings(cut: Slices, lines: Contours, samples: Samples, settings: PrintSettings) -> list[str]:
    """What was mended of the outlines, and which of them print without the pattern or with thinner lines."""
    warnings = []
    if cut.united_layers:
        warnings.append(f"outlines that cross were united: in {cut.united_layers} of {len(cut.layers)} layers")
    warnings += open_warnings(cut.open_layers, cut.polygon_layer, cut.layers)
    if len(cut.specks.layer):
        warnings.append(
            f"outlines smaller than a strand are left out: {len(cut.specks.layer)} in all layers; "
            "scale the object up or lower extrusion_width"
        )
    full = line_widths(lines.layer, settings).take(lines.loop)
    thin = float((lines.width < 0.999 * full).mean()) if len(lines.width) else 0.0
    if thin > 0.01:
        warnings.append(f"{thin:.0%} of the outline bounds walls thinner than two lines; they print with thinner lines")
    short = int((np.diff(samples.start) == 0).sum())
    if len(samples.arc) and short:
        warnings.append(
            f"outlines too short for the pattern print without a wave: {short} of {len(lines.layer)} in all layers"
        )
    return warnings


def _overview(
    model: SurfaceModel, mesh: TriangleMesh, cut: Slices, moves: Moves, settings: PrintSettings
) -> dict[str, Any]:
    """What was printed, with which settings."""
    return {
        "name": model.name,
        "objects": object_rows(model, mesh),
        "layers": len(cut.layers),
        "raft_layers": settings.raft_layers,
        "tool_changes": int((np.diff(moves.tool) != 0).sum()),
        "bounds_mm": mesh.bounds.tolist(),
        "settings": settings.as_dict(),
        "outline_spans": int((np.diff((moves.feature == Feature.OUTER_WALL).astype(np.int8)) > 0).sum()),
    }
