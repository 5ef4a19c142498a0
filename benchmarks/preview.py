"""The predicted print of a model: `preview.py MODEL.npz` prints its figures as one line of JSON.

A print with supports, brim and ooze shield becomes strands and curves, is scrubbed through and rendered. Seconds of the
processor are given beside those of the clock, for a machine that does something else too.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from benchmarks.job import peak_mb

RESOLUTION, SAMPLES = (480, 480), 32


def timed(name: str, action: Callable[[], Any], figures: dict[str, float]) -> Any:
    """The action's result; its seconds are noted under its name."""
    began, before = perf_counter(), os.times()
    result = action()
    after = os.times()
    figures[f"{name}_s"] = perf_counter() - began
    figures[f"{name}_cpu_s"] = after.user + after.system - before.user - before.system
    return result


def print_of(path: Path) -> Any:
    """The finished job of a model of `models.py`."""
    import numpy as np
    from dualcolor.core.model import SurfaceModel, ToneImage
    from dualcolor.core.pipeline import generate
    from dualcolor.core.settings import PrintSettings

    arrays = np.load(path)
    points, faces, uv, tone = (arrays[name] for name in ("points", "faces", "uv", "tone"))
    start, texture = np.arange(len(faces) + 1) * 3, np.zeros(len(faces), dtype=np.int64)
    image = ToneImage(tone, np.ones_like(tone))
    model = SurfaceModel(points, start, faces.ravel(), uv, None, texture, (image,), path.stem)
    return generate(model, PrintSettings(support_enable=True, brim_width=3.0, ooze_shield=True))


def main(path: Path) -> dict[str, float]:
    """Run everything once and return its figures."""
    from launcher import load_package

    load_package()
    import bpy
    import dualcolor
    from dualcolor.bridge.pictures.views import picture_steps
    from dualcolor.bridge.quiet import quiet_stdout
    from dualcolor.bridge.strands.preview import build_preview
    from dualcolor.core.pictures.viewing import USUAL_VIEW, PictureOptions
    from dualcolor.core.progress import drained

    figures: dict[str, float] = {}
    result = timed("job", lambda: print_of(path), figures)
    figures["job_peak_mb"] = peak_mb()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    dualcolor.register()
    collection = timed("strands", lambda: build_preview(result), figures)
    figures["points"] = sum(len(held.data.points) for held in collection.objects)
    view, layers = collection.dualcolor_view, int(result.moves.layer.max())

    def drag(name: str, value: float) -> None:
        setattr(view, name, value)
        bpy.context.view_layer.update()

    drag("layer_to", layers - 1)  # the first time the nodes are made
    timed("scrub_layers", lambda: [drag("layer_to", layers * k // 20) for k in range(20)], figures)
    drag("layer_to", layers // 2)
    timed("scrub_moves", lambda: [drag("moves", 5.0 * k) for k in range(20)], figures)
    for name in ("scrub_layers", "scrub_moves"):
        figures[f"{name}_s"] /= 20
        figures[f"{name}_cpu_s"] /= 20
    with tempfile.TemporaryDirectory() as folder, quiet_stdout():
        files = {USUAL_VIEW: Path(folder) / "picture.png"}
        options = PictureOptions(resolution=RESOLUTION, samples=SAMPLES, whole_plate=True)
        timed("render", lambda: drained(picture_steps(collection, files, options)), figures)
    figures["peak_mb"] = peak_mb()
    return figures


if __name__ == "__main__":
    print(json.dumps(main(Path(sys.argv[1]))))
