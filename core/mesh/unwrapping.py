"""UV maps by xatlas, in a process of its own: xatlas lets nothing else run while it works, and cannot be stopped."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import time
from collections.abc import Generator
from dataclasses import asdict
from pathlib import Path

import numpy as np

from ..errors import MeshError, PrintError
from ..model import Float32Array, IntArray
from ..records import dataclass

TRIANGLES_PER_SECOND = 4000.0
_POLL_S = 0.02


@dataclass(frozen=True)
class ChartOptions:
    """How a surface is cut into charts; names and defaults are xatlas's.

    Attributes:
        max_cost: higher values give fewer and more strongly curved charts.
        max_iterations: how often charts are grown anew from better seeds.
        normal_deviation_weight: weight of faces whose normal differs from their chart's.
        roundness_weight: weight of charts that are not round.
        straightness_weight: weight of ragged borders.
        normal_seam_weight: weight of cutting where the surface is smooth.
        texture_seam_weight: weight of cutting where the old UVs are continuous.
    """

    max_cost: float = 2.0
    max_iterations: int = 1
    normal_deviation_weight: float = 2.0
    roundness_weight: float = 0.01
    straightness_weight: float = 6.0
    normal_seam_weight: float = 4.0
    texture_seam_weight: float = 0.5


@dataclass(frozen=True)
class PackOptions:
    """How charts are packed; names are xatlas's.

    Attributes:
        texels_per_unit: texels per mm; 0 lets xatlas choose.
        padding: texels between charts.
        rotate_charts: whether charts may be turned.
        bruteForce: whether the best packing is searched for, slowly.
    """

    texels_per_unit: float = 0.0
    padding: int = 4
    rotate_charts: bool = True
    bruteForce: bool = False  # noqa: N815  (xatlas writes it so)


def unwrapping(
    vertices: Float32Array, faces: IntArray, chart: ChartOptions, pack: PackOptions
) -> Generator[float, None, Float32Array]:
    """Unwrap triangles; yields an estimate of the share done, returns (F, 3, 2) UVs of their corners, in 0 to 1.

    Closing the generator stops the work.

    Args:
        vertices: (V, 3) mm.
        faces: (F, 3).
        chart: how to cut.
        pack: how to pack.

    Raises:
        PrintError: xatlas is not installed.
        MeshError: xatlas cannot make charts of this mesh.
    """
    if importlib.util.find_spec("xatlas") is None:
        raise PrintError("xatlas is not installed", "unwrap with Smart UV Project instead")
    import tempfile

    with tempfile.TemporaryDirectory(prefix="dualcolor-") as folder:
        question, answer = Path(folder) / "mesh.npz", Path(folder) / "uv.npy"
        options = {f"chart_{name}": value for name, value in asdict(chart).items()}
        options |= {f"pack_{name}": value for name, value in asdict(pack).items()}
        np.savez(question, vertices=vertices.astype(np.float32), faces=faces.astype(np.uint32), **options)
        command = [sys.executable, "-I", str(Path(__file__).with_name("xatlas_process.py")), *_library_folders()]
        without_window = getattr(subprocess, "CREATE_NO_WINDOW", 0)  # on Windows, where a console would open
        with subprocess.Popen(
            [*command, str(question), str(answer)], stderr=subprocess.DEVNULL, creationflags=without_window
        ) as process:
            try:
                yield from _waiting(process, len(faces) / TRIANGLES_PER_SECOND)
            finally:
                process.kill()
        if not answer.exists():
            raise MeshError("xatlas cannot unwrap this mesh", "unwrap it with Smart UV Project instead")
        uv: Float32Array = np.load(answer, allow_pickle=False)
        return uv


def _library_folders() -> list[str]:
    """Where the other process finds numpy and xatlas."""
    specs = [importlib.util.find_spec(name) for name in ("numpy", "xatlas")]
    places = [Path(spec.origin) for spec in specs if spec is not None and spec.origin]
    folders = [str(place.parent.parent if place.name == "__init__.py" else place.parent) for place in places]
    return [os.pathsep.join(folders)]


def _waiting(process: subprocess.Popen[bytes], expected_s: float) -> Generator[float, None, None]:
    """Wait for a process; yields an estimated share done that approaches 1."""
    begun = time.monotonic()
    while process.poll() is None:
        passed = time.monotonic() - begun
        yield passed / (passed + expected_s)
        time.sleep(_POLL_S)
