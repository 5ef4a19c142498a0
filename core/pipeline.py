"""The main job, stage by stage: the only place that knows their order."""

from __future__ import annotations

from collections.abc import Callable, Generator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from shapely import Geometry

from .analysis.slopes import face_contrast, slope_report, slope_warnings
from .breakdown import filament_report, single_color_seconds, swap_cost, time_report
from .calibration.calibrate import calibrated
from .checks import check
from .fill.paths import covering, fill_areas, fill_lines
from .gcode.standby import standby_warnings
from .mesh import size_warnings, triangulate
from .model import BoolArray, FloatArray, SurfaceModel, TriangleMesh
from .pattern.contours import Contours, contours
from .pattern.optimized import optimized_samples
from .pattern.quality import seam_errors
from .pattern.sampling import Projector, Samples, sample
from .pattern.slant import slant_along
from .pattern.solid_regions import left_to_other_tool, solid_regions, solid_report, with_solid_regions
from .pattern.strand_edges import widened
from .pattern.visibility import at_arcs, seam_visibility, visibility_warnings
from .pattern.wave import WavedOutlines, average_along_wall, modulated, waved
from .plate import object_rows, plate_warnings
from .progress import Progress, drained
from .report import StageClock, peak_rss_mb
from .settings import PrintSettings
from .slicing.open_layers import open_warnings
from .slicing.planes import Layers, line_widths
from .slicing.slices import Slices, slices
from .stage_cache import NoCache, StageCache
from .statistics import layer_begins, move_seconds
from .supports.paths import Supports, supports, with_supports
from .texture.labels import uv_charts
from .texture.lookup import tone_at
from .texture.pyramid import TexturePyramids, build_pyramids, sizes_of
from .thin_features import thin_features, thin_report, thin_warnings
from .toolpaths.assemble import assemble
from .toolpaths.moves import Feature, Moves, Paths
from .toolpaths.order import ordered
from .toolpaths.outer_wall import inside_of_wall, outer_wall_paths
from .toolpaths.raft import lifted, raised
from .toolpaths.skirt import skirt_warnings
from .toolpaths.surroundings import ground, shadow, surrounding_paths
from .toolpaths.travels import Rooms, rooms

# Outlines behind the wave may differ from the true ones by this much, mm.
FILL_TOLERANCE = 0.02
# Up to so many points of outlines the same object in a single colour is worked out beside the toolpaths.
MOST_POINTS_TWICE = 1_000_000


@dataclass(frozen=True)
class DualColorPrint:
    """A finished job.

    Attributes:
        settings: as used.
        name: of the object.
        mesh: as sliced, on the bed.
        outlines: the waved outer wall.
        slices: of all layers.
        moves: the print in order.
        layer_begins: see `statistics.layer_begins`.
        report: JSON-ready.
        warnings: findings that did not stop the job, one sentence each.
    """

    settings: PrintSettings
    name: str
    mesh: TriangleMesh
    slices: Slices
    outlines: WavedOutlines
    moves: Moves
    layer_begins: FloatArray
    report: dict[str, Any]
    warnings: list[str]


def generate(
    model: SurfaceModel,
    settings: PrintSettings,
    on_progress: Callable[[float, str], None] | None = None,
    cache: StageCache | None = None,
) -> DualColorPrint:
    """Run the whole job; `on_progress` is told the share done and the stage, `cache` keeps stages for the next run.

    Raises:
        PrintError: the input cannot be printed.
    """
    return drained(steps(model, settings, cache), lambda step: on_progress(*step) if on_progress else None)


