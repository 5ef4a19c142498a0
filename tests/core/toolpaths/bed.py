"""The reach of both nozzles, layers, and loops by feature, for tests of what stands on the bed."""

import numpy as np
import shapely
import shapely.affinity
from dualcolor.core.paths import Feature, Paths
from dualcolor.core.settings import PrintSettings
from dualcolor.core.slicing.planes import Layers, layer_stack

REACH = shapely.box(-105, -73, 105, 73)
SETTINGS = PrintSettings()


def stack(layers: int, settings: PrintSettings = SETTINGS) -> Layers:
    return layer_stack(layers * settings.layer_height, settings)


def loops_of(paths: Paths, feature: Feature, layer: int | None = None) -> list[np.ndarray]:
    chosen = paths.feature == feature
    if layer is not None:
        chosen &= paths.layer == layer
    return [paths.points[paths.start[path] : paths.start[path + 1]] for path in np.flatnonzero(chosen)]
