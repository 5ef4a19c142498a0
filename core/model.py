"""The job's input: a polygon mesh in millimeters with its UVs, tones and textures."""

from __future__ import annotations

from dataclasses import replace
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .records import dataclass

FloatArray = NDArray[np.float64]
Float32Array = NDArray[np.float32]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
Shapes = NDArray[np.object_]
"""Geometries of shapely."""

_CHUNK_FACES = 1 << 13  # so that intermediate arrays stay in the cache


@dataclass(frozen=True)
class ToneImage:
    """A texture as tone in linear light, row 0 at v = 0 (the bottom).

    Attributes:
        tone: (H, W) float32, 0 black to 1 white.
        alpha: (H, W) float32, 0 where nothing is painted (never "black").
    """

    tone: Float32Array
    alpha: Float32Array


class SupportMark(IntEnum):
    """What the user wants of the supports at a face or in a volume."""

    BLOCKER = -1
    NONE = 0
    ENFORCER = 1


@dataclass(frozen=True)
class SupportVolume:
    """A solid in whose inside overhangs get supports, or none; it is not printed.

    Attributes:
        mark: which of the two.
        vertices: (V, 3) float64 mm, where the object is.
        polygon_start: (P + 1,) int64, where each polygon's corners start.
        corner_vertex: (C,) int64, vertex of each corner.
        name: for messages.
    """

    mark: SupportMark
    vertices: FloatArray
    polygon_start: IntArray
    corner_vertex: IntArray
    name: str = "volume"

    def moved(self, shift: FloatArray) -> SupportVolume:
        """A copy moved by (3,) mm."""
        return replace(self, vertices=self.vertices + shift)


@dataclass(frozen=True)
class SurfaceModel:
    """A mesh of polygons as Blender has it, placed in the world, Z up, in mm; or several on one plate.

    Attributes:
        vertices: (V, 3) float64 mm.
        polygon_start: (P + 1,) int64, where each polygon's corners start.
        corner_vertex: (C,) int64, vertex of each corner.
        corner_uv: (C, 2) float64, or None where the mesh has no UV map.
        corner_tone: (C,) float64 tone from a color attribute (background blended in), or None.
        polygon_texture: (P,) int64 index into `textures`, -1 where a polygon has none.
        textures: the pictures.
        name: of the object, for headers and messages.
        object_names: of the objects on the plate, () for a single one.
        polygon_object: (P,) int64 index into `object_names`, or None for a single object.
        polygon_support: (P,) int64, a `SupportMark` of each, or None where there is none.
        volumes: solids that enforce or block supports.
        corner_visibility: (C,) 0 to 1, how visible seams are there, or None if that is not set.
        polygon_visibility: (P,) int64 index into `textures` of the picture that says so, -1 for none; or None.
        notes: warnings from when it was read, one sentence each.
    """

    vertices: FloatArray
    polygon_start: IntArray
    corner_vertex: IntArray
    corner_uv: FloatArray | None
    corner_tone: FloatArray | None
    polygon_texture: IntArray
    textures: tuple[ToneImage, ...] = ()
    name: str = "object"
    object_names: tuple[str, ...] = ()
    polygon_object: IntArray | None = None
    polygon_support: IntArray | None = None
    volumes: tuple[SupportVolume, ...] = ()
    corner_visibility: FloatArray | None = None
    polygon_visibility: IntArray | None = None
    notes: tuple[str, ...] = ()

    @cached_property
    def sides(self) -> IntArray:
        """(P,) how many corners each polygon has; not to be written to."""
        sides = np.diff(self.polygon_start)
        sides.flags.writeable = False
        return sides

    def moved(self, shift: FloatArray) -> SurfaceModel:
        """A copy moved by (3,) mm."""
        volumes = tuple(volume.moved(shift) for volume in self.volumes)
        return replace(self, vertices=self.vertices + shift, volumes=volumes)

    @property
    def names(self) -> tuple[str, ...]:
        """Of all objects on the plate, one at least."""
        return self.object_names or (self.name,)


@dataclass(frozen=True)
class TriangleMesh:
    """The triangulated, welded, placed mesh that is sliced.

    Attributes:
        vertices: (V, 3) float64 mm, on the bed, Z up, no two at the same place.
        faces: (F, 3) int64, no face uses a vertex twice.
        face_uv: (F, 3, 2) float64 UV of each corner (zeros without a UV map).
        face_tone: (F, 3) float64 tone of each corner from a color attribute, NaN where there is none.
        face_texture: (F,) int64 index of the texture, -1 for none.
        face_object: (F,) int64 index of the object on the plate, or None for a single object.
        face_support: (F,) int64, a `SupportMark` of each, or None where there is none.
        volumes: solids that enforce or block supports, placed like the mesh.
        face_visibility: (F, 3) 0 to 1, how visible seams are at each corner, or None if that is not set.
        face_visibility_texture: (F,) int64 index of the texture that says so, -1 for none; or None.
    """

    vertices: FloatArray
    faces: IntArray
    face_uv: FloatArray
    face_tone: FloatArray
    face_texture: IntArray
    face_object: IntArray | None = None
    face_support: IntArray | None = None
    volumes: tuple[SupportVolume, ...] = ()
    face_visibility: FloatArray | None = None
    face_visibility_texture: IntArray | None = None

    @cached_property
    def bounds(self) -> FloatArray:
        """(2, 3) mm, the least and the greatest corner; not to be written to."""
        corners = bounds(self.vertices)
        corners.flags.writeable = False
        return corners

    @cached_property
    def area_normals(self) -> FloatArray:
        """(F, 3) mm², normals whose length is twice the area of their face; not to be written to."""
        x, y, z = (np.ascontiguousarray(column) for column in self.vertices.T)
        normal = np.empty((len(self.faces), 3))
        for begin in range(0, len(normal), _CHUNK_FACES):
            corners = [np.ascontiguousarray(column) for column in self.faces[begin : begin + _CHUNK_FACES].T]
            ends = ([along.take(corner) for corner in corners] for along in (x, y, z))
            (px, qx), (py, qy), (pz, qz) = ((b - a, c - a) for a, b, c in ends)
            part = normal[begin : begin + _CHUNK_FACES]
            part[:, 0], part[:, 1], part[:, 2] = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
        normal.flags.writeable = False
        return normal

    @cached_property
    def face_area(self) -> FloatArray:
        """(F,) mm², of each face; not to be written to."""
        normals, area = self.area_normals, np.empty(len(self.faces))
        for begin in range(0, len(area), _CHUNK_FACES):
            x, y, z = normals[begin : begin + _CHUNK_FACES].T
            area[begin : begin + _CHUNK_FACES] = np.sqrt(x * x + y * y + z * z) / 2
        area.flags.writeable = False
        return area

    def bounds_of(self, number: int) -> FloatArray:
        """(2, 3) mm, the least and the greatest corner of one object on the plate."""
        if self.face_object is None:
            return self.bounds
        corners = self.vertices[self.faces[self.face_object == number].ravel()]
        return np.stack([corners.min(axis=0), corners.max(axis=0)])


def bounds(points: FloatArray, among: BoolArray | None = None) -> FloatArray:
    """(2, D) least and greatest coordinates of points (N, D), of those that `among` (N,) marks."""
    # Column by column: numpy reduces a long narrow array along its short rows ten times slower.
    where = True if among is None else among
    low = [column.min(initial=np.inf, where=where) for column in points.T]
    high = [column.max(initial=-np.inf, where=where) for column in points.T]
    return np.array([low, high])