def steps(
    model: SurfaceModel, settings: PrintSettings, cache: StageCache | None = None
) -> Generator[Progress, None, DualColorPrint]:
    """The job as a generator: yields (share done, name of the stage to come), returns the print.

    Raises:
        PrintError: the input cannot be printed.
    """
    clock = StageClock()
    cache = cache or NoCache()
    run = cache.run

    def stage(done: float, name: str) -> Progress:
        clock.begin(name)
        return done, name

    yield stage(0.0, "mesh")
    mesh = cache.former("mesh", triangulate(model, settings))
    # What does not wait for the stages in between runs beside them; leaving the block waits for it.
    with ThreadPoolExecutor(1) as beside:

        def aside(name: str, work: Callable[..., Any], *inputs: Any) -> Future[Any]:
            return beside.submit(clock.timed, name, lambda: run(name, work, *map(_known, inputs)))

        footprint = 2 * settings.layer_height
        charts = aside("charts", uv_charts, mesh, sizes_of(model.textures))
        painting = aside("texture", build_pyramids, mesh, model.textures, footprint, settings.texture_filter, charts)
        yield stage(0.05, "slicing")
        cut = run("slicing", slices, mesh, settings)
        yield stage(0.2, "contours")
        lines = run("contours", contours, cut.outlines, cut.loop_polygon, settings)
        yield stage(0.3, "sampling")
        projector = run("projector", Projector, lines, settings.projection_threshold)
        early = run("tone", pattern_tone, lines, painting.result(), settings) if settings.hide_seams else None
        seen = run("visibility", seam_visibility, lines, cut.layers.plane, mesh, model.textures, early, settings)
        samples = run("sampling", pattern_samples, lines, projector, settings, seen)
        yield stage(0.4, "texture")
        pyramids = painting.result()
        fit = aside("seam errors", seam_errors, lines, samples, projector)
        paint = aside("slopes", face_contrast, mesh, pyramids, settings)
        yield stage(0.45, "tone")
        tone = run("tone", pattern_tone, lines, pyramids, settings) if early is None else early
        del charts, painting, pyramids  # as large as the moves that are to come
        yield stage(0.5, "modulation")
        slant = run("slant", _slant, lines, mesh, settings.wavelength)
        printed, notes = run("calibration", calibrated, tone, slant, settings)
        depth, set_back = run("modulation", modulated, lines, printed, slant, settings)
        set_back = run("strand edges", widened, lines, printed, set_back, settings)
        depth, set_back, swapped, solid = _solid_colours(lines, tone, slant, depth, set_back, projector, settings)
        outlines = run("wave", waved, lines, samples, tone, depth, set_back, settings, swapped)
        yield stage(0.6, "supports")
        holding = run("supports", supports, mesh, cut, lines, depth, settings)
        shade = aside("shadow", _shadow, cut, holding, settings)
        weak = aside("thin features", thin_features, cut, lines, settings)
        yield stage(0.65, "fill")
        inside = run("inside", inside_of_wall, lines, depth, set_back, len(cut.polygons), FILL_TOLERANCE)
        outlined = run("covering", covering, cut.regions)
        areas = cache.run_rows("areas", fill_areas, (inside, cut.polygon_layer), outlined, settings)
        fill = run("fill", fill_lines, areas, outlined, cut.polygon_layer, settings)
        inner = run("inner", _joined, fill, holding.paths)
        within = run("rooms", rooms, inside, cut.polygon_layer, cut.regions)
        yield stage(0.75, "toolpaths")
        plain = single_color_seconds, outlines, inner, cut.layers, settings, within
        # Beside the toolpaths of a large print it would take a third more memory: its tables are as large as theirs.
        alone = aside("single color", *plain) if len(outlines.points) < MOST_POINTS_TWICE else None
        wall = outer_wall_paths(outlines)
        around = run("surroundings", _surroundings, shade.result(), cut, holding, wall, settings)
        moves = run("toolpaths", _moves, wall, inner, around, cut.layers, within, settings)
        alone = alone or aside("single color", *plain)
        yield stage(0.9, "analysis")
        errors = fit.result()
        pattern = errors.shares(len(samples.arc), at_arcs(seen, lines, errors.arc))
        slopes = slope_report(paint.result())
        single_color = alone.result()
    thin = thin_report(weak.result(), cut)
    seconds = run("time", _seconds, moves, settings)
    if outlines.swapped is not None:
        alike = _moves(outer_wall_paths(replace(outlines, swapped=None)), inner, around, cut.layers, within, settings)
        solid["solid_regions"] |= swap_cost(moves, seconds, alike, settings)
    warnings = [
        *plate_warnings(model, mesh, cut.overlaps, settings),
        *_warnings(cut, lines, samples, settings),
        *size_warnings(mesh, model.name, settings),
        *thin_warnings(thin, settings),
        *skirt_warnings(moves, settings),
        *slope_warnings(slopes),
        *standby_warnings(moves, seconds, settings),
        *visibility_warnings(mesh, settings),
        *notes,
    ]
    report = _report(model, mesh, cut, moves, settings)
    report |= {"time_s": time_report(moves, settings, single_color, seconds)}
    report |= {"filament": filament_report(moves, settings)} | solid
    report |= {"pattern": pattern, "slopes": slopes, "thin_features": thin, "warnings": warnings}
    cache.trim()
    clock.stop()
    report |= {"stages_s": clock.seconds, "total_s": sum(clock.seconds.values())}
    report |= {"beside_s": clock.beside, "peak_rss_mb": peak_rss_mb()}
    return DualColorPrint(
        settings, model.name, mesh, cut, outlines, moves, layer_begins(moves, seconds), report, warnings
    )


