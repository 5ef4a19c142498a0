"""The figures of an analysis: heatmap of the seams, tracelines, slopes (paper, Figures 4 e and 10)."""

from __future__ import annotations

import numpy as np

from ..errors import PrintError
from ..model import FloatArray
from ..pictures.viewing import Picture
from ..printability.slopes import DEGRADED_DEG, GONE_DEG, from_flat_deg
from .analysis import NO_SEAMS, Analysis
from .picture import CLAY, Stroke, dots, draw
from .surface_curves import (
    BIRTH_COLOR,
    DEATH_COLOR,
    DEGRADED_COLOR,
    DISCARDED_COLOR,
    FADED_COLOR,
    GONE_COLOR,
    HEAT_COLORS,
    HEAT_STOPS,
    SHORT_COLOR,
    TRACE_COLOR,
    faded_curves,
    heat_colors,
    heat_curves,
    loop_curves,
    sample_points,
    trace_curves,
)


def heatmap(found: Analysis, view: tuple[float, float], pixels: int = 900) -> Picture:
    """Seams on the object: transparent, then green from 0.05, orange 1.5, red 3.0, purple 4.0.

    Places that were not compared, because nothing lies above them, are blue; places without room for the wave are pink.

    Raises:
        PrintError: the pattern has no waves.
    """
    if found.errors is None:
        raise PrintError(NO_SEAMS)
    seams, discarded = heat_curves(found.lines, found.layers.plane, found.errors)
    strokes = [Stroke(discarded, DISCARDED_COLOR, 0.5), *_guards(found)]
    strokes += [Stroke(one, heat_colors(one.value), 1.0 + 0.25 * number) for number, one in enumerate(seams)]
    legend = [(color, f"{stop:g}") for color, stop in zip(HEAT_COLORS, HEAT_STOPS, strict=True)]
    legend += [(DISCARDED_COLOR, f"not compared {found.errors.discarded.mean():.1%}")]
    legend += [(FADED_COLOR, "wave faded"), (SHORT_COLOR, "outline too short")]
    return draw(found.mesh, strokes, view, pixels, legend=legend)


def traceline_picture(found: Analysis, view: tuple[float, float], pixels: int = 900) -> Picture:
    """Tracelines on the object; births and deaths as dots.

    Raises:
        PrintError: the pattern has no waves.
    """
    if found.traced is None:
        raise PrintError(NO_SEAMS)
    lines, plane, samples, traced = found.lines, found.layers.plane, found.samples, found.traced
    strokes = [
        Stroke(trace_curves(lines, plane, samples, traced), TRACE_COLOR, 0.5),
        Stroke(dots(sample_points(lines, plane, samples, traced.birth)), BIRTH_COLOR, 3.0),
        Stroke(dots(sample_points(lines, plane, samples, traced.death)), DEATH_COLOR, 3.0),
    ]
    legend = [
        (TRACE_COLOR, f"{len(traced.start) - 1:,} tracelines"),
        (BIRTH_COLOR, f"{traced.birth.sum():,} births"),
        (DEATH_COLOR, f"{traced.death.sum():,} deaths"),
    ]
    return draw(found.mesh, strokes, view, pixels, legend=legend)


def slope_picture(found: Analysis, view: tuple[float, float], pixels: int = 900) -> Picture:
    """Faces that are too flat for tones."""
    slopes = found.report["slopes"]
    legend = [
        (DEGRADED_COLOR, f"below {DEGRADED_DEG:.0f}°: {slopes['contrast_degraded']:.1%} of the painted contrast"),
        (GONE_COLOR, f"below {GONE_DEG:.0f}°: {slopes['contrast_gone']:.1%}"),
    ]
    return draw(found.mesh, [], view, pixels, slope_colors(found), legend)


def slope_colors(found: Analysis) -> FloatArray:
    """(F, 3) sRGB of the faces."""
    angle = from_flat_deg(found.mesh)[:, None]
    return np.where(angle < GONE_DEG, GONE_COLOR, np.where(angle < DEGRADED_DEG, DEGRADED_COLOR, CLAY))


def _guards(found: Analysis) -> list[Stroke]:
    plane = found.layers.plane
    return [
        Stroke(faded_curves(found.lines, plane, found.faded), FADED_COLOR, 0.5),
        Stroke(loop_curves(found.lines, plane, found.too_short), SHORT_COLOR, 0.75),
    ]
