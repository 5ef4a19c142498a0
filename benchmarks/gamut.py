"""The search for the pattern with the widest range of tones: each candidate printed in the computer and measured.

    python benchmarks/gamut.py [--out FILE]

Prints a table and writes it as Markdown; two minutes on two cores.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from launcher import load_package  # noqa: E402

load_package()
import bpy  # noqa: E402
import numpy as np  # noqa: E402
from dualcolor.benchmarks.tables import replace_table  # noqa: E402
from dualcolor.bridge.measuring.gonioreflectometer import bare  # noqa: E402
from dualcolor.bridge.measuring.instrument import Face, mounted  # noqa: E402
from dualcolor.bridge.quiet import quiet_stdout  # noqa: E402
from dualcolor.core.calibration.tile import step_tile  # noqa: E402
from dualcolor.core.model import SurfaceModel  # noqa: E402
from dualcolor.core.paths import Feature  # noqa: E402
from dualcolor.core.pipeline import generate  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.core.strands.settling import settled  # noqa: E402
from dualcolor.core.strands.strands import strands  # noqa: E402
from dualcolor.core.toolpaths.moves import Moves  # noqa: E402

OUT = ROOT / "docs" / "gamut.md"
TONES = (0.0, 0.25, 0.5, 0.75, 1.0)
DISTANCE_MM, BLUR_ARCMIN = 700.0, 1.0
FREE = {"max_unsupported": 3.0, "calibration": "none"}
MM_PER_PIXEL = 0.07
SAMPLES = 4


def waves(deepest: float, least: float, back: float = 0.0, onset: float = 0.0) -> dict[str, Any]:
    """Settings of a pattern with waves."""
    kind = "wave_offset" if back else "wave"
    both = {"pattern": kind, "sampling": "paper", "wave_depth_max": deepest, "wave_depth_min": least}
    return both | {"offset_max": back, "offset_onset": onset}


CANDIDATES: dict[str, dict[str, Any]] = {
    "waves 0.75 to 0.375 (the paper)": waves(0.75, 0.375),
    "waves 1.5 to 0.75": waves(1.5, 0.75),
    "waves 0.75 to 0": waves(0.75, 0.0),
    "waves 0.75 to 0.375, set back 0.3": waves(0.75, 0.375, 0.3),
    "waves 0.75 to 0, set back 0.3": waves(0.75, 0.0, 0.3),
    "waves 0.75 to 0, set back 0.3 from attenuation 0.5": waves(0.75, 0.0, 0.3, 0.5),
    "waves 0.3 to 0, set back 0.3": waves(0.3, 0.0, 0.3),
    "waves 0.1 to 0, set back 0.3": waves(0.1, 0.0, 0.3),
    "waves 0.1 to 0.1, set back 0.3": waves(0.1, 0.1, 0.3),
    "set back 0.2": {"pattern": "offset", "offset_max": 0.2},
    "set back 0.3": {"pattern": "offset", "offset_max": 0.3},
    "set back 0.35 (the default)": {"pattern": "offset", "offset_max": 0.35},
    "set back 0.35 from attenuation 0.3": {"pattern": "offset", "offset_max": 0.35, "offset_onset": 0.3},
    "set back 0.4": {"pattern": "offset", "offset_max": 0.4},
    "set back 0.5": {"pattern": "offset", "offset_max": 0.5},
    "set back 0.7": {"pattern": "offset", "offset_max": 0.7},
}
HEAD = "| pattern | range | of the paper's | unsupported, mm | contrast | time |\n|---|---|---|---|---|---|\n"


def main() -> int:
    """Measure all candidates and write the page."""
    parser = argparse.ArgumentParser(description="Search for the pattern with the widest range of tones.")
    parser.add_argument("--out", type=Path, default=OUT, metavar="FILE", help="Markdown file whose table is replaced")
    args = parser.parse_args()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    lines: list[str] = []
    papers = 0.0
    for name, values in CANDIDATES.items():
        settings = PrintSettings().changed(values | FREE)
        with quiet_stdout():
            dark, light, unsupported, contrast = measured(settings)
            time = time_ratio(settings)
        papers = papers or light - dark
        share = (light - dark) / papers
        cells = [name, f"{dark:.2f} to {light:.2f}", f"{share:.1f}", f"{unsupported:.2f}", f"{contrast:.2f}"]
        lines.append(f"| {' | '.join(cells)} | {time:.2f} |")
        print(lines[-1], flush=True)
    replace_table(args.out, "gamut", HEAD + "\n".join(lines) + "\n")
    return 0


def measured(settings: PrintSettings) -> tuple[float, float, float, float]:
    """Reflectance of black and of white, most that a strand stands out (mm), and the greatest contrast of a tone."""
    seen, unsupported, contrast = [], [], []
    for tone in TONES:
        tile = step_tile(0.0, settings.layer_height, np.array([tone, tone]))
        result = generate(tile.model, bare(settings))
        center = (result.mesh.bounds[0] + tile.center).tolist()
        face = Face((center[0], center[1], center[2]), 9.6, tile.height)
        with mounted(result.moves, result.settings, face) as stand:
            picture = stand.photograph(mm_per_pixel=MM_PER_PIXEL, samples=SAMPLES).astype(np.float64)
        seen.append(float(picture.mean()))
        unsupported.append(stands_out(result.moves, face))
        contrast.append(contrast_left(picture, 9.6 / picture.shape[1]))
    return seen[0], seen[-1], max(unsupported), max(contrast)


def stands_out(moves: Moves, face: Face) -> float:
    """Most that the middle of a strand of the face lies outside what is below it, mm."""
    laid = settled(strands(moves), 0.0)
    off = np.abs(laid.points - np.array(face.center))
    near = (off[:, 0] < face.width / 2) & (off[:, 1] < 2.0) & (off[:, 2] < face.height / 2)
    wall = np.repeat(laid.feature == Feature.OUTER_WALL, np.diff(laid.start))
    return float(laid.unsupported[near & wall].max(initial=0.0))


def contrast_left(picture: np.ndarray, mm: float) -> float:
    """Standard deviation over mean of what the eye's blur leaves of a picture that repeats itself."""
    sigma = DISTANCE_MM * math.tan(math.radians(BLUR_ARCMIN / 60)) / math.sqrt(8 * math.log(2))
    up, across = (np.fft.fftfreq(count, mm) for count in picture.shape)
    passed = np.exp(-2 * (math.pi * sigma) ** 2 * (up[:, None] ** 2 + across**2))
    blurred = np.fft.ifft2(np.fft.fft2(picture) * passed).real
    return float(blurred.std() / blurred.mean())


def time_ratio(settings: PrintSettings) -> float:
    """Of two colors against one, for a cylinder 30 mm wide and 10 mm high."""
    turn = np.linspace(0.0, 2 * np.pi, 180, endpoint=False)
    ring = np.stack([15 * np.cos(turn), 15 * np.sin(turn)], axis=1)
    vertices = np.concatenate([np.column_stack([ring, np.full(180, z)]) for z in (0.0, 10.0)])
    at, after = np.arange(180), (np.arange(180) + 1) % 180
    corners = np.concatenate([np.stack([at, after, after + 180, at + 180], axis=1).ravel(), at[::-1], at + 180])
    start = np.concatenate([np.arange(181) * 4, [900, 1080]])
    model = SurfaceModel(vertices, start, corners, None, None, np.full(182, -1, dtype=np.int64), (), "cylinder")
    return float(generate(model, bare(settings)).report["time_s"]["ratio"])


if __name__ == "__main__":
    sys.exit(main())
