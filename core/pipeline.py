"""The main job: its two halves, and the findings on what they made."""

from __future__ import annotations

from collections.abc import Callable, Generator
from concurrent.futures import Future
from typing import Any

from .gcode.writer import BegunText, begin_text
from .job.findings import findings
from .job.move_stages import summary, summary_anew
from .job.path_stages import path_stages
from .job.stage_cache import StageCache
from .job.stages import Stages
from .job.wall_stages import wall_stages
from .model import FloatArray, SurfaceModel, TriangleMesh
from .pattern.wave import WavedOutlines
from .progress import Progress, drained
from .records import dataclass
from .settings import PrintSettings
from .slicing.slices import Slices
from .toolpaths.move_times import layer_begins
from .toolpaths.moves import Moves


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
        layer_begins: see `move_times.layer_begins`.
        report: JSON-ready.
        warnings: findings that did not stop the job, one sentence each.
        begun: most of the text of its G-code, None if it was not asked for.
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
    begun: Future[BegunText] | None = None


def generate(
    model: SurfaceModel,
    settings: PrintSettings,
    on_progress: Callable[[float, str], None] | None = None,
    cache: StageCache | None = None,
    begin_gcode: bool = False,
) -> DualColorPrint:
    """Run the whole job; `on_progress` is called with share done and stage, `cache` keeps results for the next run.

    With `begin_gcode` most of the G-code's text is made in the second thread, for prints that are written at once.

    Raises:
        PrintError: the input cannot be printed.
    """
    job = steps(model, settings, cache, begin_gcode)
    return drained(job, lambda step: on_progress(*step) if on_progress else None)


def steps(
    model: SurfaceModel, settings: PrintSettings, cache: StageCache | None = None, begin_gcode: bool = False
) -> Generator[Progress, None, DualColorPrint]:
    """The job as a generator: yields (share done, name of the stage to come), returns the print; see `generate`.

    Raises:
        PrintError: the input cannot be printed.
    """
    with Stages(cache) as stages:
        wall = yield from wall_stages(model, settings, stages)
        paths = yield from path_stages(wall, settings, stages)
        yield stages.begin(0.9, "analysis")
        begun = stages.aside("gcode", begin_text, paths.moves, settings, kept=False) if begin_gcode else None
        times = stages.run_layers("time", summary, summary_anew, (paths.moves,), settings)
        report = findings(model, wall, paths, *times, settings)
    report |= stages.ended()
    begins = layer_begins(*times)
    return DualColorPrint(
        settings, model.name, wall.mesh, wall.cut, wall.outlines, paths.moves, begins, report, report["warnings"], begun
    )
