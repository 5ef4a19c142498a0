"""The slope advisor: how much of the painted contrast lies on surfaces too flat to show it (paper, section 6.3)."""

from __future__ import annotations

import numpy as np

from ..contours.slant import face_slant_deg
from ..mesh.surface_points import points_on_faces
from ..model import FloatArray, IntArray, TriangleMesh
from ..records import dataclass
from ..settings import PrintSettings
from ..texture.lookup import tone_at
from ..texture.pyramid import TexturePyramids

DEGRADED_DEG, GONE_DEG = 30.0, 20.0
"""Degrees from flat below which the tone loses resolution, and below which there is none (paper, Figure 9)."""

WARNED_SHARE = 0.25
_PLACE_MM2 = 2.0
_MOST_PLACES, _LEAST_PLACES = 20_000, 5_000
_LEAST_CONTRAST = 1e-6
_ROUNDING_DEG = 1e-6


@dataclass(frozen=True)
class FaceContrast:
    """The painted contrast of each of F faces.

    Attributes:
        area: (F,) mm².
        contrast: (F,) mm², the distance of the tone from the mean tone of the whole surface, integrated over the face;
            of many faces of a few square millimeters some stand for their neighbors too, which have none then.
        area_normal: (F, 3) mm², outwards, twice as long as the area is large.
    """

    area: FloatArray
    contrast: FloatArray
    area_normal: FloatArray

    @property
    def normal(self) -> FloatArray:
        """(F, 3) unit vectors outwards, zero on faces without an area."""
        return np.asarray(self.area_normal / self._length[:, None])

    @property
    def lean(self) -> FloatArray:
        """(F,) vertical component of the unit normals, -1 to 1."""
        return np.asarray(self.area_normal[:, 2] / self._length)

    @property
    def _length(self) -> FloatArray:
        return np.maximum(2 * self.area, 1e-12)

    @property
    def mean(self) -> float:
        """Mean distance of the tone from the mean tone, 0 to 0.5; 0 for one even tone."""
        mean = float(self.contrast.sum() / max(self.area.sum(), 1e-12))
        return mean if mean > _LEAST_CONTRAST else 0.0


def face_contrast(mesh: TriangleMesh, pyramids: TexturePyramids, settings: PrintSettings) -> FaceContrast:
    """Measure the paint on every face.

    Args:
        mesh: F faces.
        pyramids: its textures, filtered as the print filters them.
        settings: background_tone is used.
    """
    area = mesh.face_area
    face, share, weight = _places(mesh, area)
    uv = np.einsum("qc,qcd->qd", share, mesh.face_uv.take(face, axis=0))
    vertex_tone = np.einsum("qc,qc->q", share, mesh.face_tone.take(face, axis=0))
    tone = tone_at(pyramids, face, uv, vertex_tone, settings.background_tone)
    mean = float((weight * tone).sum() / max(weight.sum(), 1e-12))
    contrast = np.asarray(np.bincount(face, weight * np.abs(tone - mean), len(area)), dtype=np.float64)
    return FaceContrast(area, contrast, mesh.area_normals)


def _places(mesh: TriangleMesh, area: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Places all over the surface: the face, shares of its corners, and mm² that each stands for.

    Of many faces that are smaller than that, one stands for several.
    """
    most = max(_PLACE_MM2, float(area.sum()) / _MOST_PLACES)
    large, small = np.flatnonzero(area > most), np.flatnonzero(area <= most)
    weight = area[small]
    if len(small) > _LEAST_PLACES:
        each = max(min(most, float(weight.sum()) / _LEAST_PLACES), 1e-12)
        weight = np.diff(np.floor(np.cumsum(weight) / each), prepend=0) * each
        small, weight = small[weight > 0], weight[weight > 0]
    on = points_on_faces(mesh.vertices[mesh.faces[large]], np.sqrt(most))
    face = large[on.face]
    share = np.concatenate([on.share, np.full((len(small), 3), 1 / 3)])
    return np.append(face, small), share, np.append(on.weight * area[face], weight)


def from_flat_deg(mesh: TriangleMesh) -> FloatArray:
    """(F,) degrees between each face and the horizontal, 0 to 90."""
    return np.asarray(90.0 - np.abs(face_slant_deg(mesh)))


def slope_report(paint: FaceContrast) -> dict[str, float]:
    """Shares of the painted contrast and of the surface on flat slopes, for the report."""
    lean = np.abs(paint.lean)
    gone = lean > np.cos(np.radians(GONE_DEG - _ROUNDING_DEG))
    degraded = ~gone & (lean > np.cos(np.radians(DEGRADED_DEG - _ROUNDING_DEG)))
    painted = paint.mean > 0
    contrast, area = max(float(paint.contrast.sum()), 1e-12), max(float(paint.area.sum()), 1e-12)
    return {
        "painted_contrast": paint.mean,
        "contrast_degraded": float(paint.contrast[degraded].sum()) / contrast if painted else 0.0,
        "contrast_gone": float(paint.contrast[gone].sum()) / contrast if painted else 0.0,
        "area_degraded": float(paint.area[degraded].sum()) / area,
        "area_gone": float(paint.area[gone].sum()) / area,
    }


def slope_warnings(report: dict[str, float]) -> list[str]:
    """A warning if much of the picture lies on flat slopes."""
    lost = report["contrast_gone"]
    if lost < WARNED_SHARE:
        return []
    return [
        f"{lost:.0%} of the painted contrast lies on slopes flatter than {GONE_DEG:.0f}° and will not show; "
        "Suggest Orientation turns the object"
    ]
