"""A flame graph of a job, as an SVG: which functions call which, as wide as they take processor time.

    python benchmarks/flame.py MODEL.npz PICTURE.svg [--width PIXELS]

MODEL.npz is what `models.py` writes. The job runs in one thread, so that each piece of work stands on the stage that
it belongs to; every millisecond of processor time it is asked where it is. A library's time counts where it is called
from. Needs signals, which Windows does not have.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
import zlib
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from time import process_time
from types import FrameType
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
sys.path.insert(0, str(ROOT))

INTERVAL_S = 0.001
ROW, TEXT, LETTER = 17, 11, 6.2
LEAST_PIXELS = 1.0
# What only hands work on to others, in threads or to be kept.
BETWEEN = ("parallel.py", "stages.py", "stage_cache.py", "clock.py", "progress.py", "flame.py")
Box = tuple[int, float, float, str, str]


@dataclass
class Node:
    """A function called from where its parents say: the seconds spent in it, and what it calls."""

    seconds: float = 0.0
    calls: dict[str, Node] = field(default_factory=dict)


class SameThread:
    """As a pool of threads, but all is done at once by whoever asks."""

    def __init__(self, *_: Any) -> None:
        """Of any size."""

    def __enter__(self) -> SameThread:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def shutdown(self) -> None:
        """Nothing is left to be done."""

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """The function's result, which is there already."""
        done: Future[Any] = Future()
        done.set_result(function(*arguments))
        return done


def main() -> int:
    """Run the job and draw where its time went."""
    parser = argparse.ArgumentParser(description="Draw a flame graph of a job.")
    parser.add_argument("model", type=Path)
    parser.add_argument("picture", type=Path)
    parser.add_argument("--width", type=int, default=1400, help="pixels (default: 1400)")
    args = parser.parse_args()
    job = sampled(args.model)
    boxes = list(laid_out("job", job, args.width / job.seconds))
    args.picture.write_text(svg(boxes, args.width, args.model.stem, job.seconds), encoding="utf-8")
    return 0


def sampled(path: Path) -> Node:
    """The whole job with all that it calls."""
    from launcher import load_package

    load_package()
    import numpy as np
    from dualcolor.core.exports import export_gcode
    from dualcolor.core.pipeline import generate
    from dualcolor.core.settings import PrintSettings

    from benchmarks.job import surface_model

    for module in [each for name, each in sys.modules.items() if name.startswith("dualcolor.core")]:
        if hasattr(module, "ThreadPoolExecutor"):
            module.ThreadPoolExecutor = SameThread  # type: ignore[attr-defined]
    model = surface_model(np.load(path), path.stem)
    job, since = Node(), process_time()

    def look(_signal: int, frame: FrameType | None) -> None:
        # A signal is only handled between two steps of the interpreter: a long call into a library counts in full.
        nonlocal since
        now = process_time()
        node = job
        node.seconds += now - since
        for name in reversed(list(_stack(frame))):
            node = node.calls.setdefault(name, Node())
            node.seconds += now - since
        since = now

    signal.signal(signal.SIGPROF, look)
    signal.setitimer(signal.ITIMER_PROF, INTERVAL_S, INTERVAL_S)
    export_gcode(generate(model, PrintSettings(), begin_gcode=True), Path(os.devnull))
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    return job


def _stack(frame: FrameType | None) -> Iterator[str]:
    """Our functions and those that we call of libraries, the innermost first."""
    while frame:
        code, path = frame.f_code, Path(frame.f_code.co_filename)
        if path.name not in BETWEEN and not code.co_name.startswith("<"):
            if path.is_relative_to(ROOT):
                yield f"{code.co_name} ({path.relative_to(ROOT).as_posix()})"
            elif library := next((part for part in ("numpy", "shapely") if part in path.parts), ""):
                yield f"{code.co_name} ({library})"
        frame = frame.f_back


def laid_out(name: str, node: Node, scale: float, row: int = 0, left: float = 0.0) -> Iterator[Box]:
    """Boxes (row, left, width, text, title): each function on the one that calls it, in the order of first calls."""
    if node.seconds * scale < LEAST_PIXELS:
        return
    yield row, left, node.seconds * scale, name.partition(" ")[0], f"{name}: {node.seconds:.3f} s"
    for called, inner in node.calls.items():
        yield from laid_out(called, inner, scale, row + 1, left)
        left += inner.seconds * scale


def svg(boxes: list[Box], width: int, name: str, seconds: float) -> str:
    """The picture, the job at the bottom."""
    rows = 1 + max(row for row, *_ in boxes)
    height = (rows + 1) * ROW + 8
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
        f'font-family="Verdana, sans-serif" font-size="{TEXT}">',
        f'<rect width="{width}" height="{height}" fill="#fffdf8"/>',
        f'<text x="4" y="{TEXT + 3}">{escape(name)}: {seconds:.1f} s of one processor</text>',
    ]
    for row, left, across, text, title in boxes:
        top = height - (row + 1) * ROW - 2
        shown = text[: int((across - 4) / LETTER)]
        label = f'<text x="{left + 2:.1f}" y="{top + TEXT + 1}">{escape(shown)}</text>' if len(shown) > 2 else ""
        lines.append(
            f'<g><title>{escape(title)}</title><rect x="{left:.1f}" y="{top}" width="{max(across - 0.5, 0.5):.1f}" '
            f'height="{ROW - 1}" fill="{_color(text, title)}"/>{label}</g>'
        )
    return "\n".join([*lines, "</svg>", ""])


def _color(text: str, title: str) -> str:
    """Warm for our own functions, blue for libraries; the same for the same name."""
    shade = zlib.crc32(text.encode()) % 40
    if text == "job" or "core/" in title or "benchmarks/" in title:
        return f"rgb({225 + shade // 2},{140 + 2 * shade},{60 + shade})"
    return f"rgb({120 + shade},{170 + shade},{225 + shade // 2})"


if __name__ == "__main__":
    sys.exit(main())
