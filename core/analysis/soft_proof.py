"""The soft proof: how a painted texture will look in print, as tables that the graphics card can look up.

They say how fine a detail shows and which tone a wall of any slope shows, so they hold while the texture is painted.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..calibration.calibrate import table_for
from ..calibration.gamut_mapping import image_range, printable_tones
from ..calibration.provenance import tone_settings
from ..mesh.checks import checked
from ..mesh.polygons import triangle_corners
from ..mesh.surface_points import points_on_faces
from ..model import Float32Array, FloatArray, IntArray, SurfaceModel
from ..records import dataclass
from ..settings import PrintSettings

TAPS = 3
"""Places along each side of the window; the mean over all of them is what the print shows."""

_TONES, _SLANTS = 65, 19
_MOST_POINTS = 100_000
_UV_ROUNDING = 1e-6


@dataclass(frozen=True)
class ProofTable:
    """What the print shows of each tone, for S slopes and K tones; values between them are interpolated.

    Attributes:
        tone: (K,) asked for, evenly from 0 to 1.
        slant_deg: (S,) of the wall, evenly from 0 upright to 90 looking up; overhangs count as upright.
        reflectance: (S, K) linear, face on.
        notes: about the table, one sentence each.
    """

    tone: FloatArray
    slant_deg: FloatArray
    reflectance: FloatArray
    notes: tuple[str, ...]


def proof_table(settings: PrintSettings, shown: tuple[float, float]) -> ProofTable:
    """How the print will show tones.

    A tone beyond the picture's own range is shown as if the picture had it, so a stroke darker than everything else
    shows at once. How it changes the other tones needs a new table.

    Args:
        settings: of the pattern and the calibration.
        shown: darkest and lightest tone on the surface, from `tone_range`.

    Raises:
        CalibrationError: calibration_file cannot be read.
    """
    tone, slant = np.linspace(0.0, 1.0, _TONES), np.linspace(0.0, 90.0, _SLANTS)
    table = table_for(settings)
    seen = printable_tones(tone, slant, table, shown, settings).seen
    for column in np.flatnonzero((tone < shown[0]) | (tone > shown[1])):
        wider = min(shown[0], tone[column]), max(shown[1], tone[column])
        seen[:, column] = printable_tones(tone[[column]], slant, table, wider, settings).seen[:, 0]
    differences = table.provenance.differences(settings)
    notes = [f"the tone table holds for other settings ({', '.join(differences)})"] if differences else []
    return ProofTable(tone, slant, seen, tuple(notes))


def proof_window(settings: PrintSettings) -> tuple[float, float]:
    """Width and height in mm of what an upright wall shows as one tone: a layer pair high, with waves a wave wide.

    On a leaning wall the layers lie farther apart along the surface; the window is higher by the same factor.
    """
    pair = 2 * settings.layer_height
    return (pair if settings.pattern == "offset" else max(pair, settings.wavelength)), pair


def proof_settings(settings: PrintSettings) -> dict[str, Any]:
    """The settings that the proof depends on, by name."""
    values = settings.as_dict()
    others = ("wavelength", "background_tone", "calibration", "calibration_file", "gamut_mapping")
    return tone_settings(settings) | {name: values[name] for name in others}


def repeats(model: SurfaceModel) -> bool:
    """Whether UVs leave the picture, so that it is repeated; otherwise its border texels are extended."""
    uv = model.corner_uv
    return uv is not None and bool(uv.min(initial=0.0) < -_UV_ROUNDING or uv.max(initial=1.0) > 1 + _UV_ROUNDING)


def tone_range(model: SurfaceModel, settings: PrintSettings) -> tuple[float, float]:
    """The darkest and the lightest tone on the walls of a surface, at the resolution of the print, specks left out.

    Sampled at points all over the surface, without the pyramids of the job. Flat faces do not count: they are printed
    in lines, not in tones.

    Raises:
        MeshError: no faces, or coordinates that are not finite.
        TextureError: a texture but no UV map.
    """
    corner_vertex, vertices = checked(model)
    corner, polygon = triangle_corners(vertices, model.polygon_start, corner_vertex)
    places = vertices[corner_vertex[corner]]
    cross = np.cross(places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]) / 2
    area, wall = np.linalg.norm(cross, axis=1), np.hypot(cross[:, 0], cross[:, 1])
    on = points_on_faces(places, max(settings.layer_height, float(np.sqrt(2 * area.sum() / _MOST_POINTS))))
    tone = np.full(len(on.face), settings.background_tone)
    if model.corner_tone is not None:
        given = np.einsum("qc,qc->q", on.share, model.corner_tone[corner[on.face]])
        tone = np.where(np.isfinite(given), given, tone)
    if model.corner_uv is not None:
        uv = np.nan_to_num(model.corner_uv[corner])
        at, reach = np.einsum("qc,qcd->qd", on.share, uv[on.face]), _reach(uv, area, settings)
        texture = model.polygon_texture[polygon][on.face]
        for number in range(len(model.textures)):
            chosen = np.flatnonzero(texture == number)
            tone[chosen] = _averaged(model, number, at[chosen], reach[on.face[chosen]], settings.background_tone)
    return image_range(tone, on.weight * wall[on.face])


def _reach(uv: FloatArray, area: FloatArray, settings: PrintSettings) -> FloatArray:
    """(T,) side in UV units of a square as high as a layer pair; triangles have UVs (T, 3, 2) and areas in mm²."""
    a, b = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    charted = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2
    return np.asarray(2 * settings.layer_height * np.sqrt(charted / np.maximum(area, 1e-12)))


def _averaged(
    model: SurfaceModel, number: int, uv: FloatArray, reach: FloatArray, background_tone: float
) -> FloatArray:
    """(n,) mean tone of a texture over squares of side `reach` (n,) about UVs (n, 2)."""
    picture = model.textures[number]
    painted = picture.alpha * picture.tone + (1.0 - picture.alpha) * np.float32(background_tone)
    painted = _coarser(painted, float(np.median(reach)) * max(painted.shape) / (2 * TAPS) if len(reach) else 1.0)
    height, width = painted.shape
    steps = (np.arange(TAPS) + 0.5) / TAPS - 0.5
    total = np.zeros(len(uv))
    for across in steps:
        for up in steps:
            column = _texel(uv[:, 0] + across * reach, width, repeats(model))
            row = _texel(uv[:, 1] + up * reach, height, repeats(model))
            total += painted[row, column]
    return total / TAPS**2


def _coarser(painted: Float32Array, texels: float) -> Float32Array:
    """(h, w) means of (H, W) over squares of `texels` texels a side, rounded down; an incomplete border is dropped."""
    side = min(int(texels), *painted.shape)
    if side < 2:
        return painted
    height, width = (length // side for length in painted.shape)
    cut = painted[: height * side, : width * side].reshape(height, side, width, side)
    return np.asarray(cut.mean(axis=(1, 3)), dtype=np.float32)


def _texel(place: FloatArray, count: int, wraps: bool) -> IntArray:
    """(n,) number of the texel at each place, where 0 to 1 is the picture."""
    texel: IntArray = np.floor(place * count).astype(np.int64)
    return texel % count if wraps else np.clip(texel, 0, count - 1)
