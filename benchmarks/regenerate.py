"""How long it takes to generate again after a change, as a share of the first run.

    python benchmarks/regenerate.py [--model NAME] [--data FOLDER] [--repeat N] [--write]

Each run goes from mesh arrays in memory to a written G-code file, with what an earlier run has computed at hand, as an
export from Blender does. Between two changes the job is run as it was, so that each change starts from the same state.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from benchmarks.models import MODELS  # noqa: E402
from benchmarks.tables import replace_table  # noqa: E402

README = HERE / "README.md"
FIRST = "all, the first time"
Times = tuple[float, float]


def main() -> int:
    """Measure all changes and print the table."""
    parser = argparse.ArgumentParser(description="Generate again after changes.")
    parser.add_argument("--model", choices=tuple(MODELS), default="gargoyle", help="default: gargoyle")
    parser.add_argument("--data", type=Path, default=HERE.parent.parent / "shared" / "data", metavar="FOLDER")
    parser.add_argument("--repeat", type=int, default=3, metavar="N", help="repetitions (default: 3)")
    parser.add_argument("--write", action="store_true", help="replace the table in README.md")
    args = parser.parse_args()
    model = model_of(args.model, args.data)
    rounds = [one_round(model) for _ in range(args.repeat)]
    text = markdown(rounds)
    print(text)
    if args.write:
        replace_table(README, "regenerate", text)
    return 0


def model_of(name: str, data: Path) -> Any:
    """The model as the job takes it, with its picture."""
    from launcher import load_package

    load_package()
    import numpy as np

    from benchmarks.job import surface_model

    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, str(HERE / "models.py"), name, str(data / MODELS[name][0]), folder]
        subprocess.run(command, check=True)
        return surface_model(np.load(Path(folder) / f"{name}.npz"), name)


def changes(model: Any) -> dict[str, tuple[Any, dict[str, Any]]]:
    """By what is changed, the model and the settings that differ from the defaults."""
    import numpy as np

    tone = model.textures[0].tone
    height, width = tone.shape
    stroke = tone.copy()
    stroke[height // 2 : height // 2 + height // 16, width // 3 : width // 3 + width // 16] = 1.0
    other = np.ascontiguousarray(tone[::-1])
    return {
        "nothing": (model, {}),
        "another picture": (_painted(model, other), {}),
        "a painted stroke": (_painted(model, stroke), {}),
        "the tone curve (`gamut_mapping`)": (model, {"gamut_mapping": "clip"}),
        "when the set-back begins (`offset_onset`)": (model, {"offset_onset": 0.2}),
        "how far it goes (`offset_max`)": (model, {"offset_max": 0.3}),
        "the infill (`infill_density`)": (model, {"infill_density": 15.0}),
        "a speed (`infill_speed`)": (model, {"infill_speed": 70.0}),
    }


def _painted(model: Any, tone: Any) -> Any:
    return replace(model, textures=(replace(model.textures[0], tone=tone),))


def one_round(model: Any) -> dict[str, Times]:
    """Wall and processor seconds of the first run and of those after each change."""
    from dualcolor.core.job.stage_cache import StageCache
    from dualcolor.core.settings import PrintSettings

    cache, usual = StageCache(), PrintSettings()
    taken = {FIRST: timed(model, usual, cache)}
    for name, (changed, settings) in changes(model).items():
        taken[name] = timed(changed, usual.changed(settings), cache)
        timed(model, usual, cache)
    return taken


def timed(model: Any, settings: Any, cache: Any) -> Times:
    """Wall and processor seconds of one job."""
    from dualcolor.core.exports import export_gcode
    from dualcolor.core.pipeline import generate

    began, cpu = perf_counter(), os.times()
    export_gcode(generate(model, settings, cache=cache, begin_gcode=True), Path(os.devnull))
    wall, now = perf_counter() - began, os.times()
    return wall, now.user + now.system - cpu.user - cpu.system


def markdown(rounds: list[dict[str, Times]]) -> str:
    """The table for README.md, medians; the shares are those of each round."""
    lines = ["| changed | time, s | CPU time, s | time / first run | CPU time / first run |", "|---|---|---|---|---|"]
    for name in rounds[0]:
        seconds = [median(taken[name][kind] for taken in rounds) for kind in (0, 1)]
        shares = [median(taken[name][kind] / taken[FIRST][kind] for taken in rounds) for kind in (0, 1)]
        cells = [name, *(f"{value:.2f}" for value in (*seconds, *shares))]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join([*lines, ""])


if __name__ == "__main__":
    sys.exit(main())
