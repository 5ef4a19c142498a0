"""The paper's sampling: samples carried up by projection and relaxed, pruned and filled in each layer (Algorithm 1)."""

from __future__ import annotations

import numpy as np

from ..contours.places import long_enough, on_loop
from ..model import BoolArray, FloatArray
from ..settings import PrintSettings
from .projector import Projector
from .samples import Samples
from .spacing import filled, pruned, relaxed


def paper_samples(projector: Projector, settings: PrintSettings) -> Samples:
    """Place samples on every layer from the bottom to the top (paper, section 3.2, Algorithm 1).

    Each layer needs that below it, so layers follow one another; within a layer all loops and samples are treated at
    once.

    Args:
        projector: made for the contours of all layers.
        settings: wavelength and relaxation are used; spacings stay in [λ, 2λ).
    """
    lines = projector.lines
    usable = long_enough(lines.length, settings.wavelength)
    layers = int(lines.layer.max(initial=-1)) + 1
    first_loop = np.searchsorted(lines.layer, np.arange(layers + 1))
    parts: list[FloatArray] = []
    arc = np.zeros(0)
    for layer in range(layers):
        loops = slice(first_loop[layer], first_loop[layer + 1])
        if len(arc):
            place, distance = projector.project(projector.at(arc), np.full(len(arc), layer))
            arc = place[np.isfinite(distance)]
        arc = _settled(arc, lines.arc_start[loops.start : loops.stop + 1], usable[loops], settings)
        parts.append(arc)
    return Samples.on(lines, np.concatenate(parts) if parts else arc)


def _settled(arc: FloatArray, arc_start: FloatArray, usable: BoolArray, settings: PrintSettings) -> FloatArray:
    """The samples of one layer from those projected onto it: what Algorithm 1 does in each round after the projection.

    A contour without samples, as all are on the base layer, gets ⌊A/λ⌋ of them, evenly spaced.

    Args:
        arc: (S,) mm, the projected samples.
        arc_start: (M + 1,) mm, where the layer's contours begin, and where the last one ends.
        usable: (M,) which of them are long enough for the pattern; the others get no samples.
        settings: wavelength and relaxation are used.

    Returns:
        (S',) mm, increasing.
    """
    length, wavelength, share = np.diff(arc_start), settings.wavelength, settings.relaxation
    arc = np.sort(arc)
    loop = np.searchsorted(arc_start, arc, side="right") - 1
    if not usable.all():
        keep = usable[loop] if len(length) else np.zeros(len(arc), dtype=bool)
        arc, loop = arc[keep], loop[keep]
    local, loop = relaxed(arc - arc_start[loop], loop, length, share)
    local, loop = pruned(local, loop, length, wavelength)
    local, loop = filled(local, loop, length, usable, wavelength)
    local, loop = relaxed(local, loop, length, share)
    return np.sort(on_loop(arc_start[loop] + local, loop, arc_start))
