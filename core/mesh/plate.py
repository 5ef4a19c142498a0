"""Several objects on one plate: arranged side by side, printed together, named one by one in messages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model import IntArray, SupportMark, SurfaceModel, ToneImage, TriangleMesh
from ..ragged import starts
from ..settings import PrintSettings
from .arrange import arranged
from .checks import checked
from .size import check_size
from .triangles import placed

_ROUNDING_MM = 1e-3


def plate(models: Sequence[SurfaceModel], settings: PrintSettings) -> SurfaceModel:
    """One model of several, each with its own pictures, colors and UVs; a single one is returned as it is.

    The objects keep their places, or with `arrange` they are put side by side, each on the bed. `triangulate` then
    places the whole on the bed.

    Args:
        models: the first gives the plate its name.
        settings: `arrange`, `arrange_distance` and the widths of brim, raft and shield are used.

    Raises:
        MeshError: one of the objects cannot be printed, or the bed has no room for all.
        TextureError: one has a texture but no UV map.
    """
    if len(models) == 1:
        return models[0]
    points = [checked(model)[1] for model in models]
    if settings.arrange:
        for model, vertices in zip(models, points, strict=True):
            check_size(placed(vertices, True), model.name, settings)
        shifts = arranged(points, [model.name for model in models], settings)
        models = [model.moved(shift) for model, shift in zip(models, shifts, strict=True)]
    return _joined(models)


def _joined(models: Sequence[SurfaceModel]) -> SurfaceModel:
    """All polygons in one table; columns that only some of the models have get a missing value for the others."""
    corners, polygons = [len(model.corner_vertex) for model in models], [len(model.polygon_texture) for model in models]
    vertex, corner = starts(np.array([len(model.vertices) for model in models])), starts(np.array(corners))
    textures: list[ToneImage] = []
    number = [_renumbered(model, textures) for model in models]
    visibility = [
        None if model.polygon_visibility is None else of[np.maximum(model.polygon_visibility, -1)]
        for model, of in zip(models, number, strict=True)
    ]
    return SurfaceModel(
        vertices=np.concatenate([model.vertices for model in models]),
        polygon_start=np.concatenate(
            [[0], *(model.polygon_start[1:] + first for model, first in zip(models, corner[:-1], strict=True))]
        ).astype(np.int64),
        corner_vertex=np.concatenate(
            [model.corner_vertex + first for model, first in zip(models, vertex[:-1], strict=True)]
        ),
        corner_uv=_column([model.corner_uv for model in models], corners, 0.0),
        corner_tone=_column([model.corner_tone for model in models], corners, np.nan),
        polygon_texture=np.concatenate(
            [of[np.maximum(model.polygon_texture, -1)] for model, of in zip(models, number, strict=True)]
        ),
        textures=tuple(textures),
        name=models[0].name,
        object_names=tuple(model.name for model in models),
        polygon_object=np.repeat(np.arange(len(models)), polygons),
        polygon_support=_column([model.polygon_support for model in models], polygons, SupportMark.NONE),
        volumes=tuple(volume for model in models for volume in model.volumes),
        corner_visibility=_column([model.corner_visibility for model in models], corners, 1.0),
        polygon_visibility=_column(visibility, polygons, -1),
        notes=tuple(note for model in models for note in model.notes),
    )


def _renumbered(model: SurfaceModel, textures: list[ToneImage]) -> IntArray:
    """(T + 1,) index of each of the model's textures in the common list, to which new ones are added.

    The last entry, -1, stands for no texture.
    """
    number = np.full(len(model.textures) + 1, -1, dtype=np.int64)
    for index, image in enumerate(model.textures):
        known = [other is image for other in textures]
        number[index] = known.index(True) if any(known) else len(textures)
        if not any(known):
            textures.append(image)
    return number


def _column(parts: Sequence[NDArray[Any] | None], rows: Sequence[int], missing: float) -> NDArray[Any] | None:
    """One column of all models, of so many `rows` each, `missing` in those that lack it; None if all do."""
    known = [part for part in parts if part is not None]
    if not known:
        return None
    shape, kind = known[0].shape[1:], known[0].dtype
    columns = zip(parts, rows, strict=True)
    whole: NDArray[Any] = np.concatenate(
        [np.full((count, *shape), missing, kind) if part is None else part for part, count in columns]
    )
    return whole


def object_rows(model: SurfaceModel, mesh: TriangleMesh) -> list[dict[str, Any]]:
    """For the report: each object's name and its place on the bed."""
    return [{"name": name, "bounds_mm": mesh.bounds_of(number).tolist()} for number, name in enumerate(model.names)]


def plate_warnings(
    model: SurfaceModel, mesh: TriangleMesh, overlapping: IntArray, settings: PrintSettings
) -> list[str]:
    """Warnings about the objects of a plate, one sentence each."""
    names, found = model.names, []
    for one, other, layers in overlapping.tolist():
        found.append(
            f"{names[one]} and {names[other]} run into each other in {layers} layers and print as one: "
            "move them apart or turn on arrange"
        )
    for number, name in enumerate(names):
        above = float(mesh.bounds_of(number)[0, 2])
        if above > settings.first_layer_height + _ROUNDING_MM:
            found.append(f"{name} begins {above:.1f} mm above the bed: lower it, or turn on arrange or supports")
    for number in _plain(mesh, len(names)):
        found.append(f"{names[number]} has no texture and no color attribute: it prints in one even tone")
    marked = mesh.volumes or (mesh.face_support is not None and mesh.face_support.any())
    if marked and not settings.support_enable:
        found.append("support enforcers and blockers do nothing while support_enable is off")
    return found


def _plain(mesh: TriangleMesh, count: int) -> list[int]:
    """The objects without any paint."""
    painted = mesh.face_texture >= 0
    if not painted.all():
        painted |= ~np.isnan(mesh.face_tone).any(axis=1)
    if mesh.face_object is None:
        return [] if painted.any() else [0]
    painted_faces = np.bincount(mesh.face_object, weights=painted, minlength=count)
    return [number for number in range(count) if not painted_faces[number]]
