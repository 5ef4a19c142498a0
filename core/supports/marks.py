"""Where the user enforces or blocks supports: marked faces and volumes as areas of each layer."""

from __future__ import annotations

import numpy as np
import shapely

from ..errors import MeshError
from ..mesh.polygons import triangle_corners
from ..mesh.welding import weld
from ..model import BoolArray, FloatArray, IntArray, Shapes, SupportMark, SupportVolume, TriangleMesh
from ..parallel import geos_in_threads
from ..records import dataclass
from ..slicing.intersect import intersect
from ..slicing.link import link
from ..slicing.regions import gathered, solid_regions
from .grid_overlay import nothing

# Marked areas reach farther than their faces by this much, mm: more than outlines are simplified by.
_MARGIN_MM = 0.05
_GAP_CLOSING_MM = 0.05


@dataclass(frozen=True)
class Marks:
    """Areas of L layers; the one of a layer holds for what hangs between the layer below and this one.

    Attributes:
        enforced: (L,) where overhangs get supports, however steep.
        blocked: (L,) where they get none; this wins.
    """

    enforced: Shapes
    blocked: Shapes


def marks(mesh: TriangleMesh, planes: FloatArray) -> Marks | None:
    """The marked faces and volumes of a mesh; None where there are none.

    Args:
        mesh: as sliced.
        planes: (L,) mm, heights of the layers' outlines.

    Raises:
        MeshError: a volume is open.
    """
    if mesh.face_support is None and not mesh.volumes:
        return None
    found = {}
    for mark in (SupportMark.ENFORCER, SupportMark.BLOCKER):
        areas = [inside(volume, planes) for volume in mesh.volumes if volume.mark == mark]
        if mesh.face_support is not None and (mesh.face_support == mark).any():
            areas.append(painted(mesh, mesh.face_support == mark, planes))
        found[mark] = _united(areas, len(planes))
    return Marks(found[SupportMark.ENFORCER], found[SupportMark.BLOCKER])


def _united(areas: list[Shapes], count: int) -> Shapes:
    """(L,) several areas of each layer in one."""
    whole = nothing(count) if not areas else areas[0]
    for more in areas[1:]:
        whole = shapely.union(whole, more)
    return whole


def painted(mesh: TriangleMesh, chosen: BoolArray, planes: FloatArray) -> Shapes:
    """(L,) what faces cover, seen from below, between the plane below each layer and its own.

    The part of a triangle between two planes is the hull of its corners there and of its cuts with both planes.

    Args:
        mesh: with F faces.
        chosen: (F,) which of them.
        planes: (L,) mm, increasing.
    """
    faces = mesh.faces[chosen]
    count = len(faces)
    blank = np.zeros((count, 3))
    cuts = intersect(
        TriangleMesh(mesh.vertices, faces, np.zeros((count, 3, 2)), blank, np.zeros(count, dtype=np.int64)), planes
    )
    corners = mesh.vertices[faces.ravel()]
    ends = cuts.points.reshape(-1, 2)
    cut_face, cut_layer = np.repeat(cuts.face, 2), np.repeat(cuts.layer, 2)
    points = np.concatenate([corners[:, :2], ends, ends])
    face = np.concatenate([np.repeat(np.arange(count), 3), cut_face, cut_face])
    # As in slicing, a point on a plane counts as above it.
    slab = np.concatenate([np.searchsorted(planes, corners[:, 2], side="right"), cut_layer, cut_layer + 1])
    return _hulls(points, face, slab, len(planes))


def _hulls(points: FloatArray, face: IntArray, slab: IntArray, count: int) -> Shapes:
    """(L,) for each slab the hulls of the points of each face there, in one."""
    order = np.lexsort((face, slab))
    order = order[slab[order] < count]
    points, face, slab = points[order], face[order], slab[order]
    new = np.append(True, (np.diff(face) != 0) | (np.diff(slab) != 0))[: len(face)]
    hulls = shapely.convex_hull(shapely.multipoints(points, indices=np.cumsum(new) - 1))
    owner = slab[new]
    flat = shapely.get_dimensions(hulls) == 2
    (areas,) = geos_in_threads(
        lambda parts: (shapely.buffer(parts, _MARGIN_MM, join_style="mitre", mitre_limit=2.0),),
        gathered(hulls[flat], owner[flat], count),
    )
    return areas


def inside(volume: SupportVolume, planes: FloatArray) -> Shapes:
    """(L,) cross-sections of a volume, on each plane together with those on the plane below.

    Raises:
        MeshError: the volume is open.
    """
    corners, _ = triangle_corners(volume.vertices, volume.polygon_start, volume.corner_vertex)
    vertices, welded = weld(volume.vertices)
    faces = welded[volume.corner_vertex[corners]]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    count = len(faces)
    solid = TriangleMesh(
        vertices, faces, np.zeros((count, 3, 2)), np.zeros((count, 3)), np.full(count, -1, dtype=np.int64)
    )
    outlines, open_layers = link(intersect(solid, planes), _GAP_CLOSING_MM)
    if len(open_layers):
        raise MeshError(f"the support volume {volume.name} is open", "fill its holes")
    regions = solid_regions(outlines, len(planes))
    regions[1:] = shapely.union(regions[1:], regions[:-1].copy())
    return regions
