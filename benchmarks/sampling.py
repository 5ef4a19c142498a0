"""Seams of both samplings on eight models: `sampling.py [FOLDER OF MESHES]` prints the table of docs/sampling.md.

The meshes are those of the test data (`../shared/data/meshes` by default); what is missing is left out. Both schemes
run on the same contours with the same bounds and are measured with the same probes (`core/sampling/quality.py`).
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from models import obj_triangles, scaled

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from launcher import load_package  # noqa: E402

load_package()
from dualcolor.core.analysis.tracelines import tracelines  # noqa: E402
from dualcolor.core.contours.contours import Contours, contours  # noqa: E402
from dualcolor.core.mesh.triangles import triangulate  # noqa: E402
from dualcolor.core.model import SurfaceModel  # noqa: E402
from dualcolor.core.sampling.optimized import optimized_samples  # noqa: E402
from dualcolor.core.sampling.paper import paper_samples  # noqa: E402
from dualcolor.core.sampling.projector import Projector  # noqa: E402
from dualcolor.core.sampling.quality import seam_errors  # noqa: E402
from dualcolor.core.sampling.samples import Samples  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.core.slicing.slices import slices  # noqa: E402

MESHES = ROOT.parent / "shared" / "data" / "meshes"
MODELS = {
    "Gargoyle": ("nc/gargoyle.obj", 102.0),
    "Kitten": ("nc/kitten.obj", 54.0),
    "Spot": ("spot/spot.obj", 60.0),
    "Bob": ("bob/bob_tri.obj", 60.0),
    "Koala": ("koala_low_resolution.obj", 60.0),
    "Armadillo": ("nc/armadillo.obj", 80.0),
    "Cat": ("cat-low-resolution.obj", 60.0),
    "Gutenberg": ("gutenberg/Gutenberg.obj", 80.0),
}
SETTINGS = {"pattern": "wave", "wavelength": 1.2, "wave_depth_max": 0.75, "wave_depth_min": 0.375}
RUNS = 2


@dataclass(frozen=True)
class Row:
    """What is measured of one scheme on one model; shares in percent."""

    error_free: float
    unseen: float
    salient: float
    discarded: float
    births: int
    deaths: int
    mean: float
    least: float
    most: float
    seconds: float


def obj_model(path: Path, height_mm: float) -> SurfaceModel:
    """A Wavefront file of triangles, scaled to a height."""
    points, faces = obj_triangles(path)
    start = np.arange(len(faces) + 1) * 3
    none = np.full(len(faces), -1, dtype=np.int64)
    return SurfaceModel(scaled(points, height_mm), start, faces.ravel(), None, None, none, (), path.stem)


def quickest(task: Callable[[], Any]) -> tuple[Any, float]:
    """The result and the least processor time of a few runs, which a busy machine changes little."""
    times = []
    for _ in range(RUNS):
        began = process_time()
        result = task()
        times.append(process_time() - began)
    return result, min(times)


def measured(lines: Contours, samples: Samples, projector: Projector, settings: PrintSettings, seconds: float) -> Row:
    """Shares of the seam error, births and deaths, spacing."""
    shares = seam_errors(samples, projector).shares(len(samples.arc))
    traced = tracelines(samples, projector, settings.wavelength).report()
    gap = samples.spacing(lines)
    assert gap.min() >= settings.wavelength - 1e-6
    assert gap.max() < 2 * settings.wavelength
    percent = (100 * shares[key] for key in ("error_free", "imperceptible", "salient", "discarded"))
    counts = int(traced["births"]), int(traced["deaths"])
    return Row(*percent, *counts, float(gap.mean()), float(gap.min()), float(gap.max()), seconds)


def compared(path: Path, height_mm: float, settings: PrintSettings) -> tuple[int, float, Row, Row]:
    """Layers, seconds of slicing, and both schemes on one model."""
    mesh = triangulate(obj_model(path, height_mm), settings)
    cut, slicing = quickest(lambda: slices(mesh, settings))
    lines = contours(cut.outlines, cut.loop_polygon, settings)
    projector = Projector(lines, settings.projection_threshold)
    rows = []
    for scheme in (paper_samples, optimized_samples):
        samples, seconds = quickest(lambda scheme=scheme: scheme(projector, settings))
        rows.append(measured(lines, samples, projector, settings, seconds))
    return len(cut.layers), slicing, rows[0], rows[1]


def table_row(name: str, scheme: str, row: Row, slicing: float) -> str:
    """One line of the table."""
    return (
        f"| {name} | {scheme} | {row.error_free:.1f} | {row.unseen:.1f} | {row.salient:.2f} | {row.discarded:.1f} "
        f"| {row.births} + {row.deaths} | {row.mean:.3f} | {row.least:.3f} to {row.most:.3f} "
        f"| {row.seconds / slicing:.1f} |"
    )


def main(meshes: Path) -> None:
    """Print the tables."""
    print(
        "| model | sampling | error-free % | not perceptible % | salient % | discarded % | births + deaths "
        "| mean spacing mm | spacing mm | time / slicing |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|")
    ratios = []
    for name, (file, height) in MODELS.items():
        if not (meshes / file).is_file():
            continue
        layers, slicing, plain, best = compared(meshes / file, height, PrintSettings(**SETTINGS))
        ratios.append(best.salient / plain.salient)
        print(table_row(f"{name}, {height:g} mm, {layers} layers", "paper", plain, slicing))
        print(table_row("", "optimized", best, slicing), flush=True)
    if ratios:
        mean = np.exp(np.mean(np.log(ratios)))
        print(f"\nsalient, optimized / paper: geometric mean {mean:.3f}, most {max(ratios):.3f}")
    file, height = MODELS["Gargoyle"]
    if (meshes / file).is_file():
        print("\n| layers | sampling | slicing |\n|---|---|---|")
        for layer_height in (0.25, 0.125, 0.0625):
            settings = PrintSettings(**SETTINGS, layer_height=layer_height, first_layer_height=layer_height)
            layers, slicing, _, best = compared(meshes / file, height, settings)
            print(f"| {layers} | {best.seconds:.2f} | {slicing:.2f} |", flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else MESHES)
