"""The stages of the pattern one by one, from a model to its waves."""

import numpy as np
from dualcolor.core.contours.contours import contours
from dualcolor.core.mesh.triangles import triangulate
from dualcolor.core.pattern.wave import modulated, waved
from dualcolor.core.sampling.paper import paper_samples
from dualcolor.core.sampling.projector import Projector
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.slices import slices

WAVE_OFFSET = PrintSettings(pattern="wave_offset", offset_max=0.3, max_unsupported=0.7)
WAVE = PrintSettings(pattern="wave")


def lines_of(model, settings=WAVE_OFFSET):
    cut = slices(triangulate(model, settings), settings)
    return contours(cut.outlines, cut.loop_polygon, settings)


def sampled(lines, settings=WAVE_OFFSET):
    projector = Projector(lines, settings.projection_threshold)
    return paper_samples(projector, settings), projector


def printed(model, tone, settings=WAVE_OFFSET):
    lines = lines_of(model, settings)
    samples, _ = sampled(lines, settings)
    tones = np.full(len(lines.points), tone)
    depth, set_back = modulated(lines, tones, np.zeros(len(tones)), settings)
    return lines, samples, waved(lines, samples, tones, depth, set_back, settings)
