"""The paper's sampling on two models, beside its own figures: `sampling_paper.py [FOLDER OF MESHES]` prints the table.

Section 6.4 calls samples free of error without saying from which error on they are not, and counts those in the
interval (0, 0.5) as not yet perceptible. So shares are given for two thresholds: 0.05, from which on the paper's
heatmap is opaque, and 0.001.
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
from dualcolor.core.sampling.paper import paper_samples  # noqa: E402
from dualcolor.core.sampling.projector import Projector  # noqa: E402
from dualcolor.core.sampling.quality import ERROR_FREE, SALIENT, SeamErrors, seam_errors  # noqa: E402
from dualcolor.core.settings import PrintSettings  # noqa: E402
from dualcolor.core.slicing.slices import slices  # noqa: E402

PUBLISHED = {"Gargoyle": ("Gargoyle", 79.0, 19.0, 2.0), "Kitten": ("LucyCat", 80.7, 18.0, 2.0)}
TINY = 0.001


def errors_of(path: Path, height_mm: float, settings: PrintSettings) -> SeamErrors:
    """The errors of Algorithm 1 on a model."""
    cut = slices(triangulate(obj_model(path, height_mm), settings), settings)
    lines = contours(cut.outlines, cut.loop_polygon, settings)
    projector = Projector(lines, settings.projection_threshold)
    return seam_errors(paper_samples(projector, settings), projector)


def main(meshes: Path) -> None:
    """Print the table."""
    print("| model | error-free % | not perceptible % | salient % | discarded |")
    print("|---|---|---|---|---|")
    for name, (theirs, *published) in PUBLISHED.items():
        file, height = MODELS[name]
        if not (meshes / file).is_file():
            continue
        found = errors_of(meshes / file, height, PrintSettings(**SETTINGS))
        kept = found.error[~found.discarded]
        lost, probes = int(found.discarded.sum()), len(found.error)
        discarded = f"{lost:,} of {probes:,} ({lost / probes:.1%})"
        print(f"| **{theirs}, the paper** | " + " | ".join(f"{share:g}" for share in published) + " | not told |")
        for threshold in (ERROR_FREE, TINY):
            free, salient = 100 * np.mean(kept < threshold), 100 * np.mean(kept >= SALIENT)
            print(f"| {name}, {height:g} mm, free of error below {threshold:g} "
                  f"| {free:.1f} | {100 - free - salient:.1f} | {salient:.1f} | {discarded} |")  # fmt: skip


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else MESHES)
