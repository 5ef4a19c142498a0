"""Upright rectangles with pictures on them, and tones looked up at places of theirs."""

import numpy as np
from dualcolor.core.model import ToneImage, TriangleMesh
from dualcolor.core.texture.lookup import tone_at
from dualcolor.core.texture.pyramid import build_pyramids


def image(tone, alpha=1.0):
    tone = np.asarray(tone, np.float32)
    return ToneImage(tone, np.broadcast_to(np.float32(alpha), tone.shape).copy())


def plates(*rectangles, mm_per_uv=40.0, texture=0, stacked=True):
    """A mesh of upright rectangles, each with its own vertices and UV rectangle (u0, v0, u1, v1)."""
    vertices, faces, uvs = [], [], []
    for number, (u0, v0, u1, v1) in enumerate(rectangles):
        uv = np.array([[u0, v0], [u1, v0], [u1, v1], [u0, v1]])
        vertices.append(np.c_[uv[:, 0], np.full(4, 0.1 * number), uv[:, 1]] * mm_per_uv)
        for triangle in ([0, 1, 2], [0, 2, 3]):
            faces.append(np.array(triangle) + 4 * number)
            uvs.append(uv[triangle])
    count = len(faces)
    textures = np.full(count, texture) if np.isscalar(texture) else np.repeat(texture, 2)
    return TriangleMesh(
        np.concatenate(vertices), np.array(faces), np.array(uvs), np.full((count, 3), np.nan), textures.astype(np.int64)
    )


def points_on(mesh, faces, count=400, seed=0):
    """Random points of the faces: (N,) face and (N, 2) UV."""
    rng = np.random.default_rng(seed)
    face = rng.choice(np.asarray(faces), count)
    weights = rng.dirichlet([1, 1, 1], count)
    return face, np.einsum("nk,nkd->nd", weights, mesh.face_uv[face])


def look_up(mesh, textures, face, uv, footprint, kind="trilinear", background=0.5, vertex_tone=None):
    pyramids = build_pyramids(mesh, tuple(textures), footprint, kind)
    vertex_tone = np.full(len(face), np.nan) if vertex_tone is None else vertex_tone
    return tone_at(pyramids, face, uv, vertex_tone, background)
