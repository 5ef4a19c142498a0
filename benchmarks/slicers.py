"""How fast the dual-color job is beside common slicers that print the same shape in one color.

    python benchmarks/slicers.py [--repeat N] [--model NAME] [--data FOLDER] [--cura-definitions FOLDER] [--supports]
                                 [--json FILE] [--write]

Ours: from mesh arrays in memory to a written G-code file, textured, two colors. The others, PrusaSlicer and
CuraEngine: from an STL file to a written G-code file, in one color, with the same layers, walls, skins, infill and
skirt. They run in turns, each in a process of its own. What is not installed is left out, as are models whose files are
not there.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from benchmarks.models import MODELS  # noqa: E402
from benchmarks.tables import replace_table  # noqa: E402

DATA = HERE.parent.parent / "shared" / "data"
README = HERE / "README.md"
DEFINITIONS = Path("/usr/share/cura/resources/definitions")
# Where the picture becomes the pattern: what a slicer does not have.
PATTERN_STAGES = ("sampling", "texture", "tone", "modulation")
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
# What the definition of the printer works out from others only in Cura's own window is given here.
CURA_SETTINGS = {
    "machine_width": 250,
    "machine_depth": 250,
    "machine_height": 200,
    "machine_center_is_zero": "true",
    "layer_height": 0.25,
    "layer_height_0": 0.25,
    "wall_line_count": 2,
    "wall_thickness": 0.8,
    "top_layers": 3,
    "bottom_layers": 3,
    "infill_sparse_density": 10,
    "infill_line_distance": 4,
    "infill_pattern": "lines",
    "adhesion_type": "skirt",
    "skirt_gap": 6,
    **dict.fromkeys(("line_width", "wall_line_width", "wall_line_width_0", "wall_line_width_x", "skin_line_width",
                     "infill_line_width", "skirt_brim_line_width"), 0.4),
}  # fmt: skip
TITLES = {"ours": "ours", "supported": "+ supports, X3G", "prusa": "PrusaSlicer", "cura": "CuraEngine"}
START = """
import sys, time
sys.path.insert(0, {root!r})
import bpy
from launcher import load_package
began = time.process_time()
package = load_package()
package.register()
print(time.process_time() - began)
"""

Run = dict[str, Any]
Runs = dict[str, list[Run]]


def main() -> int:
    """Measure the models asked for and print the tables."""
    parser = argparse.ArgumentParser(description="Compare the dual-color job with slicers that print in one color.")
    parser.add_argument("--repeat", type=int, default=5, metavar="N", help="repetitions (default: 5)")
    parser.add_argument("--model", choices=tuple(MODELS), action="append", help="only this model; repeatable")
    parser.add_argument("--data", type=Path, default=DATA, metavar="FOLDER", help="holds meshes/")
    parser.add_argument("--cura-definitions", type=Path, default=DEFINITIONS, metavar="FOLDER", help="of fdmprinter")
    parser.add_argument("--supports", action="store_true", help="a second run of ours with supports and X3G")
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write all runs")
    parser.add_argument("--write", action="store_true", help="replace the table in README.md")
    args = parser.parse_args()
    runs: dict[str, Runs] = {}
    with tempfile.TemporaryDirectory() as folder:
        programs = contenders(Path(folder), args.cura_definitions, args.supports)
        print("measured:", ", ".join(TITLES[name] for name in programs))
        for name in args.model or MODELS:
            source = args.data / MODELS[name][0]
            if MODELS[name][0] and not source.is_file():
                print(f"{source} is not here: skipping {name}")
                continue
            subprocess.run([sys.executable, str(HERE / "models.py"), name, str(source), folder], check=True)
            runs[name] = measured(name, programs, args.repeat)
            print_tables(name, runs[name])
    started = start_seconds()
    print(f"\nimport and registration of the extension: {started:.2f} s")
    if args.json:
        args.json.write_text(json.dumps(runs, indent=1) + "\n", encoding="utf-8")
    if args.write:
        replace_table(README, "race", markdown(runs, started))
    return 0


def contenders(folder: Path, definitions: Path, supports: bool) -> dict[str, Callable[[str], Run]]:
    """What is installed: by name a function that runs it on a model in the folder."""
    programs: dict[str, Callable[[str], Run]] = {"ours": lambda name: run_ours(folder, name, False)}
    if supports:
        programs["supported"] = lambda name: run_ours(folder, name, True)
    if slicer := shutil.which("prusa-slicer"):
        programs["prusa"] = lambda name: run_prusa(slicer, folder, name)
    if (engine := shutil.which("CuraEngine")) and (definitions / "fdmprinter.def.json").is_file():
        programs["cura"] = lambda name: run_cura(engine, definitions, folder, name)
    return programs


def measured(name: str, programs: dict[str, Callable[[str], Run]], repeat: int) -> Runs:
    """All runs of all programs, taken in turns."""
    runs: Runs = {program: [] for program in programs}
    for _ in range(repeat):
        for program, run in programs.items():
            runs[program].append(run(name))
    return runs


def run_ours(folder: Path, name: str, supports: bool) -> Run:
    """One job of ours; with supports and an X3G file too if wished."""
    files = [folder / f"{name}.npz", folder / "ours.gcode", *([folder / "ours.x3g"] if supports else [])]
    command = [sys.executable, str(HERE / "job.py"), *map(str, files)]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    figures: Run = json.loads(done.stdout)
    return figures | {"bytes": files[1].stat().st_size}


def run_prusa(slicer: str, folder: Path, name: str) -> Run:
    """One run of PrusaSlicer, the start of its process included."""
    options = [f"--{key}={value}" for key, value in PRUSA_OPTIONS.items()]
    gcode = folder / "prusa.gcode"
    command = [slicer, "--export-gcode", *options, "--output", str(gcode), str(folder / f"{name}.stl")]
    return timed(command, gcode, b";LAYER_CHANGE")


def run_cura(engine: str, definitions: Path, folder: Path, name: str) -> Run:
    """One run of CuraEngine, the start of its process included."""
    options = [text for key, value in CURA_SETTINGS.items() for text in ("-s", f"{key}={value}")]
    gcode = folder / "cura.gcode"
    command = [engine, "slice", "-j", str(definitions / "fdmprinter.def.json"), *options]
    command += ["-l", str(folder / f"{name}.stl"), "-o", str(gcode)]
    search = f"{definitions}:{definitions.parent / 'extruders'}"
    return timed(command, gcode, b";LAYER:", os.environ | {"CURA_ENGINE_SEARCH_PATH": search})


def timed(command: list[str], gcode: Path, layer_mark: bytes, environment: dict[str, str] | None = None) -> Run:
    """Figures of a slicer's run."""
    began = perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)
    _, status, used = os.wait4(process.pid, 0)
    wall = perf_counter() - began
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise RuntimeError(f"{command[0]} ended with status {process.returncode}")
    peak = used.ru_maxrss / (1 << (20 if sys.platform == "darwin" else 10))
    text = gcode.read_bytes()
    return {
        "wall_s": wall, "cpu_s": used.ru_utime + used.ru_stime, "peak_mb": peak, "bytes": len(text),
        "layers": text.count(layer_mark), "moves": text.count(b"\nG1 "),
    }  # fmt: skip


