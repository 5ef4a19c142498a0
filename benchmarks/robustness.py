"""What becomes of broken meshes, and whether the slices agree with the meshes: the tables of docs/robustness.md.

    python benchmarks/robustness.py [--data FOLDER] [--out FILE] [NAME ...]

Every file of the test data's folder nasty/ is printed twice, as large as it is in the file and 20 mm high; all clean
meshes are sliced at 40 mm. In each, random points are held against the winding number that six rays count. Each file
has a process of its own, so that one that crashes or hangs is seen. Needs the modules of the command line (bpy).
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from benchmarks.tables import replace_table  # noqa: E402

DATA = ROOT.parent / "shared" / "data"
OUT = ROOT / "docs" / "robustness.md"
KINDS = (".obj", ".stl", ".ply", ".glb")
NASTY_MM, CLEAN_MM = 20.0, 40.0
LOWER_MM = {"colored_airplane": 25.0, "sign_base": 2.5, "sign_base_rounded": 2.5}
POINTS = 10_000
TIMEOUT_S = 300
UP = {"wingnut": "z", "distorted_a": "z", "colored_airplane": "y"}


def main() -> int:
    """Try all files, or those that were named, and write the tables."""
    parser = argparse.ArgumentParser(description="Print broken meshes and compare slices with meshes.")
    parser.add_argument("--data", type=Path, default=DATA, metavar="FOLDER", help="holds meshes/ and nasty/")
    parser.add_argument("--out", type=Path, default=OUT, metavar="FILE", help="Markdown file whose tables are replaced")
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("names", nargs="*", metavar="NAME", help="files (default: all, and the tables are written)")
    args = parser.parse_args()
    if args.one:
        print(json.dumps(tried(Path(args.names[0]))))
        return 0
    tables = {"outcomes": OUTCOME_HEAD, "points": POINT_HEAD}
    bad = 0
    for path in files(args.data):
        if args.names and path.name not in args.names:
            continue
        found = in_a_process(path)
        bad += not is_kind(found)
        rows = {"points": point_row(path, found)}
        if is_nasty(path):
            rows["outcomes"] = outcome_row(path, found)
        for name, row in rows.items():
            tables[name] += row
        print("".join(rows.values()), end="", flush=True)
    if not args.names:
        for name, table in tables.items():
            replace_table(args.out, name, table)
    print(f"{bad} unkind outcomes")
    return 1 if bad else 0


def files(data: Path) -> list[Path]:
    """The clean meshes, then the nasty ones, each in alphabetical order."""
    return [
        path
        for folder in ("meshes", "nasty")
        for path in sorted((data / folder).rglob("*"), key=lambda path: path.name.lower())
        if path.suffix.lower() in KINDS
    ]


def is_nasty(path: Path) -> bool:
    """Whether a file is one of the broken ones."""
    return "nasty" in path.parts


def in_a_process(path: Path) -> dict[str, Any]:
    """The figures of a file; how the process ended if it did not give any."""
    command = [sys.executable, str(Path(__file__).resolve()), "--one", str(path)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S)
    except subprocess.TimeoutExpired:
        return {"bug": f"no end after {TIMEOUT_S} s"}
    if done.returncode:
        return {"bug": (done.stderr.strip().splitlines() or [f"status {done.returncode}"])[-1]}
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def tried(path: Path) -> dict[str, Any]:
    """What a file becomes: as it is and scaled; the points of the scaled one."""
    from launcher import load_package

    load_package()
    found = {"as it is": printed(path, None)[0]} if is_nasty(path) else {}
    if is_nasty(path):
        found["scaled"], result = printed(path, NASTY_MM)
        mesh, cut = (result.mesh, result.slices) if result else (None, None)
    else:
        mesh, cut = sliced(path, LOWER_MM.get(path.stem, CLEAN_MM))
    if cut is not None:
        from dualcolor.tests.robustness.winding import agreement

        found["points"] = vars(agreement(mesh, cut, POINTS))
    return found


def printed(path: Path, height_mm: float | None) -> tuple[dict[str, Any], Any]:
    """What the whole job says about a file, and the print if there is one; only refusals are caught."""
    from dualcolor.core.errors import PrintError
    from dualcolor.core.pipeline import generate
    from dualcolor.core.settings import PrintSettings
    from dualcolor.tests.printing import gcode_text

    try:
        result = generate(model_of(path, height_mm), PrintSettings())
        gcode_text(result.moves, result.settings, [])
    except PrintError as problem:
        return {"refused": str(problem).replace(f"{path.parent}/", "")}, None
    return {"layers": result.report["layers"], "warnings": result.warnings}, result


def sliced(path: Path, height_mm: float) -> tuple[Any, Any]:
    """Mesh and slices of a clean file."""
    from dualcolor.core.mesh.triangles import triangulate
    from dualcolor.core.settings import PrintSettings
    from dualcolor.core.slicing.slices import slices

    settings = PrintSettings()
    mesh = triangulate(model_of(path, height_mm), settings)
    return mesh, slices(mesh, settings)


def model_of(path: Path, height_mm: float | None) -> Any:
    """A file as the command line reads it."""
    import bpy
    from dualcolor.bridge.input.mesh_input import surface_model
    from dualcolor.bridge.input.model_file import open_model
    from dualcolor.bridge.quiet import quiet_stdout
    from dualcolor.core.settings import PrintSettings

    with quiet_stdout():
        obj = open_model(path, up=UP.get(path.stem, ""), height_mm=height_mm)
        return surface_model(obj, bpy.context.evaluated_depsgraph_get(), PrintSettings())


def is_kind(found: dict[str, Any]) -> bool:
    """Whether nothing went wrong: no bug, no point on the other side."""
    return "bug" not in found and not found.get("points", {}).get("disagreements", 0)


OUTCOME_HEAD = "| file | as large as in the file | 20 mm high |\n|---|---|---|\n"
POINT_HEAD = (
    "| mesh | points | in layers said to be open | unambiguous | of these inside | disagreements |\n"
    "|---|---|---|---|---|---|\n"
)


def outcome_row(path: Path, found: dict[str, Any]) -> str:
    """What is printed or the sentence with which it is refused."""
    if "bug" in found:
        return f"| {path.name} | **{found['bug']}** | |\n"
    return f"| {path.name} | {said(found['as it is'])} | {said(found['scaled'])} |\n"


def said(outcome: dict[str, Any]) -> str:
    """One cell."""
    if "refused" in outcome:
        return f"refused: {outcome['refused']}".replace("|", "/")
    texts = [text for text in outcome["warnings"] if "no texture" not in text]
    return "; ".join([f"{outcome['layers']} layers", *texts]).replace("|", "/")


def point_row(path: Path, found: dict[str, Any]) -> str:
    """How many points agree."""
    points = found.get("points")
    if not points:
        return f"| {path.name} | {'**' + found['bug'] + '**' if 'bug' in found else 'refused'} | | | |\n"
    cells = [
        path.name,
        *(f"{points[key]:,}" for key in ("tried", "left_out", "unambiguous", "inside", "disagreements")),
    ]
    return f"| {' | '.join(cells)} |\n"


if __name__ == "__main__":
    sys.exit(main())
