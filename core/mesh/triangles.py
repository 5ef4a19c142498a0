"""The object as it is sliced: checked, triangulated, welded and placed on the bed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import MeshError, TextureError
from ..model import FloatArray, IntArray, SurfaceModel, TriangleMesh, bounds
from ..records import dataclass
from ..settings import PrintSettings
from .polygons import triangle_corners

WELD_SHARE = 3e-7
"""Vertices nearer than this share of the object's size are merged: a few times the resolution of float32."""

_OBLIQUE = np.array([1.0, 0.6180339887, 0.3819660113])  # hardly any two vertices lie at the same place along it
_STEPS = 1 << 10  # that the tolerance is measured in; the whole object takes no more than 32 bits of them
_FAR_AWAY_MM = 1e7  # beyond this, neighboring vertices could no longer be told apart
_REACH_TOLERANCE_MM = 1e-3
_USUAL_MM = 5.0  # an object is rarely shorter than this
_UNITS = {
    "inches": 25.4,
    "centimeters": 10.0,
    "meters": 1e3,
    "kilometers": 1e6,
}
"""Units that files are written in by mistake, and mm per unit, the likeliest first."""
_HEIGHT_HINT = "check its unit or choose its height (in Blender: Scale to Height; on the command line: --height-mm)"
_SMALLER = (1e-3, 1e-6)  # factors for what is too large, whose unit nobody could guess
_UV_LIMIT = 1e6  # beyond this, float32 no longer tells the texels apart


def triangulate(model: SurfaceModel, settings: PrintSettings) -> TriangleMesh:
    """Check, triangulate, weld and place a mesh.

    With `center_on_bed` the middle of the bounding box goes to x = y = 0 and its lowest point to z = 0; else the
    object stays where it is. Corners with a UV that is not finite lose their texture.

    Raises:
        MeshError: no faces, coordinates that are not finite, indices that do not fit, or a size that cannot be printed.
        TextureError: a texture but no UV map.
    """
    corner_vertex, vertices = checked(model)
    shift = -vertices[0]
    vertices = placed(vertices, settings.center_on_bed)
    shift += vertices[0]
    check_size(vertices, model.name, settings)
    triangles = _triangles(model, corner_vertex, vertices)
    faces = triangles.of_corners(corner_vertex)
    distinct, welded = weld(vertices, _vertex_object(model, corner_vertex, len(vertices)))
    if len(distinct) < len(vertices):
        faces = welded.take(faces)
    a, b, c = faces.T
    proper = (a != b) & (b != c) & (c != a)
    if not proper.any():
        raise MeshError(f"{model.name} has no face with an area", "check the mesh for collapsed faces")
    if not proper.all():
        kept = np.flatnonzero(proper)
        triangles, faces = replace(triangles, kept=kept), faces.take(kept, axis=0)
    face_uv, face_texture = _painting(model, triangles)
    tone, visibility = (_of_corners(table, triangles) for table in (model.corner_tone, model.corner_visibility))
    face_object, face_support, face_visibility = (
        None if table is None else triangles.of_polygons(table)
        for table in (model.polygon_object, model.polygon_support, model.polygon_visibility)
    )
    return TriangleMesh(
        distinct, faces, face_uv, np.broadcast_to(np.nan, faces.shape) if tone is None else tone, face_texture,
        face_object, face_support, tuple(volume.moved(shift) for volume in model.volumes), visibility, face_visibility,
    )  # fmt: skip


@dataclass(frozen=True)
class _Triangles:
    """Which corners and polygons the triangles come from.

    Attributes:
        corners: (T', 3) corners of each, None if they are all corners in turn.
        polygon: (T',) the polygon that it is part of, None if they are all polygons in turn.
        kept: (T,) those that have an area, None for all.
    """

    corners: IntArray | None
    polygon: IntArray | None
    kept: IntArray | None = None

    def of_corners(self, table: NDArray[Any]) -> NDArray[Any]:
        """(T, 3, …) rows of their corners, a view of the table where it can be one."""
        rows = table.reshape(-1, 3, *table.shape[1:]) if self.corners is None else table.take(self.corners, axis=0)
        return rows if self.kept is None else rows.take(self.kept, axis=0)

    def of_polygons(self, table: NDArray[Any]) -> NDArray[Any]:
        """(T,) values of their polygons, likewise."""
        rows = table if self.polygon is None else table.take(self.polygon)
        return rows if self.kept is None else rows.take(self.kept)


def _triangles(model: SurfaceModel, corner_vertex: IntArray, vertices: FloatArray) -> _Triangles:
    """All triangles of a model."""
    if (model.sides == 3).all():
        return _Triangles(None, None)
    return _Triangles(*triangle_corners(vertices, model.polygon_start, corner_vertex))


def checked(model: SurfaceModel) -> tuple[IntArray, FloatArray]:
    """Corners' vertices (C,) and coordinates (V', 3) without the vertices that no face uses.

    Raises:
        MeshError: no faces, coordinates that are not finite or indices that do not fit.
        TextureError: a texture but no UV map.
    """
    _check_indices(model)
    corner_vertex, vertices = _used_vertices(model)
    _check_coordinates(vertices, model.name)
    return corner_vertex, vertices


