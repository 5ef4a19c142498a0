"""Run as a process of its own by `unwrapping.py`: xatlas_process.py FOLDERS MESH.npz UV.npy."""

import os
import sys

sys.path[:0] = sys.argv[1].split(os.pathsep)

import numpy as np  # noqa: E402
import xatlas  # noqa: E402


def main() -> None:
    """Read a mesh and options, write (F, 3, 2) UVs."""
    question = np.load(sys.argv[2], allow_pickle=False)
    chart, pack = xatlas.ChartOptions(), xatlas.PackOptions()
    for name in question.files:
        kind, _, option = name.partition("_")
        target = {"chart": chart, "pack": pack}.get(kind)
        if target is not None:
            setattr(target, option, question[name].item())
    atlas = xatlas.Atlas()
    atlas.add_mesh(question["vertices"], question["faces"])
    atlas.generate(chart, pack)
    _, corners, uv = atlas.get_mesh(0)
    np.save(sys.argv[3], uv[corners.reshape(-1)].reshape(-1, 3, 2).astype(np.float32))


if __name__ == "__main__":
    main()