def _known(value: Any) -> Any:
    """What work in the same thread, ahead of this, has made; anything else as it is."""
    return value.result() if isinstance(value, Future) else value


def pattern_samples(
    lines: Contours, projector: Projector, settings: PrintSettings, visibility: FloatArray | None = None
) -> Samples:
    """Where the waves sit, by the scheme that is set; nowhere for `offset`.

    Args:
        lines: N contour points.
        projector: made for them.
        settings: those of the pattern are used.
        visibility: (N,) 0 to 1, how much a seam is seen there; None is alike everywhere.
    """
    if settings.pattern == "offset":
        return Samples(np.zeros(0), np.zeros(0, dtype=np.int64), np.zeros(len(lines.layer) + 1, dtype=np.int64))
    if settings.sampling == "paper":
        return sample(lines, projector, settings)
    return optimized_samples(lines, projector, settings, visibility)


def pattern_tone(lines: Contours, pyramids: TexturePyramids, settings: PrintSettings) -> FloatArray:
    """(N,) tone at every contour point, no finer than the pattern can show."""
    tone = tone_at(pyramids, lines.face, lines.carried[:, :2], lines.carried[:, 2], settings.background_tone)
    if settings.pattern == "offset" or settings.texture_filter == "lanczos":
        return tone
    # The look-up has averaged over a layer pair in all directions; a wave cannot show more than one tone along it, but
    # where it fades as the line is set back, the line can.
    share = 1.0 if settings.pattern == "wave" else 0.5
    return average_along_wall(tone, lines, settings.wavelength * share)


def _solid_colours(
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


def _joined(fill: Paths, holding: Paths) -> Paths:
    return Paths.joined([fill, holding])


def _seconds(moves: Moves, settings: PrintSettings) -> FloatArray:
    return move_seconds(moves, settings.printer_profile)


def _shadow(cut: Slices, holding: Supports, settings: PrintSettings) -> Geometry:
    return shadow(with_supports(cut.regions, holding.areas, settings), settings)


def _surroundings(shade: Geometry, cut: Slices, holding: Supports, wall: Paths, settings: PrintSettings) -> Paths:
    first = with_supports(cut.regions[:1], holding.areas[:1], settings)
    return surrounding_paths(ground(shade, first, wall, settings), raised(cut.layers, settings), settings)


def _moves(wall: Paths, inner: Paths, around: Paths, layers: Layers, within: Rooms, settings: PrintSettings) -> Moves:
    part = lifted(Paths.joined([wall, inner]), settings)
    moves = assemble(ordered(Paths.joined([part, around]), settings), raised(layers, settings), settings, within)
    check(moves, settings)
    return moves


def _warnings(cut: Slices, lines: Contours, samples: Samples, settings: PrintSettings) -> list[str]:
    warnings = []
    if cut.united_layers:
        warnings.append(f"outlines that cross were united: in {cut.united_layers} of {len(cut.layers)} layers")
    warnings += open_warnings(cut.open_layers, cut.polygon_layer, cut.layers)
    if len(cut.specks.layer):
        warnings.append(f"outlines smaller than a strand are left out: {len(cut.specks.layer)} in all layers")
    full = line_widths(lines.layer, settings)[lines.loop]
    thin = float((lines.width < 0.999 * full).mean()) if len(lines.width) else 0.0
    if thin > 0.01:
        warnings.append(f"{thin:.0%} of the outline bounds walls thinner than two lines; they print with thinner lines")
    short = int((np.diff(samples.start) == 0).sum())
    if len(samples.arc) and short:
        warnings.append(
            f"outlines too short for the pattern print without a wave: {short} of {len(lines.layer)} in all layers"
        )
    return warnings


def _report(
    model: SurfaceModel, mesh: TriangleMesh, cut: Slices, moves: Moves, settings: PrintSettings
) -> dict[str, Any]:
    return {
        "name": model.name,
        "objects": object_rows(model, mesh),
        "layers": len(cut.layers),
        "raft_layers": settings.raft_layers,
        "tool_changes": int((np.diff(moves.tool) != 0).sum()),
        "bounds_mm": mesh.bounds.tolist(),
        "settings": settings.as_dict(),
        "outline_spans": int((np.diff((moves.feature == Feature.OUTER_WALL).astype(np.int8)) > 0).sum()),
        "gcode": {"bytes": 0, "moves": len(moves.tool)},
    }
