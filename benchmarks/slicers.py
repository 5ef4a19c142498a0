"""How fast the dual-colour job is beside a common slicer that prints the same shape in one colour.

    python benchmarks/slicers.py [--repeat N] [--model NAME] [--data FOLDER] [--json FILE]

Ours: from mesh arrays in memory to a written G-code file, textured, two colours. The other one: PrusaSlicer, from an
STL file to a written G-code file, in one colour, with the same layers, walls, skins, infill and skirt. Both run
alternately, each in a process of its own; ours once more with supports, and X3G beside the G-code. Without
`prusa-slicer` only ours is measured; without the gargoyle's file only the sphere.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

HERE = Path(__file__).resolve().parent
DATA = HERE.parent.parent / "shared" / "data"
MODELS = ("gargoyle", "icosphere")
# Where the picture becomes the pattern: what a slicer does not have.
PATTERN_STAGES = ("contours", "sampling", "texture", "tone", "modulation")
# The same sums without the filtered contours, which are the outlines that any slicer needs.
TONE_STAGES = ("sampling", "texture", "tone", "modulation")

PRUSA_OPTIONS = {
    "layer-height": "0.25",
    "first-layer-height": "0.25",
    "nozzle-diameter": "0.4",
    "extrusion-width": "0.4",
    "perimeters": "2",
    "top-solid-layers": "3",
    "bottom-solid-layers": "3",
    "fill-density": "10%",
    "fill-pattern": "rectilinear",
    "skirts": "1",
    "skirt-distance": "6",
    "gcode-flavor": "sailfish",
    "bed-shape": "-125x-125,125x-125,125x125,-125x125",
    "center": "0,0",
}

Run = dict[str, Any]


def main() -> int:
    """Measure the models asked for and print the tables."""
    parser = argparse.ArgumentParser(description="Compare the dual-colour job with PrusaSlicer in one colour.")
    parser.add_argument("--repeat", type=int, default=5, metavar="N", help="repetitions (default: 5)")
    parser.add_argument("--model", choices=MODELS, action="append", help="only this model; repeatable")
    parser.add_argument("--data", type=Path, default=DATA, metavar="FOLDER", help="holds meshes/nc/gargoyle.obj")
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write all runs")
    args = parser.parse_args()
    slicer = shutil.which("prusa-slicer")
    if slicer is None:
        print("prusa-slicer is not installed: measuring ours alone")
    runs = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in args.model or MODELS:
            source = args.data / "meshes" / "nc" / "gargoyle.obj"
            if name == "gargoyle" and not source.is_file():
                print(f"{source} is not here: skipping the gargoyle")
                continue
            subprocess.run([sys.executable, str(HERE / "models.py"), name, str(source), folder], check=True)
            runs[name] = measured(name, Path(folder), slicer, args.repeat)
            print_tables(name, runs[name])
    if args.json:
        args.json.write_text(json.dumps(runs, indent=1) + "\n", encoding="utf-8")
    return 0


def measured(name: str, folder: Path, slicer: str | None, repeat: int) -> dict[str, list[Run]]:
    """All runs of both programs, taken in turns; a first run of each, which fills the disk cache, is left out."""
    ours, theirs, supported = [], [], []
    for _ in range(repeat + 1):
        ours.append(run_ours(folder / f"{name}.npz", folder / "ours.gcode"))
        supported.append(run_ours(folder / f"{name}.npz", folder / "ours.gcode", folder / "ours.x3g"))
        if slicer:
            theirs.append(run_prusa(slicer, folder / f"{name}.stl", folder / "theirs.gcode"))
    return {"ours": ours[1:], "supported": supported[1:], "prusa": theirs[1:]}


def run_ours(model: Path, gcode: Path, x3g: Path | None = None) -> Run:
    """One job of ours; with supports if an X3G file is to be written too."""
    command = [sys.executable, str(HERE / "job.py"), str(model), str(gcode), *([str(x3g)] if x3g else [])]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    figures: Run = json.loads(done.stdout)
    return figures


def run_prusa(slicer: str, model: Path, gcode: Path) -> Run:
    """One run of PrusaSlicer, the start of its process included."""
    began = perf_counter()
    options = [f"--{name}={value}" for name, value in PRUSA_OPTIONS.items()]
    command = [slicer, "--export-gcode", *options, "--output", str(gcode), str(model)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    wall = perf_counter() - began
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise RuntimeError(f"prusa-slicer ended with status {process.returncode}")
    peak = used.ru_maxrss / (1 << (20 if sys.platform == "darwin" else 10))
    text = gcode.read_bytes()
    return {
        "wall_s": wall, "cpu_s": used.ru_utime + used.ru_stime, "peak_mb": peak,
        "layers": text.count(b";LAYER_CHANGE"), "moves": text.count(b"\nG1 "),
    }  # fmt: skip


def print_tables(name: str, runs: dict[str, list[Run]]) -> None:
    """The comparison, and where our time goes."""
    ours, supported, theirs = runs["ours"], runs["supported"], runs["prusa"]
    print(f"\n{name}: {ours[0]['layers']} layers, medians of {len(ours)} runs")
    print(f"{'':17}{'wall s':>9}{'CPU s':>9}{'peak MB':>9}{'moves':>10}{'layers':>8}")
    for title, rows in (("ours", ours), ("+ supports, X3G", supported), ("PrusaSlicer", theirs)):
        if rows:
            wall, cpu, peak = (median(row[key] for row in rows) for key in ("wall_s", "cpu_s", "peak_mb"))
            print(f"{title:17}{wall:9.2f}{cpu:9.2f}{peak:9.0f}{rows[0]['moves']:10}{rows[0]['layers']:8}")
    for title, rows in (("ratio", ours), ("ratio, + supports", supported)):
        if theirs:
            wall, cpu = (
                median(mine[key] / other[key] for mine, other in zip(rows, theirs, strict=True))
                for key in ("wall_s", "cpu_s")
            )
            print(f"{title:17}{wall:9.2f}{cpu:9.2f}   (ours / PrusaSlicer, median of the pairs)")
    above = median(run["peak_mb"] - run["bare_mb"] for run in ours)
    imports = median(run["import_s"] for run in ours)
    print(
        f"ours: memory above the bare interpreter {above:.0f} MB; importing the program, not counted, {imports:.2f} s"
    )
    print_stages(ours)


def print_stages(ours: list[Run]) -> None:
    """Seconds and share of each stage; of the work beside them the seconds only."""
    stages = {stage: median(run["stages_s"][stage] for run in ours) for stage in ours[0]["stages_s"]}
    total = sum(stages.values())
    print(f"{'stage':14}{'s':>9}{'share':>9}")
    for stage, seconds in stages.items():
        print(f"{stage:14}{seconds:9.2f}{seconds / total:9.0%}")
    print(f"{'all':14}{total:9.2f}")
    for work in ours[0]["beside_s"]:
        print(f"in another thread: {work} {median(run['beside_s'][work] for run in ours):.2f} s")
    for group in (TONE_STAGES, PATTERN_STAGES):
        waited = median(spent(run["stages_s"], group) / spent(run["stages_s"]) for run in ours)
        worked = median(both(run, group) / both(run) for run in ours)
        print(f"{' + '.join(group)}: {waited:.0%} of the time, {worked:.0%} of the work in all threads")


def spent(seconds: dict[str, float], names: tuple[str, ...] | None = None) -> float:
    """Sum of some entries, of all of them without `names`."""
    return sum(value for name, value in seconds.items() if names is None or name in names)


def both(run: Run, names: tuple[str, ...] | None = None) -> float:
    """Seconds of stages and of work beside them."""
    return spent(run["stages_s"], names) + spent(run["beside_s"], names)


if __name__ == "__main__":
    sys.exit(main())
