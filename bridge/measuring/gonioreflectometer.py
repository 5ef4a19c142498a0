"""The virtual gonioreflectometer: a calibration tile printed in simulation and read (paper, section 6.1)."""

from __future__ import annotations

import math

import bpy
import numpy as np

from ...core.calibration.provenance import Provenance, tone_settings
from ...core.calibration.readings import read_tones
from ...core.calibration.sweep import Sweep, angles_of
from ...core.calibration.tile import Tile, gradient_tile
from ...core.model import FloatArray
from ...core.pipeline import generate
from ...core.settings import PrintSettings
from ..pictures.plastics import REFLECTANCE
from .instrument import Face, Stand, mounted

MM_PER_PIXEL = 0.2
SAMPLES = 3
FACE_ON_SAMPLES = 32
TONES = 25
WINDOW_WAVES = 4.0
"""Width of the triangle of weights, in wavelengths: half as wide at half its height."""


def measure(slant_deg: float, block: str, settings: PrintSettings, light: str = "even") -> Sweep:
    """One job: print a tile with a gradient and read it from one row of directions.

    Args:
        slant_deg: of the tile.
        block: of `sweep.BLOCKS`.
        settings: of the print.
        light: "even" or "lamp".

    Raises:
        PrintError: the tile cannot be printed with these settings.
    """
    window = WINDOW_WAVES * settings.wavelength
    tile = gradient_tile(slant_deg, settings.layer_height, TONES, window)
    angles = angles_of(block)
    reflectance, noise = read_tile(tile, settings.changed({"calibration": "none"}), window, angles, light)
    turned = np.array(angles)[:, 1 if block == "theta" else 0]
    return Sweep(slant_deg, block, turned, tile.tone, reflectance, noise, provenance(settings, light))


def provenance(settings: PrintSettings, light: str = "even") -> Provenance:
    """What readings taken now are valid for."""
    source = f"Blender {bpy.app.version_string}, {'even light' if light == 'even' else 'a lamp'}"
    return Provenance(tone_settings(settings), dict(REFLECTANCE), source)


def read_tile(
    tile: Tile, settings: PrintSettings, window: float, angles: list[tuple[float, float]], light: str = "even"
) -> tuple[FloatArray, FloatArray]:
    """Slice, build and photograph a tile; face on with more samples.

    Args:
        tile: to print, T tones.
        settings: of the print; adhesion, supports and tower are left out, for they are not looked at.
        window: mm along the layers that are averaged for a tone.
        angles: (φ, θ) of each of A directions, degrees.
        light: see `mounted`.

    Returns:
        (T, A) reflectance of each tone from each direction and (T, A) its standard error.

    Raises:
        PrintError: the tile cannot be printed with these settings.
    """
    result = generate(tile.model, bare(settings))
    center = (result.mesh.bounds[0] + tile.center).tolist()
    face = Face((center[0], center[1], center[2]), tile.width, tile.height, tile.slant_deg)
    readings = []
    with mounted(result.moves, result.settings, face, light) as stand:
        for phi, theta in angles:
            samples = FACE_ON_SAMPLES if phi == theta == 0 else SAMPLES
            readings.append(_read(stand, tile, window, phi, theta, samples))
    reflectance, noise = (np.stack(columns, axis=1) for columns in zip(*readings, strict=True))
    return reflectance, noise


def bare(settings: PrintSettings) -> PrintSettings:
    """The settings without tower, skirt and everything else beside the object."""
    return settings.changed(
        {"tower_type": "none", "skirts": 0, "brim_width": 0.0, "raft_layers": 0, "ooze_shield": False,
         "support_enable": False, "center_on_bed": True}
    )  # fmt: skip


def _read(
    stand: Stand, tile: Tile, window: float, phi: float, theta: float, samples: int
) -> tuple[FloatArray, FloatArray]:
    rows = math.ceil(tile.height / MM_PER_PIXEL)
    while math.gcd(rows, tile.layers) > 1:  # then the rows hit all heights of a layer alike
        rows += 1
    mm_per_pixel = tile.height / rows
    first, second = (
        stand.photograph(phi_deg=phi, theta_deg=theta, mm_per_pixel=mm_per_pixel, samples=samples, seed=seed)
        for seed in (0, 1)
    )
    return read_tones(first, second, tile.width / first.shape[1], tile.place, window)