def _check_indices(model: SurfaceModel) -> None:
    """Refuse a mesh without faces or with tables that do not fit each other."""
    start, corner = model.polygon_start, model.corner_vertex
    if not len(model.vertices) or model.sides.max(initial=0) < 3:
        raise MeshError(f"{model.name} has no faces", "choose a mesh object with a closed surface")
    fits = start[0] == 0 and start[-1] == len(corner) and model.sides.min() >= 0
    if not fits or corner.min() < 0 or corner.max() >= len(model.vertices):
        raise MeshError(f"{model.name} has faces that use vertices it does not have", "repair or export the mesh again")
    textures = [table for table in (model.polygon_texture, model.polygon_visibility) if table is not None]
    if any(len(table) != len(start) - 1 or table.max() >= len(model.textures) for table in textures):
        raise MeshError(f"{model.name} has faces that use textures it does not have", "assign the picture again")
    if model.corner_uv is None and any((table >= 0).any() for table in textures):
        raise TextureError(f"{model.name} has a texture but no UV map", "unwrap the mesh first")


def _used_vertices(model: SurfaceModel) -> tuple[IntArray, FloatArray]:
    """Corners' vertices (C,) and coordinates (V', 3) without the vertices that no face uses."""
    used = np.zeros(len(model.vertices), dtype=bool)
    used[model.corner_vertex] = True
    if used.all():
        return np.asarray(model.corner_vertex, dtype=np.int64), np.asarray(model.vertices, dtype=np.float64)
    renumbered = np.cumsum(used) - 1
    return renumbered[model.corner_vertex], np.asarray(model.vertices[used], dtype=np.float64)


def _check_coordinates(vertices: FloatArray, name: str) -> None:
    if not np.isfinite(vertices).all():
        count = int((~np.isfinite(vertices)).any(axis=1).sum())
        number = "a vertex" if count == 1 else f"{count} vertices"
        raise MeshError(f"{name} has {number} whose coordinates are not finite numbers", "delete or repair them")
    farthest = np.abs(vertices).max()
    if farthest > _FAR_AWAY_MM:
        raise MeshError(f"{name} reaches {farthest:.3g} mm from the origin", "check its location, scale and unit")


def placed(vertices: FloatArray, center_on_bed: bool) -> FloatArray:
    """Vertices (V, 3), with `center_on_bed` moved onto the middle of the bed."""
    if not center_on_bed:
        return vertices
    low, high = bounds(vertices)
    anchor = ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2])
    moved = np.empty_like(vertices)
    for axis in range(3):
        np.subtract(vertices[:, axis], anchor[axis], out=moved[:, axis])
    return moved


def check_size(vertices: FloatArray, name: str, settings: PrintSettings) -> None:
    """Refuse objects beyond the printer's reach, or so small that their unit must be wrong."""
    low, high = bounds(vertices)
    size = high - low
    sizes = f"{' × '.join(_length(side) for side in size)} mm"
    printer = settings.printer_profile
    least, most = np.array(printer.reach_min), np.array(printer.reach_max)
    room = " × ".join(_length(side) for side in most - least)
    if (size > most - least + _REACH_TOLERANCE_MM).any():
        turned = (size[[1, 0, 2]] <= most - least + _REACH_TOLERANCE_MM).all()
        hint = "turn it by 90° about the vertical axis" if turned else _unit_hint(size, most - least)
        raise MeshError(f"{name} is {sizes}, larger than the {room} mm that can be printed", hint)
    if size.max() < 1.0:
        raise MeshError(f"{name} is only {sizes}", _unit_hint(size, most - least))
    if size[2] <= settings.first_layer_height / 2:
        raise MeshError(f"{name} is {_length(size[2])} mm high, less than half a layer", "give it some thickness")
    if low[2] < -_REACH_TOLERANCE_MM:
        raise MeshError(f"{name} reaches {_length(-low[2])} mm below the bed", "raise it or turn on center_on_bed")
    if (low < least - _REACH_TOLERANCE_MM).any() or (high > most + _REACH_TOLERANCE_MM).any():
        raise MeshError(f"{name} lies beyond the {room} mm that can be printed", "move it or turn on center_on_bed")


def size_warnings(mesh: TriangleMesh, name: str, settings: PrintSettings) -> list[str]:
    """A warning about an object that is printed although its unit is probably wrong."""
    if (hint := size_hint(mesh, settings)) is None:
        return []
    return [f"{name} is only {_length(float(np.ptp(mesh.bounds, axis=0).max()))} mm long; {hint}"]


def size_hint(mesh: TriangleMesh, settings: PrintSettings) -> str | None:
    """What to do about an object whose unit is probably wrong; None for one of a usual size."""
    size, printer = np.ptp(mesh.bounds, axis=0), settings.printer_profile
    if size.max() >= _USUAL_MM:
        return None
    return _unit_hint(size, np.subtract(printer.reach_max, printer.reach_min))


