"""How visible a seam would be at each place, for the sampling to avoid such places, and for the report.

Three settings say so, and their values are multiplied: `front`, the front side of the object; `seam_visibility`, which
is painted; and `hide_seams`, from the picture and the shape: strands of one color show no pattern that could be
broken, and creases are hardly visible.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..contours.contours import OPEN_AIR, Contours
from ..model import FloatArray, ToneImage, TriangleMesh
from ..settings import PrintSettings
from ..texture.lookup import tone_at
from ..texture.pyramid import build_pyramids

# Visibility of a seam where everything is of one color, and in the deepest crease.
HIDDEN = 0.2


def uses_visibility(mesh: TriangleMesh, settings: PrintSettings) -> bool:
    """Whether the visibility of seams is set, and the pattern has waves that could have seams."""
    painted = mesh.face_visibility is not None or mesh.face_visibility_texture is not None
    return settings.pattern != "offset" and (settings.front or settings.hide_seams or painted)


def seam_visibility(
    lines: Contours,
    plane: FloatArray,
    mesh: TriangleMesh,
    textures: tuple[ToneImage, ...],
    tone: FloatArray | None,
    settings: PrintSettings,
) -> FloatArray | None:
    """(N,) 0 to 1, how visible a seam is at each contour point; None if all are equally visible.

    Args:
        lines: N contour points.
        plane: (L,) mm, height at which each layer was cut.
        mesh: that was sliced.
        textures: of the mesh.
        tone: (N,) asked for, needed by `hide_seams`.
        settings: front, front_angle and hide_seams are used.
    """
    if not uses_visibility(mesh, settings):
        return None
    seen = painted_visibility(lines, plane, mesh, textures, settings)
    if settings.front:
        seen = seen * front_visibility(lines.normal, settings.front_angle)
    if settings.hide_seams and tone is not None:
        seen = seen * tone_visibility(tone) * crease_visibility(lines)
    return np.asarray(seen)


def front_visibility(normal: FloatArray, front_deg: float) -> FloatArray:
    """(N,) apparent size of each piece of wall from the front: 1 where it faces the front, 0 where it is turned away.

    Args:
        normal: (N, 2) unit vectors.
        front_deg: direction of the front about the vertical axis: 0 is -Y, 90 is +X.
    """
    turn, (x, y) = np.radians(front_deg), normal.T
    return np.asarray(np.clip(np.sin(turn) * x - np.cos(turn) * y, 0.0, 1.0))


def tone_visibility(tone: FloatArray) -> FloatArray:
    """(N,) how visible the strands of the rarer color are: fully at mid-gray, little near black and white."""
    return np.asarray(np.maximum(2 * np.minimum(tone, 1 - tone), HIDDEN))


def crease_visibility(lines: Contours) -> FloatArray:
    """(N,) less where the line has less room outwards, since another wall or the other side of a crease is near."""
    # Squared, so that a right-angled crease, whose deepest points have about half the room, hides most of a seam.
    return np.asarray(np.clip((lines.room_outside / OPEN_AIR) ** 2, HIDDEN, 1.0))


def painted_visibility(
    lines: Contours, plane: FloatArray, mesh: TriangleMesh, textures: tuple[ToneImage, ...], settings: PrintSettings
) -> FloatArray:
    """(N,) painted visibility: from a picture where the face has one, else from its corner values, else 1."""
    own = np.ones(len(lines.arc))
    if mesh.face_visibility is not None:
        own = _between_corners(mesh, mesh.face_visibility, lines, plane)
    if mesh.face_visibility_texture is None:
        return own
    pictured = replace(mesh, face_texture=mesh.face_visibility_texture)
    pyramids = build_pyramids(pictured, textures, 2 * settings.layer_height, "trilinear")
    return tone_at(pyramids, lines.face, lines.carried[:, :2], own, 1.0)


def _between_corners(mesh: TriangleMesh, values: FloatArray, lines: Contours, plane: FloatArray) -> FloatArray:
    """(N,) values (F, 3) at the corners of faces, interpolated at the points of the faces nearest to the contours."""
    height = plane[lines.layer[lines.loop]]
    a, b, c = mesh.vertices[mesh.faces[lines.face]].transpose(1, 0, 2)
    u, v, w = b - a, c - a, np.column_stack([lines.points, height]) - a
    uu, uv, vv, uw, vw = (np.einsum("ij,ij->i", one, other) for one, other in ((u, u), (u, v), (v, v), (u, w), (v, w)))
    area = np.maximum(uu * vv - uv * uv, 1e-30)
    second, third = np.clip([(vv * uw - uv * vw) / area, (uu * vw - uv * uw) / area], 0.0, 1.0)
    over = np.maximum(second + third, 1.0)
    second, third = second / over, third / over
    corner = values[lines.face]
    mixed = corner[:, 0] * (1 - second - third) + corner[:, 1] * second + corner[:, 2] * third
    return np.asarray(np.clip(mixed, 0.0, 1.0))


def at_arcs(visibility: FloatArray | None, lines: Contours, arc: FloatArray) -> FloatArray | None:
    """(Q,) the visibility at places on the contours; None if there is none."""
    return None if visibility is None else visibility[lines.locate(arc)[0]]


def visibility_warnings(mesh: TriangleMesh, settings: PrintSettings) -> list[str]:
    """Warns where settings on the visibility of seams have no effect."""
    if settings.pattern == "offset" and (settings.front or settings.hide_seams or settings.seam_visibility):
        return [
            "the pattern offset has no waves and no seams to hide: front, seam_visibility and hide_seams do nothing"
        ]
    if settings.sampling == "paper" and uses_visibility(mesh, settings):
        return ["sampling = paper puts seams anywhere: choose optimized to have them where they are not seen"]
    return []
