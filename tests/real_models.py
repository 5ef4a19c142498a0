"""Real meshes from the test data, read without Blender; Y is up in these files."""

import numpy as np
from dualcolor.core.model import ToneImage
from dualcolor.tests.solids import surface


def obj_model(path, height_mm, textures=()):
    """A Wavefront file as a model scaled to a height, triangles and quads only; UVs where the file has them."""
    rows = [line.split() for line in path.read_text().splitlines()]
    points = np.array([row[1:4] for row in rows if row[:1] == ["v"]], dtype=float)
    uvs = np.array([row[1:3] for row in rows if row[:1] == ["vt"]], dtype=float)
    faces = [corner.split("/") for row in rows if row[:1] == ["f"] for corner in _fan(row[1:])]
    vertex = np.array([int(corner[0]) for corner in faces]) - 1
    points = np.column_stack([points[:, 0], -points[:, 2], points[:, 1]])
    points *= height_mm / np.ptp(points[:, 2])
    uv = None
    if len(uvs):
        uv = uvs[np.array([int(corner[1]) for corner in faces]) - 1]
    elif textures:
        # No UVs in the file: a planar projection does for a test.
        flat = points[vertex][:, [0, 2]]
        uv = (flat - flat.min(axis=0)) / np.ptp(flat, axis=0)
    return surface(points, vertex.reshape(-1, 3), uv, textures, name=path.stem)


def _fan(corners):
    return [corners[k] for i in range(1, len(corners) - 1) for k in (0, i, i + 1)]


def image_file(path):
    """A picture as tone, decoded by the plain sRGB curve."""
    from PIL import Image

    gray = np.asarray(Image.open(path).convert("L"), dtype=np.float32)[::-1] / 255
    tone = np.where(gray <= 0.04045, gray / 12.92, ((gray + 0.055) / 1.055) ** 2.4).astype(np.float32)
    return ToneImage(tone, np.ones_like(tone))
