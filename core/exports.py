"""The files of a finished print: G-code, X3G, and a dump for independent checks."""

from __future__ import annotations

from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from .errors import SettingsError
from .files import write_file
from .gcode.writer import counted_text
from .job.clock import StageClock, peak_rss_mb
from .pipeline import DualColorPrint
from .toolpaths.raft import raised
from .x3g.writer import x3g_bytes


def export_gcode(result: DualColorPrint, path: Path) -> DualColorPrint:
    """Write the G-code file; returns the print with its report brought up to date.

    Raises:
        OutputError: the file cannot be written.
    """
    clock = StageClock()
    clock.begin("gcode")
    header = _totals(result.report)
    begun = result.begun.result() if result.begun else None
    text, moves = counted_text(result.moves, result.settings, header, result.layer_begins, begun)
    write_file(path, text)
    clock.stop()
    return _reported(result, clock, gcode={"bytes": len(text), "moves": moves})


def export_x3g(result: DualColorPrint, path: Path) -> DualColorPrint:
    """Write the X3G file that the printer reads from its card; returns the print with its report brought up to date.

    Raises:
        OutputError: the file cannot be written.
        SettingsError: the printer does not read X3G.
    """
    printer = result.settings.printer_profile
    if printer.marlin:
        raise SettingsError(f"{printer.name} does not read X3G", "export G-code instead")
    clock = StageClock()
    clock.begin("x3g")
    data = x3g_bytes(result.moves, result.settings, result.name, result.layer_begins)
    write_file(path, data)
    clock.stop()
    return _reported(result, clock, x3g={"bytes": len(data)})


def _totals(report: dict[str, Any]) -> list[str]:
    """Totals for the head of the G-code file."""
    time, filament = report["time_s"], report["filament"]
    return [
        f"object = {report['name']}",
        f"layers = {report['layers']}",
        f"tool_changes = {report['tool_changes']}",
        f"time_s = {time['total']:.0f}",
        f"filament_tool0_mm = {filament['tool0_mm']:.1f}",
        f"filament_tool1_mm = {filament['tool1_mm']:.1f}",
    ]


def _reported(result: DualColorPrint, clock: StageClock, **made: dict[str, int]) -> DualColorPrint:
    stages = {**result.report["stages_s"], **clock.seconds}
    times = {"stages_s": stages, "total_s": sum(stages.values()), "peak_rss_mb": peak_rss_mb()}
    return replace(result, report={**result.report, **times, **made})


def dump(result: DualColorPrint, path: Path) -> None:
    """Write the outlines before and after the wave as .npz, for independent checks.

    Arrays: layer_z (L,) of the object's layers, above the raft if there is one, loop_layer (M,), loop_start (M + 1,),
    and for each of N outline points base_xy, wave_xy, phase (`WavedOutlines.wave`), depth (mm, peak to peak),
    tone, uv.

    Raises:
        OutputError: the file cannot be written.
    """
    lines = result.outlines
    content = BytesIO()
    np.savez_compressed(
        content,
        layer_z=raised(result.slices.layers, result.settings).top[result.settings.raft_layers :],
        loop_layer=lines.layer,
        loop_start=lines.start,
        base_xy=lines.base,
        wave_xy=lines.points,
        phase=lines.wave,
        depth=lines.depth,
        tone=lines.tone,
        uv=lines.uv,
    )
    write_file(path, content.getvalue())