def _unit_hint(size: FloatArray, room: FloatArray) -> str:
    """What to do about a size (3,) in mm that is probably wrong: the unit in which it would be a usual one."""
    length = float(size.max())
    said = {factor: f"in {unit} it would be {{}} mm long, so scale it by {factor:g}" for unit, factor in _UNITS.items()}
    said |= {factor: f"scaled by {factor:g} it would be {{}} mm long" for factor in _SMALLER}
    fitting = [
        text.format(_length(length * factor))
        for factor, text in said.items()
        if length * factor >= _USUAL_MM and (size * factor <= room).all()
    ]
    return f"check its scale and unit: {fitting[0]}" if fitting else _HEIGHT_HINT


def _length(millimeters: float) -> str:
    """A length in three digits or so, whole millimeters where that is enough."""
    return f"{millimeters:.0f}" if 100 <= millimeters < 1e7 else f"{millimeters:.3g}"


def _vertex_object(model: SurfaceModel, corner_vertex: IntArray, count: int) -> IntArray | None:
    """(V,) the object on the plate that each vertex belongs to, None for a single one."""
    if model.polygon_object is None:
        return None
    owner = np.zeros(count, dtype=np.int64)
    owner[corner_vertex] = np.repeat(model.polygon_object, model.sides)
    return owner


def weld(vertices: FloatArray, owner: IntArray | None = None) -> tuple[FloatArray, IntArray]:
    """Merge vertices that lie at the same place and have the same owner (V,), if there are any.

    Sorted along an axis, vertices are cut into runs wherever two are farther apart than the tolerance, and each run
    again along the next axis; vertices still in one run are merged. Unlike with a rounded grid, no pair is separated by
    the border of a cell, and runs that are long by chance are cut along another axis. The first axis is oblique, so
    that hardly any two distinct vertices share a place on it.

    Returns:
        (W, 3) distinct vertices, each at the place of the first one merged, and (V,) where each vertex went.
    """
    tolerance = WELD_SHARE * np.ptp(bounds(vertices), axis=0).max()
    near = np.arange(len(vertices))
    group = np.zeros(len(vertices), dtype=np.int64) if owner is None else owner
    for column, reach in (
        (np.einsum("ij,j->i", vertices, _OBLIQUE), tolerance * _OBLIQUE.sum()),
        *((x, tolerance) for x in vertices.T),
    ):
        step = _steps_along(column[near], reach)
        order = _order(step)
        if group.any():
            # By group first; sorting numbers that hold group and rank takes a third of the time of `lexsort`.
            bits = len(near).bit_length()
            order = order[np.sort((group[order] << bits) | np.arange(len(near))) & ((1 << bits) - 1)]
        near, group, step = near.take(order), group.take(order), step.take(order)
        begins = np.append(True, (group[1:] != group[:-1]) | (step[1:] - step[:-1] > _STEPS))[: len(near)]
        group = np.cumsum(begins) - 1
        shared = ~(begins & np.append(begins[1:], True))  # the others have nothing near them
        near, group = near[shared], group[shared]
    into = np.arange(len(vertices))
    if len(near):
        begin = np.flatnonzero(np.diff(group, prepend=-1))
        first = np.minimum.reduceat(near, begin)
        into[near] = np.repeat(first, np.diff(begin, append=len(near)))
        stays = into == np.arange(len(vertices))
        vertices, into = vertices[stays], (np.cumsum(stays) - 1)[into]
    return vertices, into


def _steps_along(column: FloatArray, reach: float) -> NDArray[np.uint32]:
    """Places (N,) along an axis, of which `reach` takes `_STEPS`, from the least on."""
    along = column - column.min(initial=np.inf)
    along *= _STEPS / max(reach, 1e-300)
    return np.asarray(np.rint(along, out=along), dtype=np.uint32)


def _order(number: NDArray[np.uint32]) -> IntArray:
    """What sorts numbers (N,): half of their digits after the other, which takes a quarter of the time of `argsort`."""
    low, high = ((number >> shift).astype(np.uint16) for shift in (0, 16))
    order = np.argsort(low, kind="stable")
    return order.take(np.argsort(high.take(order), kind="stable"))


def _painting(model: SurfaceModel, triangles: _Triangles) -> tuple[FloatArray, IntArray]:
    """UVs (T, 3, 2) and textures (T,) of triangles; those with a UV that is not finite or huge get no texture."""
    texture = triangles.of_polygons(model.polygon_texture)
    if texture.min() < -1:
        texture = np.maximum(texture, -1)
    if model.corner_uv is None:
        return np.zeros((len(texture), 3, 2)), texture
    uv = np.asarray(triangles.of_corners(model.corner_uv), dtype=np.float64)
    if uv.min() >= -_UV_LIMIT and uv.max() <= _UV_LIMIT:  # NaN fails as well
        return uv, texture
    broken = ~(np.abs(uv) <= _UV_LIMIT).all(axis=(1, 2))
    uv, texture = uv.copy(), texture.copy()
    uv[broken], texture[broken] = 0.0, -1
    return uv, texture


def _of_corners(table: FloatArray | None, triangles: _Triangles) -> FloatArray | None:
    return None if table is None else triangles.of_corners(table)
