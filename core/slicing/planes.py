"""The stack of layers: where each is cut, how high it is, how wide its lines are."""

from __future__ import annotations

import numpy as np

from ..errors import MeshError
from ..model import FloatArray, IntArray
from ..records import dataclass
from ..settings import PrintSettings


@dataclass(frozen=True)
class Layers:
    """The stack of L layers.

    Attributes:
        plane: (L,) mm, the height at which each layer's outline is taken, the middle of the layer.
        top: (L,) mm, where the nozzle prints it.
        height: (L,) mm.
    """

    plane: FloatArray
    top: FloatArray
    height: FloatArray

    def __len__(self) -> int:
        return len(self.plane)

    def up_to(self, last: int) -> Layers:
        """The stack without the layers above the last one."""
        return Layers(*(column[: last + 1] for column in (self.plane, self.top, self.height)))


def layer_stack(object_height: float, settings: PrintSettings) -> Layers:
    """The layers of an object `object_height` mm tall, standing on the bed.

    Raises:
        MeshError: the object is too low for a single layer.
    """
    first, usual = settings.first_layer_height, settings.layer_height
    # A layer is printed where the object reaches its middle.
    more = int(np.ceil((object_height - first - usual / 2) / usual - 1e-9))
    if object_height <= first / 2:
        raise MeshError(f"the object is only {object_height:.3g} mm high, less than half a layer", "scale it up")
    height = np.full(1 + max(more, 0), usual)
    height[0] = first
    top = first + usual * np.arange(len(height))
    return Layers(top - height / 2, top, height)


def levels(height: FloatArray, plane: FloatArray) -> IntArray:
    """(N,) how many planes (L,) mm, increasing, lie at each height (N,) mm or below it.

    All layers but the first are equally high, so the number is computed, and searched for only where that is wrong.
    """
    if len(plane) < 3:
        return np.searchsorted(plane, height, side="right")
    place = (height - plane[1]) * ((len(plane) - 2) / (plane[-1] - plane[1])) + 2
    level: IntArray = np.clip(place, 0, len(plane), out=place).astype(np.int64)
    below, above = np.append(-np.inf, plane), np.append(plane, np.inf)
    wrong = np.flatnonzero((height < below.take(level)) | (height >= above.take(level)))
    level[wrong] = np.searchsorted(plane, height[wrong], side="right")
    return level


def line_widths(layer: IntArray, settings: PrintSettings) -> FloatArray:
    """(N,) mm, how wide the lines of object and supports are on (N,) layers; the first one has a width of its own."""
    return np.where(layer == 0, first_line_width(settings), settings.extrusion_width)


def first_line_width(settings: PrintSettings) -> float:
    """Mm, how wide the lines of the object's first layer are: as those of others where it lies on a raft."""
    return settings.extrusion_width if settings.raft_layers else settings.first_layer_extrusion_width


def elephant_foot(settings: PrintSettings) -> float:
    """Mm by which the first layer's outlines are moved inwards, since the bed squashes its lines; 0 on a raft."""
    return 0.0 if settings.raft_layers else settings.elephant_foot_compensation


def middle_heights(layer: IntArray, settings: PrintSettings) -> FloatArray:
    """(N,) mm, how high the middle of (N,) layers lies above the bottom of the object."""
    usual = settings.first_layer_height + (layer - 0.5) * settings.layer_height
    return np.where(layer == 0, settings.first_layer_height / 2, usual)
