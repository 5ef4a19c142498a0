"""Time and memory of large jobs: `python benchmarks/scale.py [--case NAME] [--plot FILE]`.

Spheres from small to large give the plot over decades of layers × outline length; then single cases: 2 million
triangles, 1,600 layers, a texture of 8192², 500 islands a layer, a bed full of objects. Each job has a process of its
own.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path
from time import perf_counter
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from benchmarks.tables import replace_table  # noqa: E402

PLOT = ROOT / "docs" / "images" / "scale.png"
README = ROOT / "benchmarks" / "README.md"
MOST_MB = 2000
_UPPER = 3
# Diameter in mm, layer height in mm, subdivisions: layers × outline from 0.2 m to 2 km.
LADDER = {"ladder 1": (2.5, 0.4, 3), "ladder 2": (6.0, 0.3, 4), "ladder 3": (14.0, 0.25, 5), "ladder 4": (32.0, 0.2, 5),
          "ladder 5": (64.0, 0.15, 6), "ladder 6": (120.0, 0.1, 7)}  # fmt: skip
CASES = ("2 million triangles", "1,600 layers", "texture 8192²", "500 islands", "full bed")


def main() -> int:
    """Run all cases or some, plot the ladder, and write the table."""
    parser = argparse.ArgumentParser(description="Measure large jobs.")
    parser.add_argument("--case", action="append", metavar="NAME", help="only this case; repeatable")
    parser.add_argument("--plot", type=Path, default=PLOT, metavar="FILE", help="PNG of time and memory")
    parser.add_argument("--one", metavar="NAME", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.one:
        print(json.dumps(measured(args.one)))
        return 0
    rows = {}
    for name in args.case or (*LADDER, *CASES):
        done = subprocess.run([sys.executable, __file__, "--one", name], stdout=subprocess.PIPE, text=True)
        rows[name] = json.loads(done.stdout.splitlines()[-1]) if not done.returncode else {}
        print(row(name, rows[name]), flush=True)
    if not args.case:
        ladder = [rows[name] for name in LADDER]
        plotted(ladder, args.plot)
        print(stated(ladder), end="")
        replace_table(README, "scale", markdown(rows, ladder))
    return 0 if all(each.get("peak_mb", MOST_MB) < MOST_MB for each in rows.values()) else 1


def measured(name: str) -> dict[str, Any]:
    """Figures of one job, from arrays in memory to G-code on the disk."""
    from launcher import load_package

    load_package()
    from dualcolor.core.exports import export_gcode
    from dualcolor.core.pipeline import generate

    from benchmarks.job import peak_mb

    model, settings = job_of(name)
    began, cpu = perf_counter(), os.times()
    result = export_gcode(generate(model, settings, begin_gcode=True), Path(os.devnull))
    wall, now = perf_counter() - began, os.times()
    lines = result.outlines
    return {
        "triangles": len(result.mesh.faces),
        "layers": result.report["layers"],
        "outline_m": outline_meters(lines),
        "moves": result.report["gcode"]["moves"],
        "wall_s": wall,
        "cpu_s": now.user + now.system - cpu.user - cpu.system,
        "peak_mb": peak_mb(),
        "stages_s": result.report["stages_s"],
    }


def outline_meters(lines: Any) -> float:
    """Length of the outlines of all layers together, which is layers times the outline of one."""
    import numpy as np
    from dualcolor.core.ragged import following

    ahead = following(lines.start)
    return float(np.linalg.norm(lines.base[ahead] - lines.base, axis=1).sum() / 1000)


def job_of(name: str) -> tuple[Any, Any]:
    """Model and settings of a case."""
    import numpy as np
    from dualcolor.core.settings import PrintSettings

    from benchmarks.models import bumpy_sphere, picture, scaled

    if name in LADDER:
        size, height, subdivisions = LADDER[name]
        points, faces = bumpy_sphere(subdivisions)
        return surface(scaled(points, size), faces, picture()), settings_of(PrintSettings(), height)
    if name == "2 million triangles":
        points, faces = bumpy_sphere(8)
        more = scaled(points, 60.0)
        return surface(*beside(more, faces, [(-35, 0), (35, 0)]), picture()), PrintSettings()
    if name == "1,600 layers":
        points, faces = bumpy_sphere(6)
        points = scaled(points, 149.9) * (0.25, 0.25, 1.0)
        return surface(points, faces, picture()), settings_of(PrintSettings(), 0.0937)  # the printer is 150 mm high
    if name == "texture 8192²":
        points, faces = bumpy_sphere(6)
        return surface(scaled(points, 100.0), faces, np.tile(picture(), (4, 4))), PrintSettings()
    full = PrintSettings(tower_type="none")
    points, faces = bumpy_sphere(3 if name == "500 islands" else 5)
    if name == "500 islands":
        grid = [(x * 7.5 - 93, y * 6.0 - 57) for x in range(25) for y in range(20)]
        return surface(*beside(scaled(points, 4.6), faces, grid), picture()), full
    grid = [(x * 34 - 85, y * 34 - 51) for x in range(6) for y in range(4)]
    return surface(*beside(scaled(points, 30.0), faces, grid), picture()), full


def settings_of(settings: Any, height: float) -> Any:
    """Settings with another layer height."""
    return settings.changed({"layer_height": height, "first_layer_height": height})


def beside(points: Any, faces: Any, places: list[tuple[float, float]]) -> tuple[Any, Any]:
    """The same mesh at several places of the bed."""
    import numpy as np

    all_points = np.concatenate([points + np.array([x, y, 0]) for x, y in places])
    return all_points, np.concatenate([faces + len(points) * number for number in range(len(places))])


def surface(points: Any, faces: Any, tone: Any) -> Any:
    """The job's input: triangles with a picture wrapped around them."""
    import numpy as np
    from dualcolor.core.model import SurfaceModel, ToneImage

    from benchmarks.models import wrapped_uv

    start, texture = np.arange(len(faces) + 1) * 3, np.zeros(len(faces), dtype=np.int64)
    image = ToneImage(tone, np.ones_like(tone))
    return SurfaceModel(points, start, faces.ravel(), wrapped_uv(points, faces), None, texture, (image,), "scale")


