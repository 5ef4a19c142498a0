"""How much longer two colors take than one: the paper's table of print times, by the model of the printer's planner.

    python benchmarks/print_times.py [--data FOLDER] [--out FILE] [--set KEY=VALUE ...]

Prints the table and writes it as Markdown. The meshes are not part of this repository.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from launcher import load_package  # noqa: E402

load_package()
import numpy as np  # noqa: E402
from dualcolor.benchmarks.models import obj_triangles, scaled  # noqa: E402
from dualcolor.benchmarks.tables import replace_table  # noqa: E402
from dualcolor.core.model import SurfaceModel  # noqa: E402
from dualcolor.core.pipeline import generate  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.core.settings.presets import preset_values  # noqa: E402

DATA = ROOT.parent / "shared" / "data"
OUT = ROOT / "docs" / "print_times.md"
HEIGHTS_MM = {"gargoyle": 102.0, "kitten": 54.0}
PAPER = preset_values(["paper"])
UNLIMITED = {"max_curve_acceleration": 20000, "min_move_time": 0, "wave_speed": 40}
VARIANTS: dict[str, dict[str, Any]] = {
    "default settings": {},
    "with supports": {"support_enable": True},
    "preset `paper`": PAPER,
    "preset `paper`, curves as the firmware allows": PAPER | UNLIMITED,
}
SPOT_MM = 20.0
HEAD = (
    "| object | settings | layers | single color | dual color | ratio | with tower | ratio "
    "| waved wall | tool changes |\n"
    "|---|---|---|---|---|---|---|---|---|---|\n"
)


def main() -> int:
    """Measure all objects that are there and write the table."""
    parser = argparse.ArgumentParser(description="Compare print times in two colors and in one.")
    parser.add_argument("--data", type=Path, default=DATA, metavar="FOLDER", help="holds meshes/nc/*.obj")
    parser.add_argument("--out", type=Path, default=OUT, metavar="FILE", help="Markdown file whose table is replaced")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="a setting for all rows")
    args = parser.parse_args()
    changes = dict(text.split("=", 1) for text in args.set)
    lines = []
    for name, height in HEIGHTS_MM.items():
        path = args.data / "meshes" / "nc" / f"{name}.obj"
        if not path.is_file():
            print(f"{path} is not here: skipping it", file=sys.stderr)
            continue
        for title, values in VARIANTS.items():
            lines.append(row(name, title, path, height, PrintSettings().changed(changes | values)))
            print(lines[-1], flush=True)
    if lines:
        replace_table(args.out, "print_times", HEAD + "\n".join(lines) + "\n")
    return 0


def row(name: str, title: str, path: Path, height: float, settings: PrintSettings) -> str:
    """One line of the table: the object without and with the tower."""
    model = read_model(path, height)
    bare = generate(model, settings.changed({"tower_type": "none"})).report
    towered = generate(model, settings.changed({"tower_type": "w"})).report["time_s"]
    time = bare["time_s"]
    cells = [
        f"{name} {height:g} mm", title, str(bare["layers"]), minutes(time["single_color"]), minutes(time["total"]),
        f"{time['ratio']:.2f}", minutes(towered["total"]), f"{towered['total'] / time['single_color']:.2f}",
        minutes(time["features"]["outer_wall"]), minutes(time["tool_change"]),
    ]  # fmt: skip
    return f"| {' | '.join(cells)} |"


def read_model(path: Path, height: float) -> SurfaceModel:
    """A mesh with a tone at every corner: soft spots from black to white."""
    points, faces = obj_triangles(path)
    start, texture = np.arange(len(faces) + 1) * 3, np.full(len(faces), -1, dtype=np.int64)
    vertices = scaled(points, height)
    tone = 0.5 + 0.5 * np.sin(vertices * (2 * np.pi / SPOT_MM)).prod(axis=1)
    return SurfaceModel(vertices, start, faces.ravel(), None, tone[faces.ravel()], texture, (), path.stem)


def minutes(seconds: float) -> str:
    """As hours and minutes."""
    hours, rest = divmod(round(seconds / 60), 60)
    return f"{hours} h {rest:02d} min" if hours else f"{rest} min"


if __name__ == "__main__":
    sys.exit(main())
