"""What a report says, in the words of the sidebar."""

from __future__ import annotations

from typing import Any

_TOOL_SIDES = ("right", "left")


def figures(report: dict[str, Any]) -> list[tuple[str, str]]:
    """(label, value) of the figures that matter at a glance, from a job's report."""
    low, high = report["bounds_mm"]
    size = " × ".join(f"{end - start:.1f}" for start, end in zip(low, high, strict=True))
    black = report["settings"]["black_tool"]
    rows = [
        ("Size", f"{size} mm"),
        ("Layers", f"{report['layers']:,}"),
        ("Time", duration(report["time_s"]["total"])),
    ]
    for tool in (0, 1):
        length_m, mass_g = report["filament"][f"tool{tool}_mm"] / 1000, report["filament"][f"tool{tool}_g"]
        color = "Black" if tool == black else "White"
        rows.append((f"{color} ({_TOOL_SIDES[tool]})", f"{length_m:.2f} m, {mass_g:.1f} g"))
    if solid := report.get("solid_regions"):
        seconds = solid["outline_time_s"] + solid["tool_change_time_s"]
        cost = f"{solid['tool_changes']:+d} tool changes, {seconds / 60:+.1f} min"
        rows.append(("Solid Regions", f"{solid['regions']}: {cost}"))
    return rows


def duration(seconds: float) -> str:
    """Hours and minutes."""
    minutes = round(seconds / 60)
    return f"{minutes // 60} h {minutes % 60:02d} min" if minutes >= 60 else f"{minutes} min"