def row(name: str, figures: dict[str, Any]) -> str:
    """One line of the table."""
    if not figures:
        return f"| {name} | failed | | | | | |"
    keys = ("triangles", "layers", "outline_m", "moves")
    counts = " | ".join(f"{figures[key]:,.0f}" if figures[key] >= 10 else f"{figures[key]:.2g}" for key in keys)
    return f"| {name} | {counts} | {figures['cpu_s']:.1f} | {figures['peak_mb']:,.0f} |"


def slopes(ladder: list[dict[str, Any]], most: int) -> dict[str, float]:
    """Slope of time and memory over outline length, both logarithmic, over the largest jobs of the ladder."""
    import numpy as np

    upper = [each for each in ladder if each][-most:]
    length = np.log([each["outline_m"] for each in upper])
    return {key: float(np.polyfit(length, np.log([each[key] for each in upper]), 1)[0]) for key in ("cpu_s", "peak_mb")}


def stated(ladder: list[dict[str, Any]]) -> str:
    """The slopes in a sentence."""
    whole, upper = slopes(ladder, len(LADDER)), slopes(ladder, _UPPER)
    return (
        "Slopes over layers × outline length, both axes logarithmic (1 is linear): over the whole ladder time "
        f"{whole['cpu_s']:.2f}, memory {whole['peak_mb']:.2f};\nover its upper half, where what every job takes counts "
        f"less, time {upper['cpu_s']:.2f}, memory {upper['peak_mb']:.2f}.\n"
    )


def markdown(rows: dict[str, dict[str, Any]], ladder: list[dict[str, Any]]) -> str:
    """Table and slopes for README.md."""
    head = "| job | triangles | layers | outlines, m | moves | CPU s | MB held |\n" + "|---" * 7 + "|\n"
    lines = "\n".join(row(name, figures) for name, figures in rows.items())
    return f"{head}{lines}\n\n{stated(ladder)}"


def plotted(ladder: list[dict[str, Any]], path: Path) -> None:
    """Time and memory over layers × outline length, both axes logarithmic."""
    from math import log10

    from PIL import Image, ImageDraw, ImageFont

    width, height, left, top, right, bottom = 900, 520, 80, 30, 820, 460
    image = Image.new("RGB", (width, height), "white")
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(15)
    low_x, high_x, low_y, high_y = -2, 3, -1, 4
    dots = [each for each in ladder if each]

    def at(x: float, y: float) -> tuple[float, float]:
        across = (log10(x) - low_x) / (high_x - low_x)
        up = (log10(y) - low_y) / (high_y - low_y)
        return left + across * (right - left), bottom - up * (bottom - top)

    for power in range(low_x, high_x + 1):
        x = at(10.0**power, 1)[0]
        draw.line([(x, top), (x, bottom)], "#dddddd")
        draw.text((x, bottom + 8), f"{10.0**power:g} m", "black", font, anchor="mt")
    for power in range(low_y, high_y + 1):
        y = at(1, 10.0**power)[1]
        draw.line([(left, y), (right, y)], "#dddddd")
        draw.text((left - 8, y), f"{10.0**power:g}", "black", font, anchor="rm")
    found = slopes(ladder, _UPPER)
    for key, color, title in (("cpu_s", "#b03020", "CPU seconds"), ("peak_mb", "#2050a0", "MB held")):
        line = [at(each["outline_m"], each[key]) for each in dots]
        draw.line(line, color, 3)
        for x, y in line:
            draw.ellipse([x - 5, y - 5, x + 5, y + 5], color)
        draw.text((line[-1][0] - 10, line[-1][1] - 22), f"{title}, slope {found[key]:.2f}", color, font, anchor="rm")
    draw.text(((left + right) / 2, height - 14), "outline length of all layers together", "black", font, anchor="mm")
    path.parent.mkdir(parents=True, exist_ok=True)
    image.save(path, optimize=True)


if __name__ == "__main__":
    sys.exit(main())
