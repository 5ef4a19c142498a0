"""The slope advisor: how much of the painted contrast lies on surfaces too flat to show it (paper, section 6.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..model import FloatArray, IntArray, TriangleMesh
from ..pattern.slant import face_slant_deg, slant_deg_of
from ..settings import PrintSettings
from ..texture.lookup import tone_at
from ..texture.pyramid import TexturePyramids
from .surface_points import points_on_faces

DEGRADED_DEG, GONE_DEG = 30.0, 20.0
"""Degrees from flat below which the tone loses resolution, and below which there is none (paper, Figure 9)."""

WARNED_SHARE = 0.25
_STEP_MM = 1.0
_MOST_POINTS = 200_000
_LEAST_CONTRAST = 1e-6
_ROUNDING_DEG = 1e-6
_CHUNK_FACES = 1 << 16  # worked on at once


@dataclass(frozen=True)
class FaceContrast:
    """What is painted on each of F faces.

    Attributes:
        area: (F,) mm².
        contrast: (F,) mm², the distance of the tone from the mean tone of the whole surface, integrated over the face.
        normal: (F, 3) unit vectors outwards, zero on faces without an area.
    """

    area: FloatArray
    contrast: FloatArray
    normal: FloatArray

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
    length = np.linalg.norm(mesh.area_normals, axis=1)
    normal = mesh.area_normals / np.maximum(length, 1e-12)[:, None]
    area = length / 2
    step = max(_STEP_MM, float(np.sqrt(2 * area.sum() / _MOST_POINTS)))
    parts = [
        _paint(mesh, slice(first, first + _CHUNK_FACES), step, pyramids, settings)
        for first in range(0, len(area), _CHUNK_FACES)
    ]
    face, weight, tone = (np.concatenate(column) for column in zip(*parts, strict=True))
    weight *= area[face]
    mean = float((weight * tone).sum() / max(weight.sum(), 1e-12))
    contrast = np.asarray(np.bincount(face, weight * np.abs(tone - mean), len(area)), dtype=np.float64)
    return FaceContrast(area, contrast, normal)


def _paint(
    mesh: TriangleMesh, part: slice, step: float, pyramids: TexturePyramids, settings: PrintSettings
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Face, share of the face's area and tone (Q,) each at places all over some of the faces."""
    on = points_on_faces(mesh.vertices[mesh.faces[part]], step)
    face = on.face + part.start
    uv = np.einsum("qc,qcd->qd", on.share, mesh.face_uv[face])
    vertex_tone = np.einsum("qc,qc->q", on.share, mesh.face_tone[face])
    return face, on.weight, tone_at(pyramids, face, uv, vertex_tone, settings.background_tone)


def from_flat_deg(mesh: TriangleMesh) -> FloatArray:
    """(F,) degrees between each face and the horizontal, 0 to 90."""
    return np.asarray(90.0 - np.abs(face_slant_deg(mesh)))


def slope_report(paint: FaceContrast) -> dict[str, float]:
    """Shares of the painted contrast and of the surface on flat slopes, for the report."""
    angle = 90.0 - np.abs(slant_deg_of(paint.normal))
    gone = angle < GONE_DEG - _ROUNDING_DEG
    degraded = ~gone & (angle < DEGRADED_DEG - _ROUNDING_DEG)
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
    """What to do if much of the picture lies flat."""
    lost = report["contrast_gone"]
    if lost < WARNED_SHARE:
        return []
    return [
        f"{lost:.0%} of the painted contrast lies on slopes flatter than {GONE_DEG:.0f}° and will not show; "
        "Suggest Orientation turns the object"
    ]
