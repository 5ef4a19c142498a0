"""The charts of a mesh's UV map: the islands of its faces, and the texels that each covers."""

from __future__ import annotations

import numpy as np

from ..errors import TextureError
from ..mesh.components import components, numbered
from ..model import FloatArray, TriangleMesh
from ..records import dataclass
from .islands import NO_ISLAND, LabelImage, corner_places, uv_areas
from .labels import rasterized


@dataclass(frozen=True)
class Charts:
    """Where the islands of a mesh's UV map lie in its textures, whatever is painted there.

    Attributes:
        face_island: (F,) `NO_ISLAND` without a texture.
        face_area: (F,) share of its texture that each face covers, negative where it is mirrored.
        labels: one a texture, (h, w) the island that covers each texel; of no size where no face uses the texture.
    """

    face_island: LabelImage
    face_area: FloatArray
    labels: tuple[LabelImage, ...]


def uv_charts(mesh: TriangleMesh, sizes: tuple[tuple[int, int], ...]) -> Charts:
    """The charts of a mesh.

    Args:
        mesh: F faces with UVs.
        sizes: rows and columns of each texture.

    Raises:
        TextureError: a face has a texture that is not there.
    """
    if mesh.face_texture.max(initial=-1) >= len(sizes):
        raise TextureError("a face has a texture that is not there", "assign the picture again")
    textured = np.flatnonzero(mesh.face_texture >= 0)
    place = corner_places(mesh, textured)
    number = numbered(components(place))
    island = np.full(len(mesh.faces), NO_ISLAND, dtype=np.min_scalar_type(-1 - number.max(initial=0)))
    island[textured] = number
    area = uv_areas(mesh.face_uv)
    labels = []
    for texture, (height, width) in enumerate(sizes):
        faces = np.flatnonzero(mesh.face_texture == texture)
        if not len(faces):
            labels.append(np.zeros((0, 0), dtype=island.dtype))
            continue
        own = slice(None) if len(faces) == len(island) else faces
        corners = place if len(faces) == len(textured) else place[np.searchsorted(textured, faces)]
        image, island[own] = rasterized(mesh.face_uv[own], area[own], island[own], height, width, corners)
        labels.append(image)
    return Charts(island, area, tuple(labels))
