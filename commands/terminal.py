"""What a command writes on the terminal."""

from __future__ import annotations

import signal
import sys
import threading
from typing import TYPE_CHECKING

from ..core.errors import counted

if TYPE_CHECKING:
    from ..core.pipeline import DualColorPrint


class Progress:
    """One line on a terminal's stderr that is written over; nothing where stderr is no terminal."""

    def __init__(self) -> None:
        self._shown = sys.stderr.isatty()

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *problem: object) -> None:
        self._write("")

    def show(self, share: float, stage: str) -> None:
        """Say how far the job is, `share` from 0 to 1."""
        self._write(f"{share:4.0%} {stage}")

    def _write(self, text: str) -> None:
        if self._shown:
            print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)


def load_blender() -> None:
    """Import Blender's module and GEOS, which takes a second; a signal meanwhile ends the program, as nothing is begun.

    The starts of both swallow the exceptions that signals raise, and go on broken.
    """
    if "bpy" in sys.modules or threading.current_thread() is not threading.main_thread():
        return
    numbers = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
    former = {number: signal.getsignal(number) for number in numbers}
    former = {number: handler for number, handler in former.items() if callable(handler)}  # others are not Python's
    for number in former:
        signal.signal(number, signal.SIG_DFL)
    try:
        import bpy  # noqa: F401
        import shapely  # noqa: F401
    finally:
        for number, handler in former.items():
            signal.signal(number, handler)


def summary(result: DualColorPrint) -> list[str]:
    """Size, time, filament and warnings of a print, a line each."""
    report = result.report
    low, high = report["bounds_mm"]
    size = " × ".join(f"{b - a:.1f}" for a, b in zip(low, high, strict=True))
    time = report["time_s"]
    count = len(report["objects"])
    name = f"{result.name}, plate of {count} objects" if count > 1 else result.name
    return [
        f"{name}: {size} mm, {counted(report['layers'], 'layer')}, {counted(report['tool_changes'], 'tool change')}",
        f"print time {_duration(time['total'])} after about {_duration(time['heating'])} of heating",
        f"filament: {_filament(result, 'black')}, {_filament(result, 'white')}",
        *([_solid_regions(report["solid_regions"])] if "solid_regions" in report else []),
        *(f"warning: {warning}" for warning in result.warnings),
    ]


def _duration(seconds: float) -> str:
    hours, minutes = divmod(round(seconds / 60), 60)
    return f"{hours} h {minutes:02d} min" if hours else f"{minutes} min"


def _filament(result: DualColorPrint, color: str) -> str:
    """How much of a color is needed, and where it goes."""
    tool = result.settings.black_tool if color == "black" else 1 - result.settings.black_tool
    sides = ("right", "left") if result.settings.printer_profile.marlin is None else ()
    place = f", {sides[tool]} nozzle" if sides else ""
    return f"{result.report['filament'][f'tool{tool}_g']:.1f} g {color} (tool {tool}{place})"


def _solid_regions(solid: dict[str, float]) -> str:
    """How much is printed in one color, and what that costs."""
    minutes = (solid["outline_time_s"] + solid["tool_change_time_s"]) / 60
    return (
        f"solid regions: {solid['regions']}, {solid['black_mm2']:.0f} mm² black, {solid['white_mm2']:.0f} mm² white; "
        f"{solid['tool_changes']:+d} tool changes, {minutes:+.1f} min"
    )
