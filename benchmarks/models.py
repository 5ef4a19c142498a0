"""The models that the benchmarks slice, as mesh arrays for our job and as an STL for the other slicer.

Run as a script it writes both: `models.py NAME SOURCE FOLDER` makes FOLDER/NAME.npz and FOLDER/NAME.stl.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

SUBDIVISIONS = 7
TEXELS = 2048
# File in the folder of the test data, "" for one that is made here, and mm that the model is printed high.
MODELS = {
    "gargoyle": ("meshes/nc/gargoyle.obj", 102.0),
    "spot": ("meshes/spot/spot.obj", 80.0),
    "benchy": ("meshes/3DBenchy.ply", 48.0),
    "gutenberg": ("meshes/gutenberg/Gutenberg.obj", 80.0),
    "icosphere": ("", 108.25),
}


def obj_triangles(path: Path) -> tuple[Floats, Integers]:
    """Vertices (V, 3), turned from Y up to Z up, and triangles (F, 3) of a Wavefront file."""
    rows = [line.split() for line in path.read_text(encoding="utf-8").splitlines()]
    points = np.array([row[1:4] for row in rows if row[:1] == ["v"]], dtype=np.float64)
    corners = [[int(corner.split("/")[0]) - 1 for corner in row[1:4]] for row in rows if row[:1] == ["f"]]
    return np.column_stack([points[:, 0], -points[:, 2], points[:, 1]]), np.array(corners, dtype=np.int64)


def ply_triangles(path: Path) -> tuple[Floats, Integers]:
    """Vertices (V, 3) and triangles (F, 3) of a binary PLY file with nothing else in it."""
    head, _, data = path.read_bytes().partition(b"end_header\n")
    sizes = {line.split()[1]: int(line.split()[2]) for line in head.decode().splitlines() if line[:8] == "element "}
    points = np.frombuffer(data, dtype="<f4", count=3 * sizes["vertex"]).reshape(-1, 3)
    record = np.dtype([("sides", "u1"), ("corners", "<i4", 3)])
    faces = np.frombuffer(data, dtype=record, count=sizes["face"], offset=points.nbytes)
    return points.astype(np.float64), faces["corners"].astype(np.int64)


def icosphere(subdivisions: int) -> tuple[Floats, Integers]:
    """Unit vectors (V, 3) and triangles (20 · 4^n, 3) of an icosahedron, each triangle cut in four n times."""
    long = (1 + 5**0.5) / 2
    faces = np.array([[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11],
                      [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8],
                      [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9],
                      [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1]])  # fmt: skip
    points = np.array([[-1, long, 0], [1, long, 0], [-1, -long, 0], [1, -long, 0],
                       [0, -1, long], [0, 1, long], [0, -1, -long], [0, 1, -long],
                       [long, 0, -1], [long, 0, 1], [-long, 0, -1], [-long, 0, 1]])  # fmt: skip
    for _ in range(subdivisions):
        edges = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2), axis=2)
        pairs, middle = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
        a, b, c = faces.T
        ab, bc, ca = (len(points) + middle.reshape(-1, 3)).T
        points = np.concatenate([points, points[pairs].mean(axis=1)])
        faces = np.stack([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]).transpose(2, 0, 1).reshape(-1, 3)
    return points / np.linalg.norm(points, axis=1)[:, None], faces.astype(np.int64)


def bumpy_sphere(subdivisions: int) -> tuple[Floats, Integers]:
    """An icosphere under smooth noise: a few dozen sine waves of random direction, always the same ones."""
    direction, faces = icosphere(subdivisions)
    random = np.random.default_rng(1)
    waves = random.normal(size=(40, 3)) * random.uniform(2, 12, size=(40, 1))
    noise = np.sin(direction @ waves.T + random.uniform(0, 2 * np.pi, size=40)).mean(axis=1)
    points: Floats = direction * (1 + 0.15 * noise)[:, None]
    return points, faces


def scaled(points: Floats, height_mm: float) -> Floats:
    """Points scaled to a height, standing on z = 0 around the z axis."""
    points = points * (height_mm / np.ptp(points[:, 2]))
    low, high = points.min(axis=0), points.max(axis=0)
    return np.asarray(points - [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]])


def wrapped_uv(points: Floats, faces: Integers) -> Floats:
    """(3F, 2) UVs of a label around the z axis: u around it, v upwards; u may pass 1 where the label meets itself."""
    around = np.arctan2(points[:, 1], points[:, 0])[faces] / (2 * np.pi)
    around -= np.rint(around - around[:, :1])
    upwards = points[:, 2][faces] / points[:, 2].max()
    uv: Floats = np.stack([around, upwards], axis=2).reshape(-1, 2)
    return uv


def picture() -> NDArray[np.float32]:
    """(H, W) tones with edges, ramps and detail finer than the print can show."""
    y, x = np.mgrid[0:TEXELS, 0:TEXELS] * (2 * np.pi / TEXELS)
    tone = 0.5 + 0.25 * np.sin(5 * x + np.sin(3 * y)) + 0.15 * np.sin(97 * x) * np.cos(89 * y)
    return np.asarray(np.where(np.sin(9 * x) * np.sin(7 * y) > 0.7, 1.0, tone), dtype=np.float32)


def write_stl(path: Path, points: Floats, faces: Integers) -> None:
    """A binary STL."""
    record = np.zeros(len(faces), dtype=[("normal", "<3f4"), ("corners", "<9f4"), ("attribute", "<u2")])
    record["corners"] = points[faces].reshape(-1, 9)
    path.write_bytes(bytes(80) + np.uint32(len(faces)).tobytes() + record.tobytes())


def main(name: str, source: str, folder: Path) -> None:
    """Write the arrays and the STL of a model; `source` is its file."""
    if name == "icosphere":
        points, faces = bumpy_sphere(SUBDIVISIONS)
    elif source.endswith(".ply"):
        points, faces = ply_triangles(Path(source))
    else:
        points, faces = obj_triangles(Path(source))
    points = scaled(points, MODELS[name][1])
    np.savez(folder / f"{name}.npz", points=points, faces=faces, uv=wrapped_uv(points, faces), tone=picture())
    write_stl(folder / f"{name}.stl", points, faces)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], Path(sys.argv[3]))
