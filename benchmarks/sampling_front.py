"""Seams kept away from the front: `sampling_front.py [FOLDER OF MESHES]` prints that table of docs/sampling.md.

The models and bounds are those of `sampling.py`. Both schemes are weighed by the same visibility, that of the setting
`front`; the paper's takes no notice of it.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from sampling import MESHES, MODELS, ROOT, SETTINGS, obj_model

sys.path.insert(0, str(ROOT))
from launcher import load_package

load_package()
from dualcolor.core.contours.contours import contours  # noqa: E402
from dualcolor.core.mesh.triangles import triangulate  # noqa: E402
from dualcolor.core.sampling.optimized import optimized_samples  # noqa: E402
from dualcolor.core.sampling.paper import paper_samples  # noqa: E402
from dualcolor.core.sampling.projector import Projector  # noqa: E402
from dualcolor.core.sampling.quality import seam_errors  # noqa: E402
from dualcolor.core.sampling.visibility import at_arcs, front_visibility  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.core.slicing.slices import slices  # noqa: E402


def salient(path: Path, height_mm: float, settings: PrintSettings) -> list[tuple[float, float]]:
    """Salient share weighted by visibility and as it is, in percent: the paper's, optimized, optimized with a front."""
    mesh = triangulate(obj_model(path, height_mm), settings)
    cut = slices(mesh, settings)
    lines = contours(cut.outlines, cut.loop_polygon, settings)
    projector = Projector(lines, settings.projection_threshold)
    seen = front_visibility(lines.normal, settings.front_angle)
    found = []
    for samples in (
        paper_samples(projector, settings),
        optimized_samples(projector, settings),
        optimized_samples(projector, settings, seen),
    ):
        errors = seam_errors(samples, projector)
        shares = errors.shares(len(samples.arc), at_arcs(seen, lines, errors.arc))
        found.append((100 * shares["salient_seen"], 100 * shares["salient"]))
    return found


def main(meshes: Path) -> None:
    """Print the table."""
    print("| model | paper | optimized | optimized, `front` | of the paper's | all seams, `front` |")
    print("|---|---|---|---|---|---|")
    ratios = []
    for name, (file, height) in MODELS.items():
        if not (meshes / file).is_file():
            continue
        plain, best, front = salient(meshes / file, height, PrintSettings(**SETTINGS))
        ratios.append(front[0] / plain[0])
        weighed = " | ".join(f"{share:.2f}" for share, _ in (plain, best, front))
        print(f"| {name} | {weighed} | {ratios[-1]:.2f} | {front[1]:.2f} |", flush=True)
    if ratios:
        mean = np.exp(np.mean(np.log(ratios)))
        print(f"\nweighted salient share, `front` / paper: geometric mean {mean:.3f}, most {max(ratios):.3f}")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else MESHES)
