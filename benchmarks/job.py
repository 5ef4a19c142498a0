"""One job of ours in a process of its own: `job.py MODEL.npz OUT.gcode` prints its figures as one line of JSON.

With a third argument, OUT.x3g, it prints supports and writes that file too.

The clock starts with the mesh arrays in memory and stops when the G-code is on the disk; importing the program is
measured apart.
"""

from __future__ import annotations

import json
import os
import resource
import sys
from pathlib import Path
from time import perf_counter
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))


def peak_mb() -> float:
    """Most memory that this process has held, MB; not what its parent held, as `getrusage` has it on Linux."""
    try:
        status = Path("/proc/self/status").read_text(encoding="ascii")
        return int(status.partition("VmHWM:")[2].split()[0]) / 1024
    except (OSError, IndexError):
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1 << (20 if sys.platform == "darwin" else 10))


def surface_model(arrays: Any, name: str) -> Any:
    """The model that `models.py` has written, with its picture."""
    import numpy as np
    from dualcolor.core.model import SurfaceModel, ToneImage

    points, faces, uv, tone = (arrays[key] for key in ("points", "faces", "uv", "tone"))
    start, texture = np.arange(len(faces) + 1) * 3, np.zeros(len(faces), dtype=np.int64)
    image = ToneImage(tone, np.ones_like(tone))
    return SurfaceModel(points, start, faces.ravel(), uv, None, texture, (image,), name)


def main(model_path: str, gcode_path: str, x3g_path: str = "") -> dict[str, object]:
    """Run the job and return its figures."""
    bare, began = peak_mb(), perf_counter()
    from launcher import load_package

    load_package()
    import numpy as np
    from dualcolor.core.exports import export_gcode, export_x3g
    from dualcolor.core.pipeline import generate
    from dualcolor.core.settings import PrintSettings

    imported = perf_counter()
    model = surface_model(np.load(model_path), Path(model_path).stem)
    ready, ready_cpu = perf_counter(), os.times()
    settings = PrintSettings(support_enable=bool(x3g_path))
    result = export_gcode(generate(model, settings, begin_gcode=True), Path(gcode_path))
    if x3g_path:
        result = export_x3g(result, Path(x3g_path))
    wall, cpu = perf_counter() - ready, os.times()
    return {
        "wall_s": wall,
        "cpu_s": cpu.user + cpu.system - ready_cpu.user - ready_cpu.system,
        "import_s": imported - began,
        "peak_mb": peak_mb(),
        "bare_mb": bare,
        "stages_s": result.report["stages_s"],
        "beside_s": result.report["beside_s"],
        "layers": result.report["layers"],
        "moves": result.report["gcode"]["moves"],
        "pattern": result.report["pattern"],
    }


if __name__ == "__main__":
    print(json.dumps(main(*sys.argv[1:])))