def start_seconds() -> float:
    """Seconds of the processor that importing and registering the extension takes, median of five processes."""
    script = START.format(root=str(HERE.parent))
    with tempfile.TemporaryDirectory() as compiled:  # once for all, as an installed extension is
        environment = os.environ | {"PYTHONPYCACHEPREFIX": compiled, "PYTHONDONTWRITEBYTECODE": ""}
        command = [sys.executable, "-c", script]
        done = [subprocess.run(command, capture_output=True, text=True, env=environment) for _ in range(6)][1:]
    return median(float(each.stdout.split()[-1]) if not each.returncode else float("nan") for each in done)


def ratio(runs: Runs, other: str, key: str) -> float:
    """Ours through the other's, median over the pairs."""
    return median(mine[key] / theirs[key] for mine, theirs in zip(runs["ours"], runs[other], strict=True))


def of_all(runs: list[Run], key: str) -> float:
    """The median of a figure."""
    return float(median(run[key] for run in runs))


def print_tables(name: str, runs: Runs) -> None:
    """The comparison, and where our time goes."""
    ours = runs["ours"]
    print(f"\n{name}: medians of {len(ours)} runs")
    print(f"{'':17}{'wall s':>9}{'CPU s':>9}{'peak MB':>9}{'MB':>7}{'moves':>10}{'layers':>8}")
    for program, rows in runs.items():
        wall, cpu, peak, size = (of_all(rows, key) for key in ("wall_s", "cpu_s", "peak_mb", "bytes"))
        figures = f"{wall:9.2f}{cpu:9.2f}{peak:9.0f}{size / 1e6:7.1f}{rows[0]['moves']:10}{rows[0]['layers']:8}"
        print(f"{TITLES[program]:17}{figures}")
    for other in set(runs) & {"prusa", "cura"}:
        print(f"ours / {TITLES[other]}: wall {ratio(runs, other, 'wall_s'):.2f}, CPU {ratio(runs, other, 'cpu_s'):.2f}")
    print(", ".join(f"{stage} {share:.0%}" for stage, share in shares(ours).items()), flush=True)


