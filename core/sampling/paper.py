"""The paper's sampling: samples carried up by projection and relaxed, pruned and filled in each layer (Algorithm 1)."""

from __future__ import annotations

import numpy as np

from ..contours.contours import Contours, long_enough, on_loop
from ..model import BoolArray, FloatArray
from ..settings import PrintSettings
from .projector import Projector
from .samples import Samples
from .spacing import SLACK, filled, pruned, relaxed, spacings


def sample(lines: Contours, projector: Projector, settings: PrintSettings) -> Samples:
    """Place samples on every layer from the bottom to the top (paper, Algorithm 1).

    Projection is sequential by nature; within a layer all loops and samples are treated at once.

    Args:
        lines: contours of all layers.
        projector: made for the same contours.
        settings: wavelength and relaxation are used; spacings stay in [λ, 2λ).
    """
    usable = long_enough(lines.length, settings)
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
    """Relax, prune, fill and relax again the samples of one layer; `arc_start` is that of its loops and their end."""
    length, least = np.diff(arc_start), settings.wavelength
    arc = np.sort(arc)
    loop = np.searchsorted(arc_start, arc, side="right") - 1
    if not usable.all():
        keep = usable[loop] if len(length) else np.zeros(len(arc), dtype=bool)
        arc, loop = arc[keep], loop[keep]
    local, loop = relaxed(arc - arc_start[loop], loop, length, settings.relaxation)
    ahead, _ = spacings(local, loop, length)
    if len(ahead) and ahead.min() < least - SLACK:
        local, loop = pruned(local, loop, length, least)
    local, loop = filled(local, loop, length, usable, least)
    local, loop = relaxed(local, loop, length, settings.relaxation)
    return np.sort(on_loop(arc_start[loop] + local, loop, arc_start))
