"""Every mesh of the test data as X3G, held against GPX, the converter that owners of these printers use.

    python benchmarks/x3g.py [--data FOLDER] [--out FILE] [--set KEY=VALUE ...] [NAME ...]

Each is printed whole, with supports, written as G-code and as X3G; GPX converts the G-code. The time that the program
estimates is held against a simulation of the X3G. Prints a table and writes it as Markdown. Needs the modules of the
command line (bpy) and the program gpx. The meshes are not part of this repository.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from launcher import load_package  # noqa: E402

load_package()
import numpy as np  # noqa: E402
from dualcolor.benchmarks.tables import replace_table  # noqa: E402
from dualcolor.core.model import FloatArray, SurfaceModel  # noqa: E402
from dualcolor.core.paths import Feature  # noqa: E402
from dualcolor.core.pipeline import DualColorPrint, generate  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.core.settings.printer import PrinterProfile  # noqa: E402
from dualcolor.core.x3g.audit import audit  # noqa: E402
from dualcolor.core.x3g.commands import Action, Command  # noqa: E402
from dualcolor.core.x3g.reader import Commands, read_x3g  # noqa: E402
from dualcolor.core.x3g.writer import x3g_bytes  # noqa: E402
from dualcolor.tests.core.x3g.x3g_simulation import print_seconds  # noqa: E402
from dualcolor.tests.gpx import convert, installed  # noqa: E402
from dualcolor.tests.printing import gcode_text  # noqa: E402

DATA = ROOT.parent / "shared" / "data"
OUT = ROOT / "docs" / "x3g.md"
KINDS = (".glb", ".obj", ".ply", ".stl")
# Those whose up axis is not the usual one of their kind of file.
UP = {"wingnut": "z", "distorted_a": "z", "colored_airplane": "y"}
# The plates are printed as large as they are; all else has the height of a usual print, mm.
HEIGHT_MM = {"gargoyle": 102.0, "kitten": 54.0, "sign_base": None, "sign_base_rounded": None, "3DBenchy": 48.0}
USUAL_HEIGHT_MM = 80.0
LOWER_MM = {"colored_airplane": 25.0, "branches_70": 60.0, "Fox": 60.0}


@dataclass(frozen=True)
class Comparison:
    """Our X3G of a print beside GPX's.

    Attributes:
        diagnostics: what GPX says about the G-code.
        moves: in our file.
        equal_moves: of them, equal to GPX's at the same place in the row of moves.
        same_heaters: whether temperatures and waits agree.
        same_bytes: whether the files are equal.
        tool_changes: between strands of the print.
        findings: of the audit.
        simulated_s: s that the X3G takes.
    """

    diagnostics: list[str]
    moves: int
    equal_moves: int
    same_heaters: bool
    same_bytes: bool
    tool_changes: int
    findings: list[str]
    simulated_s: float


HEAD = (
    "| mesh | mm | layers | changes | moves | GPX says | equal moves | heaters | same bytes "
    "| audit | time | simulated |\n"
    "|---|---|---|---|---|---|---|---|---|---|---|---|\n"
)


def main() -> int:
    """Compare all meshes, or those that were asked for, and write the table."""
    parser = argparse.ArgumentParser(description="Hold our X3G of real meshes against GPX's.")
    parser.add_argument("--data", type=Path, default=DATA, metavar="FOLDER", help="holds meshes/")
    parser.add_argument("--out", type=Path, default=OUT, metavar="FILE", help="Markdown file whose table is replaced")
    parser.add_argument("--set", action="append", default=["support_enable=true"], metavar="KEY=VALUE")
    parser.add_argument("names", nargs="*", metavar="NAME", help="meshes (default: all, and the table is written)")
    args = parser.parse_args()
    if not installed():
        print("gpx is not installed", file=sys.stderr)
        return 1
    settings = PrintSettings().changed(dict(text.split("=", 1) for text in args.set))
    lines = []
    perfect = True
    for path in meshes(args.data):
        if args.names and path.stem not in args.names:
            continue
        result = generate(model_of(path, height_of(path)), settings)
        comparison = compared(result)
        perfect &= comparison.same_bytes and not comparison.diagnostics and not comparison.findings
        perfect &= abs(result.report["time_s"]["total"] / comparison.simulated_s - 1) <= 0.05
        lines.append(row(path, result, comparison))
        print(lines[-1], *comparison.diagnostics, *comparison.findings, sep="\n  ", flush=True)
    if lines and not args.names:
        replace_table(args.out, "x3g", HEAD + "\n".join(lines) + "\n")
    return 0 if perfect else 1


def meshes(data: Path) -> list[Path]:
    """All meshes of the test data that the program reads, in alphabetical order."""
    found = [path for path in (data / "meshes").rglob("*") if path.suffix.lower() in KINDS]
    return sorted(found, key=lambda path: path.stem.lower())


def height_of(path: Path) -> float | None:
    """Mm that a mesh is printed high, None for the size in its file."""
    return (LOWER_MM | HEIGHT_MM).get(path.stem, USUAL_HEIGHT_MM)


def model_of(path: Path, height_mm: float | None) -> SurfaceModel:
    """A mesh with its own picture, as the command line reads it."""
    import bpy
    from dualcolor.bridge.input.mesh_input import surface_model
    from dualcolor.bridge.input.model_file import open_model
    from dualcolor.bridge.quiet import quiet_stdout

    with quiet_stdout():
        obj = open_model(path, up=UP.get(path.stem, ""), height_mm=height_mm)
        return surface_model(obj, bpy.context.evaluated_depsgraph_get(), PrintSettings())


def compared(result: DualColorPrint) -> Comparison:
    """Write a print as G-code and X3G, let GPX convert the G-code, and compare."""
    settings = result.settings
    printer = settings.printer_profile
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "part.gcode"
        path.write_bytes(gcode_text(result.moves, settings, []))
        diagnostics = convert(path, printer.gpx_machine)
        theirs = path.with_suffix(".x3g").read_bytes() if path.with_suffix(".x3g").exists() else b""
    mine = x3g_bytes(result.moves, settings, "part")
    commands = read_x3g(mine)
    others = read_x3g(theirs) if theirs else commands
    moves, equal = equal_moves(commands, others)
    return Comparison(
        diagnostics=diagnostics,
        moves=moves,
        equal_moves=equal if theirs else 0,
        same_heaters=bool(theirs) and heater_commands(commands) == heater_commands(others),
        same_bytes=mine == theirs,
        tool_changes=changes_between_strands(commands, printer),
        findings=audit(commands, printer, tower_box(result)),
        simulated_s=print_seconds(commands),
    )


def equal_moves(commands: Commands, others: Commands) -> tuple[int, int]:
    """How many moves the longer of two files has, and how many are equal at the same place, tool included."""
    first, second = (
        [(data, tool) for data, tool in zip(move_bytes(file), file.tool[file.moves].tolist(), strict=True)]
        for file in (commands, others)
    )
    return max(len(first), len(second)), sum(a == b for a, b in zip(first, second, strict=False))


def move_bytes(file: Commands) -> list[bytes]:
    """The bytes of each command that moves."""
    data, rows = file.data.tobytes(), np.flatnonzero(file.moves)
    ends = np.append(file.offset, len(file.data))
    return [data[begin:end] for begin, end in zip(ends[rows].tolist(), ends[rows + 1].tolist(), strict=True)]


def heater_commands(file: Commands) -> list[bytes]:
    """The commands that set temperatures or wait for them, in order."""
    data, ends = file.data.tobytes(), np.append(file.offset, len(file.data)).tolist()
    heating = (Command.TOOL_ACTION, Command.WAIT_FOR_TOOL, Command.WAIT_FOR_BED)
    rows = np.flatnonzero(np.isin(file.code, heating)).tolist()
    found = [data[ends[row] : ends[row + 1]] for row in rows]
    targets = (Action.NOZZLE_TEMPERATURE, Action.BED_TEMPERATURE)
    return [command for command in found if command[0] != Command.TOOL_ACTION or command[2] in targets]


def changes_between_strands(commands: Commands, printer: PrinterProfile) -> int:
    """How often a strand of the print has another tool than the one before it; priming lines do not count."""
    way = commands.way
    behind = commands.steps[:, 1] / printer.steps_per_mm[1] > max(printer.prime_y) + 0.5
    strand = (np.abs(way[:, :2]) > 1).any(axis=1) & (way[:, 3:].min(axis=1) < 0) & behind
    return int((np.diff(commands.tool[strand]) != 0).sum())


def tower_box(result: DualColorPrint) -> FloatArray | None:
    """(2, 2) mm, the least and the greatest X and Y of the tower's strands, None without a tower."""
    of_tower = result.moves.position[result.moves.feature == Feature.TOWER, :2]
    return np.array([of_tower.min(axis=0), of_tower.max(axis=0)]) if len(of_tower) else None


def row(path: Path, result: DualColorPrint, comparison: Comparison) -> str:
    """One line of the table."""
    low, high = result.mesh.bounds
    estimate = result.report["time_s"]["total"]
    difference = estimate / comparison.simulated_s - 1
    cells = [
        path.name,
        " × ".join(f"{side:.0f}" for side in high - low),
        str(result.report["layers"]),
        str(comparison.tool_changes),
        f"{comparison.moves:,}",
        str(len(comparison.diagnostics) or "nothing"),
        "all" if comparison.equal_moves == comparison.moves else f"{comparison.equal_moves:,}",
        "equal" if comparison.same_heaters else "differ",
        "yes" if comparison.same_bytes else "no",
        str(len(comparison.findings) or "finds nothing"),
        f"{estimate / 60:.0f} min",
        f"{difference:+.1%}" if abs(difference) >= 0.001 else "within 0.1 %",
    ]
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    sys.exit(main())
