"""Solids made by program, as the models that the pipeline takes."""

import numpy as np
from dualcolor.core.model import SurfaceModel, ToneImage


def surface(vertices, faces, uv=None, textures=(), tone=None, name="solid"):
    """A model of triangles; `uv` (C, 2) or `tone` (C,) by corner."""
    faces = np.asarray(faces, dtype=np.int64)
    return SurfaceModel(
        vertices=np.asarray(vertices, dtype=float),
        polygon_start=np.arange(len(faces) + 1) * faces.shape[1],
        corner_vertex=faces.ravel(),
        corner_uv=uv,
        corner_tone=tone,
        polygon_texture=np.full(len(faces), 0 if textures else -1),
        textures=tuple(textures),
        name=name,
    )


def joined(*models):
    """Several models in one mesh, shells kept apart; without UVs."""
    vertices = np.concatenate([model.vertices for model in models])
    offsets = np.cumsum([0] + [len(model.vertices) for model in models[:-1]])
    faces = np.concatenate([m.corner_vertex.reshape(-1, 3) + o for m, o in zip(models, offsets, strict=True)])
    return surface(vertices, faces)


def box(low, high, inward=False):
    """An axis-parallel box of twelve triangles."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    vertices = np.array([[x, y, z] for z in (z0, z1) for y in (y0, y1) for x in (x0, x1)], dtype=float)
    quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    faces = np.array([[q[i] for i in c] for q in quads for c in ([0, 1, 2], [0, 2, 3])])
    return surface(vertices, faces[:, ::-1] if inward else faces)


def lathe(profile, sides=96, x=0.0, y=0.0, textures=(), tone=None):
    """A solid of revolution; `profile` (R, 2) of radius and height from bottom to top.

    With `textures` the UVs run once around (u) and from the bottom to the top (v).
    """
    profile = np.asarray(profile, dtype=float)
    rings = len(profile)
    turn = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    radius, height = profile.T
    wall = np.stack(
        [
            x + radius[:, None] * np.cos(turn),
            y + radius[:, None] * np.sin(turn),
            np.broadcast_to(height[:, None], (rings, sides)),
        ],
        axis=2,
    ).reshape(-1, 3)
    caps = [[x, y, height[0]], [x, y, height[-1]]]
    column = np.arange(sides)
    beside = (column + 1) % sides
    quads, uv = [], []
    for ring in range(rings - 1):
        a, b = ring * sides + column, ring * sides + beside
        c, d = a + sides, b + sides
        quads += [np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)]
        u0, u1 = column / sides, (column + 1) / sides
        v0, v1 = (np.full(sides, (height[k] - height[0]) / np.ptp(height)) for k in (ring, ring + 1))
        uv += [
            np.stack([np.stack(p, axis=1) for p in corners], axis=1)
            for corners in (((u0, v0), (u1, v0), (u1, v1)), ((u0, v0), (u1, v1), (u0, v1)))
        ]
    bottom, top = len(wall), len(wall) + 1
    last = (rings - 1) * sides
    quads += [np.stack([np.full(sides, bottom), beside, column], axis=1)]
    quads += [np.stack([np.full(sides, top), last + column, last + beside], axis=1)]
    uv += [np.zeros((2 * sides, 3, 2))]
    faces = np.concatenate(quads)
    corner_tone = None if tone is None else np.full(faces.size, float(tone))
    corner_uv = np.concatenate(uv).reshape(-1, 2) if textures else None
    return surface(np.concatenate([wall, caps]), faces, corner_uv, textures, corner_tone)


def cylinder(radius=10.0, height=10.0, sides=96, **more):
    """A standing cylinder."""
    return lathe([[radius, 0], [radius, height]], sides, **more)


def picture(tone):
    """An opaque texture from an array, row 0 at the bottom."""
    tone = np.asarray(tone, dtype=np.float32)
    return ToneImage(tone, np.ones_like(tone))