def shares(ours: list[Run]) -> dict[str, float]:
    """Share of each stage in our time, medians."""
    return {
        stage: median(run["stages_s"][stage] / sum(run["stages_s"].values()) for run in ours)
        for stage in ours[0]["stages_s"]
    }


def markdown(runs: dict[str, Runs], started: float) -> str:
    """The tables for README.md."""
    others = [name for name in ("prusa", "cura") if name in next(iter(runs.values()))]
    rounds = len(next(iter(runs.values()))["ours"])
    lines = [f"Medians of {rounds} rounds; import and registration of the extension take {started:.2f} s.", ""]
    heads = ["model", "ours, s", "of it pattern"]
    heads += [f"{TITLES[name]}, s" for name in others]
    heads += [f"time / {TITLES[name]}" for name in others] + [f"CPU time / {TITLES[name]}" for name in others]
    heads += [f"MB held: {', '.join(TITLES[name] for name in ('ours', *others))}", "MB of G-code"]
    lines += [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for name, rows in runs.items():
        part = shares(rows["ours"])
        cells = [name, f"{of_all(rows['ours'], 'wall_s'):.1f}", f"{sum(part.get(s, 0) for s in PATTERN_STAGES):.0%}"]
        cells += [f"{of_all(rows[other], 'wall_s'):.1f}" for other in others]
        cells += [f"{ratio(rows, other, key):.2f}" for key in ("wall_s", "cpu_s") for other in others]
        cells += [", ".join(f"{of_all(rows[each], key) / unit:.0f}" for each in ("ours", *others))
                  for key, unit in (("peak_mb", 1), ("bytes", 1e6))]  # fmt: skip
        lines.append(f"| {' | '.join(cells)} |")
    stages = list(next(iter(runs.values()))["ours"][0]["stages_s"])
    lines += [
        "",
        "Share of each stage in our time:",
        "",
        f"| | {' | '.join(stages)} |",
        "|---" * (len(stages) + 1) + "|",
    ]
    for name, rows in runs.items():
        lines.append(f"| {name} | {' | '.join(f'{share:.0%}' for share in shares(rows['ours']).values())} |")
    return "\n".join([*lines, ""])


if __name__ == "__main__":
    sys.exit(main())
