"""Suggest Orientation: which side up keeps most of the painted contrast on slopes that show it (paper, section 7)."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from ..model import BoolArray, FloatArray, IntArray, TriangleMesh
from ..printability.slopes import DEGRADED_DEG, GONE_DEG, FaceContrast
from ..records import dataclass
from ..settings import PrintSettings

SUPPORT_WEIGHT, HEIGHT_WEIGHT, STANDING_WEIGHT = 0.4, 0.1, 0.15
"""What support over half the surface, the greatest height of all, and standing on a tip cost against all contrast."""

CANDIDATES = 8
_FLAT_FACES = 12
_LEAST_FLAT_SHARE = 0.01
_NORMAL_GRID = 0.05
_SAME_COS = np.cos(np.radians(5.0))
_ON_BED_MM = 0.3
_FOOT_MM = 1.0
_STEADY_RATIO = 0.3  # of the foot's width to the height: what stands on less may fall


@dataclass(frozen=True)
class Orientation:
    """One way to stand the object on the bed.

    Attributes:
        up: the object's direction that is to point up; (0, 0, 1) leaves it as it stands.
        contrast: share of the painted contrast that slopes can show, 1 if nothing is painted.
        support_mm2: area of overhangs that need support, seen from below.
        height_mm: of the object.
        bed_mm2: area of the faces that lie on the bed.
        foot_mm: twice the way from below the middle of the surface to the border of what stands on the bed; 0 if the
            object would fall over.
        score: the greater, the better.
    """

    up: tuple[float, float, float]
    contrast: float
    support_mm2: float
    height_mm: float
    bed_mm2: float
    foot_mm: float
    score: float

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return asdict(self)


def suggested(mesh: TriangleMesh, paint: FaceContrast, settings: PrintSettings) -> list[Orientation]:
    """The best orientations that fit the printer, the best one first; the present one is always among them.

    Args:
        mesh: F faces.
        paint: on them.
        settings: support_threshold_angle and the printer are used.
    """
    ups = directions(mesh, paint)
    along = mesh.vertices @ ups.T
    low, height = along.min(axis=0), np.ptp(along, axis=0)
    fits = np.array([_fits(mesh, up, settings) for up in ups])
    fits[0] = True
    lean = paint.normal @ ups.T
    contrast = _shown(lean, paint)
    support, bed = _supported(mesh, paint, lean, along, low, settings)
    score = contrast - SUPPORT_WEIGHT * support / max(paint.area.sum() / 2, 1e-12)
    score -= HEIGHT_WEIGHT * height / height.max()
    middle = np.average(mesh.vertices[mesh.faces].mean(axis=1), axis=0, weights=np.maximum(paint.area, 1e-12))
    foot = np.array([_foot(mesh, middle, up, heights) for up, heights in zip(ups, along.T, strict=True)])
    score -= STANDING_WEIGHT * np.clip(1.0 - foot / (_STEADY_RATIO * height), 0.0, 1.0)
    order = np.argsort(-score, kind="stable")
    order = order[fits[order]]
    kept = order[:CANDIDATES]
    if 0 not in kept:
        kept = np.append(kept[: CANDIDATES - 1], 0)
    return [
        Orientation(
            (float(ups[k, 0]), float(ups[k, 1]), float(ups[k, 2])),
            *(float(value[k]) for value in (contrast, support, height, bed, foot, score)),
        )
        for k in kept
    ]


def directions(mesh: TriangleMesh, paint: FaceContrast) -> FloatArray:
    """(D, 3) distinct unit vectors to try as up, the present one first.

    Those from the middle of a cube to its sides, edges and corners, the object's principal axes, and those that lay
    one of its large flat faces on the bed.
    """
    grid = np.stack(np.meshgrid(*[[-1.0, 0.0, 1.0]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    grid = grid[np.any(grid != 0, axis=1)]
    center = mesh.vertices[mesh.faces].mean(axis=1)
    away = center - np.average(center, axis=0, weights=np.maximum(paint.area, 1e-12))
    axes = np.linalg.eigh(np.einsum("f,fi,fj->ij", paint.area, away, away))[1].T
    found = np.concatenate([[[0.0, 0.0, 1.0]], -_flat_faces(paint), axes, -axes, grid])
    found /= np.linalg.norm(found, axis=1)[:, None]
    alike = np.triu(found @ found.T > _SAME_COS, 1).any(axis=0)
    return np.asarray(found[~alike])


def upright(up: tuple[float, float, float] | FloatArray) -> FloatArray:
    """(3, 3) the rotation by the least angle that brings a unit vector upright."""
    x, y, z = (float(value) for value in up)
    if z < -1.0 + 1e-9:
        return np.diag([1.0, -1.0, -1.0])
    cross = np.array([[0.0, 0.0, -x], [0.0, 0.0, -y], [x, y, 0.0]])
    return np.asarray(np.eye(3) + cross + cross @ cross / (1.0 + z))


def _flat_faces(paint: FaceContrast) -> FloatArray:
    """(≤ 12, 3) normals of the largest groups of faces that look the same way."""
    cell = np.round(paint.normal / _NORMAL_GRID).astype(np.int64)
    _, group = np.unique(cell, axis=0, return_inverse=True)
    group = group.reshape(-1)
    area = np.bincount(group, paint.area)
    normal = np.stack([np.bincount(group, paint.area * paint.normal[:, axis]) for axis in range(3)], axis=1)
    largest: IntArray = np.argsort(-area, kind="stable")[:_FLAT_FACES]
    largest = largest[(area[largest] > _LEAST_FLAT_SHARE * area.sum()) & (normal[largest] != 0).any(axis=1)]
    return np.asarray(normal[largest] / np.linalg.norm(normal[largest], axis=1)[:, None])


def _shown(lean: FloatArray, paint: FaceContrast) -> FloatArray:
    """(D,) share of the contrast that shows: none below 20° from flat, all above 30°, a part in between."""
    if paint.mean == 0:
        return np.ones(lean.shape[1])
    from_flat = np.degrees(np.arccos(np.clip(np.abs(lean), 0.0, 1.0)))
    shown = np.clip((from_flat - GONE_DEG) / (DEGRADED_DEG - GONE_DEG), 0.0, 1.0)
    return np.asarray(paint.contrast @ shown / paint.contrast.sum())


def _supported(
    mesh: TriangleMesh,
    paint: FaceContrast,
    lean: FloatArray,
    along: FloatArray,
    low: FloatArray,
    settings: PrintSettings,
) -> tuple[FloatArray, FloatArray]:
    """(D,) area of overhangs that need support, and (D,) area on the bed, mm²."""
    on_bed: BoolArray = np.ones(lean.shape, dtype=bool)
    for corner in mesh.faces.T:
        on_bed &= along[corner] < low + _ON_BED_MM
    flat = np.cos(np.radians(settings.support_threshold_angle))
    seen = paint.area[:, None] * np.maximum(-lean, 0.0)
    hangs = (-lean > flat + 1e-9) & ~on_bed
    return (seen * hangs).sum(axis=0), (seen * (on_bed & (-lean > 0.9))).sum(axis=0)


def _foot(mesh: TriangleMesh, middle: FloatArray, up: FloatArray, heights: FloatArray) -> float:
    """See `Orientation.foot_mm`; of the vertices right above the bed, seen along eight directions."""
    turn = np.arange(8) * (np.pi / 8)
    sideways = upright(up)[:2].T @ np.stack([np.cos(turn), np.sin(turn)])
    low = (mesh.vertices[heights < heights.min() + _FOOT_MM] - middle) @ sideways
    return 2.0 * max(float(np.minimum(low.max(axis=0), -low.min(axis=0)).min()), 0.0)


def _fits(mesh: TriangleMesh, up: FloatArray, settings: PrintSettings) -> bool:
    size = np.ptp(mesh.vertices @ upright(up).T, axis=0)
    room = np.subtract(settings.printer_profile.reach_max, settings.printer_profile.reach_min)
    return bool((size <= room).all() or (size[[1, 0, 2]] <= room).all())
