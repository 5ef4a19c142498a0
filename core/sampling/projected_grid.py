"""Makes the phase grid of some contours: where its nodes are, and where these lie on the layer above.

Few nodes are searched for on the whole layer above; the others are looked for near the images of their neighbors.
"""

from __future__ import annotations

import numpy as np

from ..contours.contours import Contours
from ..contours.places import long_enough, loop_of
from ..model import BoolArray, FloatArray, IntArray
from ..ragged import following, ranges, starts
from .phase_grid import PhaseGrid, brought_back, image_steps, lengths, linked_grid
from .projector import Projector

# Contour points from node to node, and the least number of nodes of a contour.
STRIDE, LEAST_NODES = 3, 8
# Contour points from node to node of those that are searched for on the whole layer above, and the least number of
# these of a contour; at most every other node is one. The rest is looked for near the images of its neighbors.
SEARCHED, LEAST_SEARCHED = 96, 4
# Neighbors whose images lie farther apart than their own distance and this share of the wavelength are torn.
TEAR = 1.0
# Between torn neighbors this many times as many points are projected.
FINER = 4


def phase_grid(
    projector: Projector, wavelength: float, stride: int = STRIDE, searched_stride: int = SEARCHED
) -> PhaseGrid:
    """A grid with a node for every `stride` contour points, and closer ones where the surface is torn.

    Args:
        projector: made for the contours.
        wavelength: λ, mm.
        stride: contour points from node to node.
        searched_stride: contour points from node to node of those that are searched for on the whole layer above.
    """
    lines = projector.lines
    usable = long_enough(lines.length, wavelength)
    every = _strides(lines, stride)
    many = np.where(usable, -(-np.diff(lines.start) // every), 0)
    loop, rank = np.repeat(np.arange(len(many)), many), ranges(0, many)
    node = lines.start[loop] + rank * every[loop]
    tear = TEAR * wavelength
    searched = rank % np.clip(many // LEAST_SEARCHED, 2, searched_stride // every)[loop] == 0
    above, up = _followed_images(projector, node, loop, searched, usable, tear)
    ahead = following(starts(many))
    step = image_steps(lines, ahead, lengths(lines, lines.arc[node], loop, ahead), above, up, tear)
    torn = np.flatnonzero(np.isnan(step))
    ahead = ahead[torn]
    length = np.where(ahead > torn, node[ahead], lines.start[loop[torn] + 1]) - node[torn]
    finer = max(stride // FINER, 1)
    many = (length - 1) // finer
    between = np.repeat(node[torn], many) + ranges(1, many) * finer
    around = np.repeat(loop[torn], many)
    image, there = _images(projector, between, around, usable)
    node, loop = np.append(node, between), np.append(loop, around)
    order = np.argsort(node, kind="stable")
    node, loop = node[order], loop[order]
    above, up = np.append(above, image)[order], np.append(up, there)[order]
    return linked_grid(lines, node, loop, above, up, tear)


def _strides(lines: Contours, stride: int) -> IntArray:
    """(M,) contour points from node to node."""
    return np.minimum(stride, np.maximum(np.diff(lines.start) // LEAST_NODES, 1))


def _followed_images(
    projector: Projector,
    node: IntArray,
    loop: IntArray,
    searched: BoolArray,
    usable: BoolArray,
    tear: float,
) -> tuple[FloatArray, IntArray]:
    """Images of nodes; those that are `searched`, with the first of each contour, are searched for on the whole layer.

    Where neighbors among these have neighboring images, the images of the nodes between them lie near the line between.
    """
    lines = projector.lines
    above, up = np.full(len(node), np.nan), np.zeros(len(node), dtype=np.int64)
    point, own = node[searched], loop[searched]
    image, there = _images(projector, point, own, usable)
    above[searched], up[searched] = image, there
    arc = lines.arc[point]
    ahead = following(starts(np.bincount(own, minlength=len(lines.layer))))
    length = lengths(lines, arc, own, ahead)
    step = image_steps(lines, ahead, length, image, there, tear)
    owner = np.cumsum(searched) - 1
    smooth = ~np.isnan(step) & (length > 0)
    near = np.flatnonzero(~searched & smooth[owner])
    at, owner = node[near], owner[near]
    slope = step / np.maximum(length, 1e-9)
    guess = brought_back(lines, image[owner] + slope[owner] * (lines.arc[at] - arc[owner]), there[owner])
    place, distance = projector.nearby(projector.spot[at], guess, there[owner])
    above[near], up[near] = np.where(distance <= projector.threshold, place, np.nan), there[owner]
    others = np.flatnonzero(~searched & np.isnan(above))
    above[others], up[others] = _images(projector, node[others], loop[others], usable)
    return above, up


def _images(projector: Projector, point: IntArray, loop: IntArray, usable: BoolArray) -> tuple[FloatArray, IntArray]:
    """Arcs of the images of points of contours on the layer above, and their contours.

    NaN, with some contour, where none is near enough or carries the pattern.
    """
    lines = projector.lines
    above = projector.above(projector.spot[point].view(np.float64).reshape(-1, 2), lines.layer[loop])
    up = loop_of(lines, np.nan_to_num(above))
    above[~usable[up]] = np.nan
    return above, up
