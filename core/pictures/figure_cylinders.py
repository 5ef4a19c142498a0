"""Cylinders that show what the pattern can do: a gradient, and those of the paper's Figure 3."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ..model import FloatArray, ToneImage
from ..pattern.modulation import PERIOD_LAYERS
from ..records import dataclass
from ..settings import PrintSettings
from ..settings.presets import preset_values
from .shapes import PictureShape, picture_tube

_PAPER = "paper"
_BANDS = 9  # of the phase-shifted cylinder: from no shift to half a wave in the middle and back


@dataclass(frozen=True)
class FigureCylinder:
    """A cylinder to print and look at.

    Attributes:
        shape: the solid cylinder.
        picture: wrapped around it.
        settings: of the print, with those that make the pattern shown.
    """

    shape: PictureShape
    picture: ToneImage
    settings: PrintSettings


def figure_cylinder(kind: str, diameter: float, height: float, settings: PrintSettings) -> FigureCylinder:
    """One of `FIGURES`.

    Args:
        kind: its key.
        diameter: mm.
        height: mm, made whole layer pairs.
        settings: of the print; those that make the pattern shown are replaced.

    Raises:
        MeshError: a length is not positive.
    """
    shape = picture_tube(diameter, diameter, height, settings)
    made, tone = _MAKERS[kind](settings, 2 * shape.rows)
    shown = np.repeat(tone(np.linspace(0.0, 1.0, shape.rows)).astype(np.float32)[:, None], shape.columns, axis=1)
    return FigureCylinder(shape, ToneImage(shown, np.ones_like(shown)), made)


_Made = tuple[PrintSettings, Callable[[FloatArray], FloatArray]]


def _even(height: FloatArray) -> FloatArray:
    return np.full_like(height, 0.5)


def _rising(height: FloatArray) -> FloatArray:
    return height


def _gradient(settings: PrintSettings, _layers: int) -> _Made:
    return settings, _rising


def _checkered(settings: PrintSettings, layers: int) -> _Made:
    third = round(layers / 3 / PERIOD_LAYERS) * PERIOD_LAYERS
    return _as_in_the_paper(settings, {"mostly_white_below": third, "mostly_black_above": layers - third}), _even


def _phase_shifted(settings: PrintSettings, layers: int) -> _Made:
    return _as_in_the_paper(settings, {"phase_shift_layers": 2 * math.ceil(layers / _BANDS / 2)}), _even


def _attenuated(settings: PrintSettings, _layers: int) -> _Made:
    return _as_in_the_paper(settings, {}), _rising


def _as_in_the_paper(settings: PrintSettings, more: dict[str, int]) -> PrintSettings:
    """The paper's waves, without calibration."""
    return settings.changed(preset_values([_PAPER]) | {"calibration": "none"} | more)


_MAKERS: dict[str, Callable[[PrintSettings, int], _Made]] = {
    "gradient": _gradient,
    "checkered": _checkered,
    "phase_shifted": _phase_shifted,
    "attenuated": _attenuated,
}
FIGURES = {
    "gradient": ("Gradient Cylinder", "All tones from black at the bottom to white at the top"),
    "checkered": ("Checkered Cylinder", "The paper's Figure 3a: the checkerboard, with three of four layers white "
                  "below and black above"),
    "phase_shifted": ("Phase-Shifted Cylinder", "The paper's Figure 3c: white waves shifted against the black ones, "
                      "by half a wave in the middle"),
    "attenuated": ("Attenuated Cylinder", "The paper's Figure 3d: waves that get shallower, white ones downwards, "
                   "black ones upwards"),
}  # fmt: skip
"""Name and description by kind."""
